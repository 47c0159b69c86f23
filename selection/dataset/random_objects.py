"""Random objects that a gripper can take: what they are declared to be, and what they really are.

A shape is drawn evenly, a material from the prior, then size and properties until the object can be held,
then a place and a yaw until the arm reaches it. An object depends on the seed and its own number alone.

What is drawn again, for no grip could hold it or nothing could stand there:

- what lies outside the ranges (the simulator's);
- friction that does not carry the weight: ``2 mu F < 1.5 m g`` at the grip ``F = min(0.35 E A, 18 N)``, where A is
  the smaller of pad and V / L, 0.35 and 18 N the compression and the force at which a grasp counts as tight;
- what the gripper hardly feels: less than 6 N, ten steps of its current, at a tight grasp of all its width,
  ``0.35 E V / L``;
- what sags by more than a tenth under its own weight, ``rho g h > 0.1 E``;
- what is more than twice as tall as its shorter horizontal edge, or taller at all and round below, and would
  topple at a touch.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from dynamics.errors import InvalidInput
from dynamics.gripper import ParallelGripper, robotiq_2f85
from dynamics.objects import DeclaredObject, read_declared, read_size
from dynamics.shapes import SHAPES, Lengths, Shape, tied_to
from dynamics.tables import Table, read_toml
from estimation.network import LOG, MATERIAL, UNKNOWN, Network
from selection.actions.hand import GRIP_EFFORT, GRIP_STRAIN

GRAVITY = 9.81  # m/s^2
HOLDING_SAFETY = 1.5
LEAST_FELT = 6.0  # N
MOST_SAG = 0.1  # compression by its own weight
MOST_SLENDER = 2.0  # height over the shorter horizontal edge
TRIES = 400  # draws of size and properties before a material is given up
PLACES = 200  # draws of a place
DRAWN_SHAPES: tuple[Shape, ...] = tuple(shape for shape in SHAPES if shape != "mesh")
ROUND_BELOW: tuple[Shape, ...] = ("sphere", "ellipsoid")  # they stand on a point

Range = tuple[float, float]
Reaches = Callable[[DeclaredObject], bool]


@dataclass(frozen=True)
class Ranges:
    """Within which objects are drawn: the limits of the simulator, the gripper and the table.

    Attributes:
        young_modulus: of soft objects, and of what is of no known material [Pa].
        rigid: of what the simulator makes rigid, and what would not give by a tenth of a step of the gripper's
            opening if it were not; between the two nothing is drawn [Pa].
        mass: [kg].
        friction: [-].
        poisson: [-]; 0 only by default, for elasticity is then exactly what a squeeze between pads shows.
        grasped_edge: the horizontal edge that the pads close on [m].
        other_edge: the other horizontal one [m].
        height: [m].
        size_sd: of each declared edge; the true one differs by it, at most twofold [m].
        radius: of the place about the arm's base [m].
        x, y: of the place, so that the object stands on the table [m].
        shapes: which are drawn, evenly.
    """

    young_modulus: Range = (5e3, 1e6)
    rigid: Range = (3e7, 1e12)
    mass: Range = (0.004, 1.0)
    friction: Range = (0.2, 1.0)
    poisson: Range = (0.0, 0.0)
    grasped_edge: Range = (0.025, 0.075)
    other_edge: Range = (0.025, 0.110)
    height: Range = (0.030, 0.110)
    size_sd: float = 0.0005
    radius: Range = (0.27, 0.66)
    x: Range = (-0.20, 0.80)
    y: Range = (-0.70, 0.70)
    shapes: tuple[Shape, ...] = DRAWN_SHAPES


@dataclass(frozen=True)
class RandomObject:
    """One object, as an object file says it.

    Attributes:
        declared: what a user would know of it.
        size: true edge lengths [m].
        mass: [kg].
        young_modulus: [Pa].
        poisson, friction: [-].
        material: its name in the reference, or ``unknown``.
    """

    declared: DeclaredObject
    size: Lengths
    mass: float
    young_modulus: float
    poisson: float
    friction: float
    material: str

    def tables(self, about: str) -> Mapping[str, Any]:
        """Return the content of the object's file, as `selection.run --object` takes it."""
        known = self.declared
        return {
            "about": about,
            "declared": {
                "name": known.name,
                "shape": known.shape,
                **_size_keys(known.shape, known.size),
                "size_sd_m": known.size_sd,
                "position_m": list(known.position),
                "yaw_deg": _short(math.degrees(known.yaw)),
            },
            "truth": {
                "material": self.material,
                **_size_keys(known.shape, self.size),
                "mass_kg": self.mass,
                "young_modulus_pa": self.young_modulus,
                "poisson": self.poisson,
                "friction": self.friction,
            },
        }

    @property
    def volume(self) -> float:
        """True volume [m^3]."""
        return replace(self.declared, size=self.size).volume


