"""A parallel gripper: how far its pads are apart, where they are, and what its motor current says of force."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from dynamics.errors import InvalidInput


@dataclass(frozen=True)
class ParallelGripper:
    """What is known of a two-finger gripper whose pads stay parallel.

    Attributes:
        name: what the gripper is called.
        max_opening: distance of the pads when fully open [m].
        pad_width, pad_length: size of a pad's face, across and along the approach direction [m].
        min_speed, max_speed: closing speeds the gripper can run at [m/s].
        crank_length, crank_offset: the pads swing on cranks; half the opening is
            ``crank_offset + crank_length sin(angle)`` [m].
        crank_height, pad_height: height of the cranks' pivot over the flange, and of the pads' centre over
            the cranks' end [m].
        opening_quantum: step of the reported opening [m].
        effort_quantum: step of the reported motor current [A].
        force_per_ampere, force_per_ampere_sd: pad force per motor current while closing [N/A].
        friction_force, friction_force_sd: pad force that friction swallows before any current rises above
            its value in air [N].
        tool_depth: distance of the arm's tool frame from the flange [m].
        stiffness: of fingers and pads in series with the object [N/m]; infinite if it does not matter.
        stiffness_sd: its standard deviation [N/m].
        load_spread: what the pads' load does in the object: ``face`` when the whole face is compressed evenly,
            ``pad`` when pads smaller than the face indent it.
    """

    name: str
    max_opening: float
    pad_width: float
    pad_length: float
    min_speed: float
    max_speed: float
    crank_length: float
    crank_offset: float
    crank_height: float
    pad_height: float
    opening_quantum: float
    effort_quantum: float
    force_per_ampere: float
    force_per_ampere_sd: float
    friction_force: float = 0.0
    friction_force_sd: float = 0.0
    stiffness: float = math.inf
    tool_depth: float = 0.12
    load_spread: Literal["face", "pad"] = "pad"
    stiffness_sd: float = 0.0

    @property
    def pad_area(self) -> float:
        """Area of one pad's face [m^2]."""
        return self.pad_width * self.pad_length

    def crank_angle(self, opening: float) -> float:
        """Return the cranks' angle from the approach direction at an opening [rad].

        Raises:
            InvalidInput: for an opening that the cranks cannot have.
        """
        sine = (opening / 2 - self.crank_offset) / self.crank_length
        if not -1 <= sine <= 1:
            raise InvalidInput(f"{self.name}: opening", opening, f"0 to {self.max_opening} m")
        return math.asin(sine)

    def pad_depth(self, opening: float) -> float:
        """Return the distance from the flange to the pads' centre [m]; pads swing outward as they close."""
        reach = self.crank_length * math.cos(self.crank_angle(opening))
        return self.crank_height + reach + self.pad_height


def robotiq_2f85(load_spread: Literal["face", "pad"] = "pad") -> ParallelGripper:
    """Return the Robotiq 2F-85.

    Sizes and speeds are Robotiq's; opening and current are read in steps of 1/227 of the stroke and of 10 mA.
    The force of a current is not published ("cannot be converted into newtons" in general): 60 N/A +- 10 %
    is an assumption of the order of the maker's force range, to be replaced by a calibration of one's own.
    """
    return ParallelGripper(
        name="2f85",
        max_opening=0.085,
        pad_width=0.022,
        pad_length=0.0375,
        min_speed=0.020,
        max_speed=0.150,
        crank_length=0.0575,
        crank_offset=0.0055,
        crank_height=0.061,
        pad_height=0.029,
        opening_quantum=0.085 / 227,
        effort_quantum=0.01,
        force_per_ampere=60.0,
        force_per_ampere_sd=6.0,
        friction_force=0.5,
        friction_force_sd=0.3,
        load_spread=load_spread,
    )
