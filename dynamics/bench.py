"""A bench as its user sees it: two plates that close on an object along a line and read opening and force."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, Protocol, runtime_checkable

from dynamics.errors import InvalidInput
from dynamics.gripper import ParallelGripper
from dynamics.signals import Phase

Plates = Literal["pads", "full"]
PLATES: tuple[Plates, ...] = ("pads", "full")

SPEEDS = (1e-4, 0.3)  # m/s of closing
LONGEST_DWELL = 60.0  # s


@dataclass(frozen=True)
class Stroke:
    """One closing of the plates from outside the object, a dwell, and the way back.

    Attributes:
        speed: at which the opening closes, both plates together [m/s].
        target: commanded opening at the end [m]; negative where each plate is to push its way past the middle, so
            that the drive's give makes it a force.
        dwell: how long the plates stay there [s].
        stiffness: of each plate's drive [N/m]; None for a drive that does not give against the object.
        max_force: at which the plates stop closing [N].

    Raises:
        InvalidInput: for a number out of range.
    """

    speed: float
    target: float
    dwell: float = 0.2
    stiffness: float | None = None
    max_force: float = math.inf

    def __post_init__(self) -> None:
        if not (math.isfinite(self.speed) and SPEEDS[0] <= self.speed <= SPEEDS[1]):
            raise InvalidInput("stroke: speed [m/s]", self.speed, f"a number from {SPEEDS[0]:g} to {SPEEDS[1]:g}")
        if not (math.isfinite(self.target) and abs(self.target) <= 1):
            raise InvalidInput("stroke: target [m]", self.target, "an opening from -1 to 1 m")
        if not (math.isfinite(self.dwell) and 0 <= self.dwell <= LONGEST_DWELL):
            raise InvalidInput("stroke: dwell [s]", self.dwell, f"a number from 0 to {LONGEST_DWELL:g}")
        if self.stiffness is not None and not (math.isfinite(self.stiffness) and self.stiffness > 0):
            raise InvalidInput("stroke: stiffness [N/m]", self.stiffness, "a finite number > 0")
        if not self.max_force > 0:
            raise InvalidInput("stroke: max_force [N]", self.max_force, "a number > 0")


@runtime_checkable
class SqueezeBench(Protocol):
    """Two plates and an object between them, in SI units."""

    @property
    def gripper(self) -> ParallelGripper:
        """The plates, described as a gripper: their size, and what their readings mean."""
        ...

    @property
    def edge(self) -> int:
        """Which edge of the object the plates close on: 0 for its x, 1 for its y, 2 for its z."""
        ...

    def squeeze(self, stroke: Stroke) -> tuple[Phase, ...]:
        """Squeeze the object once and return its phases ``air``, ``compress``, ``dwell``, ``release``.

        Samples have no joints; the effort is the current that would press as the plates' force sensors feel, at
        rest as well.

        Raises:
            InvalidInput: for a stroke that would crush the object.
        """
        ...