def read_object(path: Path) -> RandomObject:
    """Return an object from the file that was made of it.

    Raises:
        InvalidInput: for a file that is missing or malformed.
    """
    declared = read_declared(path)
    table = Table(str(path), read_toml(path)).table("truth")
    return RandomObject(
        replace(declared, source="declared object"),
        read_size(table, declared.shape, declared.size),
        table.number("mass_kg"),
        table.number("young_modulus_pa"),
        table.number("poisson"),
        table.number("friction"),
        table.text("material"),
    )


class Sampler:
    """Draws objects.

    Args:
        network: whose materials they are made of.
        ranges: within which they lie.

    Raises:
        InvalidInput: if none of the materials lies within the ranges.
    """

    def __init__(self, network: Network, ranges: Ranges | None = None) -> None:
        self.network, self.ranges = network, ranges or Ranges()
        self._gripper = robotiq_2f85()
        bank = network.hypotheses
        self._materials = network.classes(MATERIAL)
        weight = np.bincount(bank.material, np.exp(bank.log_weight), len(self._materials))
        self._prior = weight / weight.sum()

    def draw(self, seed: int, index: int, reaches: Reaches | None = None) -> RandomObject:
        """Return the object of a number.

        Args:
            seed, index: of the series, and of the object in it.
            reaches: tells whether an object can be grasped where it stands; all of the annulus if None.
        """
        rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(index, 0)))
        drawn = self._made_of_something(f"object-{index:06d}", rng)
        for _ in range(PLACES):
            yaw = math.radians(_short(rng.uniform(-180.0, 180.0)))
            declared = replace(drawn.declared, position=self._place(rng), yaw=yaw)
            if reaches is None or reaches(declared):
                return replace(drawn, declared=declared)
        raise InvalidInput("random object: place", f"{PLACES} out of reach", "an annulus that the arm reaches")

    def _made_of_something(self, name: str, rng: np.random.Generator) -> RandomObject:
        """Draw shape and material, and an object that can be held; a material of which none can is left out."""
        shape = self.ranges.shapes[int(rng.integers(len(self.ranges.shapes)))]
        prior = self._prior.copy()
        while prior.sum() > 0:
            chosen = int(rng.choice(len(prior), p=prior / prior.sum()))
            for _ in range(TRIES):
                drawn = self._made_of(self._materials[chosen], shape, name, rng)
                if self._is_within(drawn) and can_be_held(drawn, self._gripper):
                    return drawn
            prior[chosen] = 0.0
        raise InvalidInput(
            f"reference {self.network.name}",
            f"no material that can be made and held: {', '.join(self.network.materials)}",
            "elasticity {:g} to {:g} or {:g} to {:g} Pa, mass {:g} to {:g} kg, friction {:g} to {:g}".format(
                *self.ranges.young_modulus, *self.ranges.rigid, *self.ranges.mass, *self.ranges.friction
            ),
        )

    def _made_of(self, material: str, shape: Shape, name: str, rng: np.random.Generator) -> RandomObject:
        """Draw an object of a material and a shape, not yet anywhere."""
        ranges = self.ranges
        known = self._size(shape, rng)
        off = np.clip(rng.standard_normal(3), -2, 2) * ranges.size_sd
        x, y, z = (_short(edge + float(error)) for edge, error in zip(known, off, strict=True))
        declared = DeclaredObject(name, shape, known, ranges.size_sd, (0.0, 0.0), 0.0)
        size = _tied(shape, (x, y, z))
        modulus = self._value("elasticity", material, rng)
        density = self._value("density", material, rng)
        friction = self._value("friction", material, rng)
        volume = replace(declared, size=size).volume
        return RandomObject(
            declared=declared,
            size=size,
            mass=_short(_log_uniform(ranges.mass, rng) if density is None else density * volume),
            young_modulus=_short(_log_uniform(ranges.young_modulus, rng) if modulus is None else modulus),
            poisson=_short(float(rng.uniform(*ranges.poisson))),
            friction=_short(float(rng.uniform(*ranges.friction)) if friction is None else friction),
            material=material,
        )

    def _is_within(self, drawn: RandomObject) -> bool:
        ranges = self.ranges
        return (
            any(_lies(drawn.young_modulus, bounds) for bounds in (ranges.young_modulus, ranges.rigid))
            and _lies(drawn.mass, ranges.mass)
            and _lies(drawn.friction, ranges.friction)
        )

    def _size(self, shape: Shape, rng: np.random.Generator) -> Lengths:
        """Draw the declared extents; the one that is grasped lies along x or y, of round ones both can be."""
        ranges = self.ranges
        grasped, other = float(rng.uniform(*ranges.grasped_edge)), float(rng.uniform(*ranges.other_edge))
        height = float(rng.uniform(*ranges.height))
        x, y = (grasped, other) if rng.integers(2) else (other, grasped)
        if len(tied_to(shape, 0)) > 1:
            x = y = grasped
        return _tied(shape, (_short(x, 4), _short(y, 4), _short(height, 4)))

    def _value(self, quantity: str, material: str, rng: np.random.Generator) -> float | None:
        """Draw a property of a material; None where the reference does not tell."""
        if material == UNKNOWN or quantity not in self.network.property_names:
            return None
        prop = self.network.property(quantity)
        if prop.parent not in (None, MATERIAL):
            return None
        row = 0 if prop.parent is None else self.network.materials.index(material)
        x = float(rng.normal(prop.location[row], prop.spread[row]))
        return math.exp(min(x, 700.0)) if prop.scale == LOG else x

    def _place(self, rng: np.random.Generator) -> tuple[float, float]:
        """Draw a place, evenly over the part of the annulus that is table."""
        inner, outer = self.ranges.radius
        while True:
            radius = math.sqrt(rng.uniform(inner**2, outer**2))
            angle = rng.uniform(-math.pi, math.pi)
            x, y = radius * math.cos(angle), radius * math.sin(angle)
            if self.ranges.x[0] <= x <= self.ranges.x[1] and self.ranges.y[0] <= y <= self.ranges.y[1]:
                return _short(x, 4), _short(y, 4)


