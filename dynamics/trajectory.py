"""A timed motion of the joints, and how a path becomes one: from rest to rest, jerk-limited."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from dynamics.arm import Arm
from dynamics.errors import InvalidInput

if TYPE_CHECKING:
    import ruckig
    from scipy.interpolate import CubicSpline

Array = NDArray[np.float64]

STEP = 0.01  # s between the stored positions
JERK_TIME = 0.15  # s in which an acceleration limit may be built up
CORNER = 0.01  # rad by which a joint may leave the polyline where it is rounded
_SHARES = np.linspace(0.3, 0.9, 7)  # of the speed at which bending alone would take all, that are tried
_LOOKS = 5  # places within a segment where the curve's bending is looked at


@dataclass(frozen=True)
class Trajectory:
    """Joint positions over time.

    Attributes:
        time: [s], from 0, increasing, (N,).
        q: joint positions [rad], (N, nv).

    Raises:
        InvalidInput: for a wrong shape, a number that is not finite, or times out of order.
    """

    time: Array
    q: Array

    def __post_init__(self) -> None:
        shape = np.shape(self.q)
        if len(shape) != 2 or shape[0] < 1 or not np.all(np.isfinite(self.q)):
            raise InvalidInput("trajectory: q", f"shape {shape}", "finite positions, (N, nv)")
        if np.shape(self.time) != shape[:1] or not np.all(np.isfinite(self.time)):
            raise InvalidInput("trajectory: time", f"shape {np.shape(self.time)}", f"finite times, ({shape[0]},)")
        if self.time[0] != 0 or np.any(np.diff(self.time) <= 0):
            raise InvalidInput("trajectory: time", "times out of order", "times that increase from 0")

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

    def positions(self, times: Array) -> Array:
        """Return the joint positions at several times, linear between the stored ones [rad], (M, nv)."""
        last = len(self.time) - 1
        if last == 0:
            return np.repeat(self.q, len(times), axis=0)
        upper = np.clip(np.searchsorted(self.time, times, side="right"), 1, last)
        share = ((times - self.time[upper - 1]) / (self.time[upper] - self.time[upper - 1]))[:, None]
        between: Array = (1 - share) * self.q[upper - 1] + share * self.q[upper]
        return np.where((times >= self.time[-1])[:, None], self.q[-1], between)


def time_path(arm: Arm, path: Array, speed: float = 0.6) -> Trajectory:
    """Time a path so that no joint exceeds its speed, acceleration and jerk limit.

    The path is followed as a smooth curve q(s) through its points (cubic splines over the way s, straight where
    the points are) by the scalar s(t), from rest to rest and jerk-limited, so that

        |q'| v <= V,    |q'| a + |q''| v^2 <= A,    |q'| j + 3 |q''| a v + |q'''| v^3 <= A / JERK_TIME

    hold for every joint all along the curve. A faster v leaves less of A and of the jerk for a and j where the
    curve bends, so several v are tried, and the shortest profile s(t) is taken; each is time-optimal within its
    (v, a, j), by Ruckig (Berscheid and Kroeger, RSS 2021).

    Args:
        arm: gives the limits V and A.
        path: joint positions [rad], (N, nv), a polyline fine enough to be smooth; sharp corners need two calls.
        speed: share of the limits to use, in (0, 1].

    Raises:
        InvalidInput: for a speed out of range, a path of the wrong shape, or a corner that a smooth curve would
            cut by more than CORNER.
    """
    if not 0 < speed <= 1:
        raise InvalidInput("motion: speed", speed, "a share of the limits in (0, 1]")
    points = np.asarray(path, float)
    if points.ndim != 2 or len(points) < 1 or points.shape[1] != arm.nv or not np.all(np.isfinite(points)):
        raise InvalidInput("motion: path", f"shape {points.shape}", f"finite positions, (N, {arm.nv})")
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    if not np.any(lengths > 1e-9):
        return Trajectory(np.array([0.0, STEP]), points[[-1, -1]])
    distinct = np.concatenate([[True], lengths > 1e-9])
    along = np.concatenate([[0.0], np.cumsum(lengths)])[distinct]
    curve = _smooth(along, points[distinct])
    length = float(along[-1])
    profiles = [_rest_to_rest(length, *limits) for limits in _profile_limits(arm, curve, along, speed)]
    time, s = _stepped(min(profiles, key=lambda profile: profile.duration), length)
    q: Array = curve(s)
    q[0], q[-1] = points[0], points[-1]
    return Trajectory(time, q)


def _smooth(along: Array, points: Array) -> CubicSpline:
    """Return the curve through the points of a path, over the way along it.

    Raises:
        InvalidInput: if it leaves the polyline by more than CORNER.
    """
    from scipy.interpolate import CubicSpline

    curve = CubicSpline(along, points, bc_type="natural")
    within = _within_segments(along)
    polyline = np.column_stack([np.interp(within, along, joint) for joint in points.T])
    off = np.abs(curve(within) - polyline).max(axis=1)
    if off.max() > CORNER:
        segment = int(np.searchsorted(along, within[off.argmax()], side="right"))
        raise InvalidInput(
            "motion: path",
            f"a corner near point {segment} of {len(points)}",
            f"a smooth path: a curve through its points may leave it by {CORNER} rad; split it at its corners",
        )
    return curve


def _profile_limits(arm: Arm, curve: CubicSpline, along: Array, speed: float) -> list[tuple[float, float, float]]:
    """Return choices of speed, acceleration and jerk along a curve that keep every joint within its limits."""
    within = _within_segments(along)
    slope, bend, twist = (np.abs(curve(within, order)) for order in (1, 2, 3))
    # What rounding leaves of bending on a straight path must not slow it down.
    bend, twist = np.where(bend > 1e-9, bend, 0.0), np.where(twist > 1e-6, twist, 0.0)
    # q'' is linear and q''' constant within a segment, but |q'| may peak between two places that are looked at.
    apart = np.append(np.repeat(np.diff(along) / _LOOKS, _LOOKS), 0.0)
    slope = slope + twist * apart[:, None] ** 2 / 8
    most = speed * arm.acceleration_limit
    jerk = most / JERK_TIME
    fastest = min(_least(speed * arm.velocity_limit, slope), 1e3)
    bent = min(math.sqrt(_least(most, bend)), float(np.cbrt(_least(jerk, twist))))
    choices = []
    for velocity in np.minimum(fastest, bent * _SHARES):
        left = jerk - twist * velocity**3
        acceleration = min(_least(most - bend * velocity**2, slope), _least(left / 2, 3 * bend * velocity), 1e4)
        left = left - 3 * bend * acceleration * velocity
        choices.append((float(velocity), acceleration, min(_least(left, slope), acceleration / JERK_TIME)))
    return choices


def _least(limit: Array, share: Array) -> float:
    """Return the smallest limit per share; no share has no limit."""
    ratio = np.divide(limit, share, out=np.full(share.shape, np.inf), where=share > 1e-12)
    return float(ratio.min())


def _within_segments(along: Array) -> Array:
    """Return ways along a path at the ends of its segments and in between, in order."""
    shares = np.linspace(0, 1, _LOOKS, endpoint=False)
    inside = along[:-1, None] + np.diff(along)[:, None] * shares
    return np.append(inside.ravel(), along[-1])


def _rest_to_rest(length: float, velocity: float, acceleration: float, jerk: float) -> ruckig.Trajectory:
    """Return the fastest jerk-limited move over a length."""
    import ruckig

    problem = ruckig.InputParameter(1)
    problem.current_position, problem.target_position = [0.0], [length]
    problem.max_velocity, problem.max_acceleration, problem.max_jerk = [velocity], [acceleration], [jerk]
    profile = ruckig.Trajectory(1)
    result = ruckig.Ruckig(1).calculate(problem, profile)
    if result not in (ruckig.Result.Working, ruckig.Result.Finished):
        raise InvalidInput("motion: limits", (velocity, acceleration, jerk), "finite limits > 0")
    return profile


def _stepped(profile: ruckig.Trajectory, length: float) -> tuple[Array, Array]:
    """Return times about a STEP apart and the way made by each."""
    count = max(int(np.ceil(profile.duration / STEP)), 1)
    time = np.linspace(0.0, profile.duration, count + 1)
    position = np.array([profile.at_time(t)[0][0] for t in time])
    position[-1] = length
    return time, position
