"""A trajectory as the few waypoints that the arm takes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from dynamics.errors import MotionRefused
from dynamics.trajectory import Trajectory

Array = NDArray[np.float64]

TOLERANCE = 0.002  # rad between the trajectory and the spline through its waypoints
FIRST_SPACING = 0.5  # s
MAX_WAYPOINTS = 100
STRETCH = 1.02  # longer durations than by this are avoided by more waypoints
ROUNDING = 0.999  # share of the speed limit to keep to: the wire carries angles in single precision


@dataclass(frozen=True)
class Waypoints:
    """Positions along a trajectory, without its start.

    Attributes:
        q: joint positions [rad], (N, nv).
        durations: time to each from the one before [s], (N,).
        deviation: the most a joint of the spline through them is off the trajectory [rad].
    """

    q: Array
    durations: Array
    deviation: float


def waypoints(trajectory: Trajectory, speed_limit: Array, tolerance: float = TOLERANCE) -> Waypoints:
    """Return the fewest evenly timed waypoints whose cubic spline, from rest to rest, is the trajectory.

    The arm runs a spline through angular waypoints at the given durations, and few waypoints keep its own check
    and the wire small. Between them the spline may run a little faster than the trajectory: all durations are
    stretched by what keeps it within the speed limit.

    Args:
        trajectory: the motion.
        speed_limit: of each joint [rad/s], (nv,).
        tolerance: how far the spline may be off [rad].

    Raises:
        MotionRefused: if no ``MAX_WAYPOINTS`` come within the tolerance, as with a sharp corner.
    """
    count = max(int(np.ceil(trajectory.duration / FIRST_SPACING)), 2)
    while True:
        times = np.linspace(0.0, trajectory.duration, count + 1)
        knots = np.array([trajectory.position(time) for time in times])
        spline = CubicSpline(times, knots, bc_type="clamped")
        deviation = float(np.abs(spline(trajectory.time) - trajectory.q).max())
        dense = np.linspace(0.0, trajectory.duration, 20 * count + 1)
        excess = float((np.abs(spline(dense, 1)) / (ROUNDING * speed_limit)).max())
        if deviation <= tolerance and (excess <= STRETCH or count == MAX_WAYPOINTS):
            return Waypoints(knots[1:], np.diff(times) * max(excess, 1.0), deviation)
        if count == MAX_WAYPOINTS:
            raise MotionRefused(
                f"the trajectory is {np.degrees(deviation):.2f} deg off a smooth run through {count} waypoints; "
                f"valid: {np.degrees(tolerance):.2f} deg. A sharp corner needs two trajectories."
            )
        count = min(int(np.ceil(1.5 * count)), MAX_WAYPOINTS)
