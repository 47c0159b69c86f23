"""What an object really is, for the simulator alone: the truth that the exploration has to find."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from dynamics.objects import DeclaredObject, read_declared
from dynamics.tables import Table, read_toml


@dataclass(frozen=True)
class TrueObject:
    """The physics of a simulated object.

    Attributes:
        declared: what its user knows, which gives shape and place.
        size: its true edge lengths [m].
        mass: [kg].
        young_modulus: [Pa].
        poisson: Poisson's ratio [-].
        friction: coefficient of friction against pads and table [-].
        damping: time constant of its stiffness-proportional damping [s].
        material: name of its material in the reference, or ``unknown``.
        category: name of its category in references that have them, or ``unknown``.
    """

    declared: DeclaredObject
    size: tuple[float, float, float]
    mass: float
    young_modulus: float
    poisson: float
    friction: float
    damping: float
    material: str
    category: str = "unknown"

    @property
    def volume(self) -> float:
        """Volume [m^3]."""
        return self.size[0] * self.size[1] * self.size[2]

    @property
    def density(self) -> float:
        """Mass per volume [kg/m^3]."""
        return self.mass / self.volume


def read_truth(path: Path) -> TrueObject:
    """Read an object file with its truth.

    Raises:
        InvalidInput: for a file that is missing or malformed, naming key, value and what is valid.
    """
    declared = read_declared(path)
    table = Table(str(path), read_toml(path)).table("truth")
    length, width, height = table.numbers("size_m", 3, declared.size, at_least=0.02, at_most=0.3, unit="m")
    truth = TrueObject(
        declared=declared,
        size=(length, width, height),
        mass=table.number("mass_kg", at_least=0.002, at_most=1.2, unit="kg"),
        young_modulus=table.number("young_modulus_pa", at_least=4e3, at_most=1.2e6, unit="Pa"),
        poisson=table.number("poisson", 0.0, at_least=0.0, at_most=0.45),
        friction=table.number("friction", 0.8, at_least=0.2, at_most=1.0),
        damping=table.number("damping_s", 0.002, at_least=0.0, at_most=0.02, unit="s"),
        material=table.text("material", "unknown"),
        category=table.text("category", "unknown"),
    )
    table.done()
    return truth