def can_be_held(drawn: RandomObject, gripper: ParallelGripper) -> bool:
    """Tell whether a grip can hold an object, by the rule at the top of this file."""
    x, y, height = drawn.size
    grasped = min(x, y)
    face = drawn.volume / grasped
    tight = GRIP_STRAIN * drawn.young_modulus
    force = min(tight * min(face, gripper.pad_area), GRIP_EFFORT * gripper.force_per_ampere)
    weight = GRAVITY * drawn.mass
    return (
        2 * drawn.friction * force >= HOLDING_SAFETY * weight
        and tight * face >= LEAST_FELT
        and weight / (drawn.volume / height) <= MOST_SAG * drawn.young_modulus
        and height <= (1.0 if drawn.declared.shape in ROUND_BELOW else MOST_SLENDER) * grasped
    )


def _tied(shape: Shape, size: Lengths) -> Lengths:
    """Return a size with those extents equal that are one length of the shape."""
    x, y, z = (size[tied_to(shape, axis)[0]] for axis in range(3))
    return x, y, z


def _size_keys(shape: Shape, size: Lengths) -> dict[str, Any]:
    """Return a size as object files say it."""
    if shape == "sphere":
        return {"diameter_m": size[0]}
    if shape == "cylinder":
        return {"diameter_m": size[0], "height_m": size[2]}
    return {"size_m": list(size)}


def _lies(value: float, within: Range) -> bool:
    return within[0] <= value <= within[1]


def _log_uniform(bounds: Range, rng: np.random.Generator) -> float:
    return math.exp(rng.uniform(math.log(bounds[0]), math.log(bounds[1])))


def _short(value: float, digits: int = 6) -> float:
    """Round to so many digits that count: files stay readable, and say all there is."""
    return float(f"{value:.{digits}g}")
