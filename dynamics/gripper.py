"""A parallel gripper: how far its pads are apart, where they are, and what its motor current says of force."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from dynamics.errors import InvalidInput

Array = NDArray[np.float64]
LoadSpread = Literal["face", "pad"]


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
    load_spread: LoadSpread = "pad"
    stiffness_sd: float = 0.0

    @property
    def pad_area(self) -> float:
        """Area of one pad's face [m^2]."""
        return self.pad_width * self.pad_length

    def opening(self, crank_angle: float) -> float:
        """Return the opening at an angle of the cranks from the approach direction [m]."""
        return 2 * (self.crank_offset + self.crank_length * math.sin(crank_angle))

    @property
    def driver_range(self) -> float:
        """Angle that the drivers turn from open to closed [rad]."""
        return self.crank_angle(self.max_opening) - self.crank_angle(0.0)

    def opening_at_driver(self, driver: float) -> float:
        """Return the opening at a driver angle, 0 when open and growing as it closes [m].

        Raises:
            InvalidInput: for an angle that the driver does not reach.
        """
        _within("gripper: driver angle [rad]", driver, -0.02, self.driver_range + 0.02)
        return self.opening(self.crank_angle(self.max_opening) - driver)

    def opening_at_percent(self, percent: float) -> float:
        """Return the opening at the reported position, 0 open to 100 closed, linear in the opening [m].

        Robotiq's count is nearly linear in the distance of the pads, not in the drivers' angle.

        Raises:
            InvalidInput: for a percentage out of [-2, 102]: perhaps a share of 1, or a count.
        """
        _within("gripper: position [%]", percent, -2.0, 102.0)
        return self.max_opening * (1 - percent / 100.0)

    def pad_force(self, torque: float, opening: float) -> float:
        """Return what one pad presses with when a torque turns the drivers, both together [N].

        By virtual work: half the torque on each crank, F = torque / 2 / (crank_length cos(crank angle)).

        Args:
            torque: of the actuator on both drivers, closing positive [N m].
            opening: distance of the pads [m].
        """
        return torque / 2 / (self.crank_length * math.cos(self.crank_angle(opening)))

    def force(self, effort: Array, air: float = 0.0) -> Array:
        """Return what one pad presses with while the gripper closes, from its motor current [N], (N,).

        F = force_per_ampere (effort - air) + friction_force where the current is above its value in air, else 0.
        Its standard deviation is in :meth:`force_sd`. A locked gripper's current says nothing of force.

        Args:
            effort: motor current of moving pads [A], (N,).
            air: what the current is while closing on nothing [A].
        """
        above = np.asarray(effort, dtype=np.float64) - air
        force: Array = np.where(above > 0, self.force_per_ampere * above + self.friction_force, 0.0)
        return force

    def force_sd(self, force: Array) -> Array:
        """Return the standard deviation that the calibration puts on a force, common to all readings [N], (N,)."""
        gain = self.force_per_ampere_sd / self.force_per_ampere * (force - self.friction_force)
        return np.hypot(gain, self.friction_force_sd)

    def crank_angle(self, opening: float) -> float:
        """Return the cranks' angle from the approach direction at an opening [rad].

        Raises:
            InvalidInput: for an opening that the cranks cannot have.
        """
        sine = (opening / 2 - self.crank_offset) / self.crank_length
        if not -1 <= sine <= 1:
            raise InvalidInput(f"{self.name}: opening", opening, f"0 to {self.max_opening} m")
        return math.asin(sine)

    def swing(self, opening: float) -> float:
        """Return how far the pads come down per way that each of them closes, at an opening [-].

        A pad on a crank moves at a right angle to it: the tangent of the cranks' angle.
        """
        return math.tan(self.crank_angle(opening))

    def pad_depth(self, opening: float) -> float:
        """Return the distance from the flange to the pads' centre [m]; pads swing outward as they close."""
        reach = self.crank_length * math.cos(self.crank_angle(opening))
        return self.crank_height + reach + self.pad_height


def robotiq_2f85(load_spread: LoadSpread = "pad") -> ParallelGripper:
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


def calibrate_force(force: Array, effort: Array, air: float) -> tuple[float, float]:
    """Return the force per ampere and its standard deviation, from a scale between the pads [N/A].

    The least-squares slope of the force that a scale shows over the current above its value in air, with an
    intercept for what friction swallows.

    Args:
        force: of the scale, while the gripper closes [N], (N,).
        effort: motor current at the same instants [A], (N,).
        air: what the current is while closing on nothing [A].

    Raises:
        InvalidInput: for fewer than 3 readings, wrong shapes, or a current that does not vary.
    """
    f, i = np.asarray(force, dtype=np.float64), np.asarray(effort, dtype=np.float64) - air
    if f.ndim != 1 or f.shape != i.shape or len(f) < 3 or not np.all(np.isfinite(f) & np.isfinite(i)):
        raise InvalidInput("force calibration", f"shapes {f.shape} and {i.shape}", "two equal shapes (N,), N >= 3")
    spread = float(np.sum((i - i.mean()) ** 2))
    if spread == 0:
        raise InvalidInput("force calibration: effort [A]", float(i[0]) + air, "currents that differ")
    slope = float(np.sum((i - i.mean()) * f)) / spread
    residual = f - f.mean() - slope * (i - i.mean())
    return slope, math.sqrt(float(np.sum(residual**2)) / (len(f) - 2) / spread)


def _within(where: str, value: float, low: float, high: float) -> None:
    if not (math.isfinite(value) and low <= value <= high):
        raise InvalidInput(where, value, f"a number from {low:g} to {high:g}")
