"""What an object really is, for the simulator alone: the truth that the exploration has to find."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from dynamics.errors import InvalidInput
from dynamics.objects import DeclaredObject, read_declared, read_size
from dynamics.shapes import Lengths, Shape
from dynamics.tables import Table, read_toml

RIGID_ABOVE = 1e6  # Pa; stiffer bodies give way less than pads and drive do, and are simulated as rigid ones
SOFTEST, HARDEST = 4e3, 1e12  # Pa
LIGHTEST, HEAVIEST = 0.002, 1.2  # kg
SIZE_SDS = 6.0  # a true length is that many standard deviations from the declared one at most


@dataclass(frozen=True)
class TrueObject:
    """The physics of a simulated object.

    Attributes:
        declared: what its user knows, which gives shape and place.
        size: the true lengths of its bounding box [m].
        mass: [kg].
        young_modulus: [Pa]; a body stiffer than ``RIGID_ABOVE`` is simulated as a rigid one.
        poisson: Poisson's ratio [-].
        friction: coefficient of friction against pads and table [-].
        damping: time constant of its stiffness-proportional damping [s].
        material: name of its material in the reference, or ``unknown``.
        category: name of its category in references that have them, or ``unknown``.
        yield_strain: elastic strain (von Mises) beyond which it flows and does not spring back [-]; 0 if it never
            does.
    """

    declared: DeclaredObject
    size: Lengths
    mass: float
    young_modulus: float
    poisson: float
    friction: float
    damping: float
    material: str
    category: str = "unknown"
    yield_strain: float = 0.0

    @property
    def shape(self) -> Shape:
        """Its shape, which its user knows."""
        return self.declared.shape

    @property
    def is_rigid(self) -> bool:
        """Whether it is simulated as a rigid body."""
        return self.young_modulus > RIGID_ABOVE

    @property
    def volume(self) -> float:
        """Volume [m^3]."""
        return self.declared.fill * math.prod(self.size)

    @property
    def density(self) -> float:
        """Mass per volume [kg/m^3]."""
        return self.mass / self.volume


def read_truth(path: Path) -> TrueObject:
    """Read an object file with its truth.

    Raises:
        InvalidInput: for a file that is missing or malformed, or a truth that what is declared cannot mean, naming
            key, value and what is valid.
    """
    declared = read_declared(path)
    table = Table(str(path), read_toml(path)).table("truth")
    table.text("shape", declared.shape, (declared.shape,))
    truth = TrueObject(
        declared=declared,
        size=_size(table, declared),
        mass=table.number("mass_kg", at_least=LIGHTEST, at_most=HEAVIEST, unit="kg"),
        young_modulus=table.number("young_modulus_pa", at_least=SOFTEST, at_most=HARDEST, unit="Pa"),
        poisson=table.number("poisson", 0.0, at_least=0.0, at_most=0.45),
        friction=table.number("friction", 0.8, at_least=0.2, at_most=1.0),
        damping=table.number("damping_s", 0.002, at_least=0.0, at_most=0.02, unit="s"),
        material=table.text("material", "unknown"),
        category=table.text("category", "unknown"),
        yield_strain=table.number("yield_strain", 0.0, at_least=0.0, at_most=0.5),
    )
    table.done()
    if truth.is_rigid and truth.yield_strain > 0:
        raise InvalidInput(
            f"{table.where}: yield_strain", truth.yield_strain, f"0 for a body stiffer than {RIGID_ABOVE:g} Pa"
        )
    return truth


def _size(table: Table, declared: DeclaredObject) -> Lengths:
    """Return the true lengths, refusing those that contradict the declared ones."""
    size = read_size(table, declared.shape, declared.size)
    reach = SIZE_SDS * declared.size_sd
    if any(abs(true - known) > reach for true, known in zip(size, declared.size, strict=True)):
        raise InvalidInput(
            f"{table.where}: size [m]",
            list(size),
            f"the declared {list(declared.size)} to {SIZE_SDS:g} of its standard deviations, {reach:g}",
        )
    return size
