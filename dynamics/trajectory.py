"""A timed motion of the joints, and how a path becomes one: from rest to rest, jerk-limited."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dynamics.arm import Arm
from dynamics.errors import InvalidInput

Array = NDArray[np.float64]

STEP = 0.01  # s between the stored positions
JERK_TIME = 0.15  # s in which an acceleration limit may be built up


@dataclass(frozen=True)
class Trajectory:
    """Joint positions over time.

    Attributes:
        time: [s], from 0, increasing, (N,).
        q: joint positions [rad], (N, nv).
    """

    time: Array
    q: Array

    @property
    def duration(self) -> float:
        """Time from the first to the last position [s]."""
        return float(self.time[-1])

    def position(self, time: float) -> Array:
        """Return the joint positions at a time, linear between the stored ones [rad], (nv,)."""
        if time >= self.time[-1]:
            return np.array(self.q[-1])
        upper = max(int(np.searchsorted(self.time, time, side="right")), 1)
        share = (time - self.time[upper - 1]) / (self.time[upper] - self.time[upper - 1])
        position: Array = (1 - share) * self.q[upper - 1] + share * self.q[upper]
        return position


def time_path(arm: Arm, path: Array, speed: float = 0.6) -> Trajectory:
    """Time a path so that no joint exceeds its speed and acceleration limit.

    The path is followed by one scalar, from rest to rest: position s along it, with
    |ds/dt| <= min_j v_j / |dq_j/ds| and |d2s/dt2| <= min_j a_j / |dq_j/ds| over its segments, and jerk
    limited to the acceleration limit over JERK_TIME: the motion stays on the path that was checked. The profile is
    time-optimal, by Ruckig (Berscheid and Kroeger, RSS 2021).

    Args:
        arm: gives the limits.
        path: joint positions [rad], (N, nv), a polyline fine enough to be smooth; sharp corners need two calls.
        speed: share of the limits to use, in (0, 1].

    Raises:
        InvalidInput: for a speed out of range or a path of the wrong shape.
    """
    if not 0 < speed <= 1:
        raise InvalidInput("motion: speed", speed, "a share of the limits in (0, 1]")
    points = np.asarray(path, float)
    if points.ndim != 2 or points.shape[1] != arm.nv or not np.all(np.isfinite(points)):
        raise InvalidInput("motion: path", f"shape {points.shape}", f"finite positions, (N, {arm.nv})")
    steps = np.diff(points, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    if not np.any(lengths > 1e-9):
        return Trajectory(np.array([0.0, STEP]), points[[-1, -1]])
    moving = lengths > 1e-12
    slope = np.abs(steps[moving] / lengths[moving, None]).max(axis=0)
    steep = slope > 1e-9
    velocity = speed * float(np.min(arm.velocity_limit[steep] / slope[steep]))
    acceleration = speed * float(np.min(arm.acceleration_limit[steep] / slope[steep]))
    along = np.concatenate([[0.0], np.cumsum(lengths)])
    time, s = _rest_to_rest(float(along[-1]), min(velocity, 1e3), min(acceleration, 1e4))
    return Trajectory(time, np.column_stack([np.interp(s, along, joint) for joint in points.T]))


def _rest_to_rest(length: float, velocity: float, acceleration: float) -> tuple[Array, Array]:
    """Return times and positions of the fastest jerk-limited move over a length."""
    import ruckig

    problem = ruckig.InputParameter(1)
    problem.current_position, problem.target_position = [0.0], [length]
    problem.max_velocity, problem.max_acceleration = [velocity], [acceleration]
    problem.max_jerk = [acceleration / JERK_TIME]
    profile = ruckig.Trajectory(1)
    result = ruckig.Ruckig(1).calculate(problem, profile)
    if result not in (ruckig.Result.Working, ruckig.Result.Finished):
        raise InvalidInput("motion: limits", (velocity, acceleration), "finite limits > 0")
    count = max(int(np.ceil(profile.duration / STEP)), 1)
    time = np.linspace(0.0, profile.duration, count + 1)
    position = np.array([profile.at_time(t)[0][0] for t in time])
    position[-1] = length
    return time, position
