"""What the emulated arm makes of waypoints: what it finds wrong with them, and the motion along them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from dynamics.arm import Arm
from dynamics.trajectory import STEP, Trajectory
from hw.kortex import messages_pb2 as pb
from hw.kortex.codes import TRAJECTORY_ERRORS

Array = NDArray[np.float64]

MAX_WAYPOINTS = 500
MIN_DURATION = 0.01  # s
DEFAULT_SPEED = 0.5  # share of the arm's limit where a command names none
_NUMBERS = {name: number for number, name in TRAJECTORY_ERRORS.items()}


class Invalid(Exception):
    """Waypoints the arm does not accept.

    Attributes:
        element: what is wrong, in the arm's form.
    """

    def __init__(self, kind: str, waypoint: int, words: str, value: float = 0.0, limit: float = 0.0) -> None:
        super().__init__(f"{kind}: {words}")
        self.element = pb.TrajectoryErrorElement(
            error_type=_NUMBERS[kind], error_value=value, max_value=limit, waypoint_index=waypoint, message=words
        )


def through_waypoints(arm: Arm, start: Array, waypoints: pb.WaypointList) -> Trajectory:
    """Return the motion from where the arm stands through waypoints, a cubic spline from rest to rest.

    Raises:
        Invalid: for the first thing that is wrong with them.
    """
    if not 0 < len(waypoints.waypoints) <= MAX_WAYPOINTS:
        raise Invalid("INVALID_TRAJECTORY_SIZE", 0, f"{len(waypoints.waypoints)} waypoints", 0, MAX_WAYPOINTS)
    knots, times = [start], [0.0]
    for number, waypoint in enumerate(waypoints.waypoints):
        point = waypoint.angular_waypoint
        if len(point.angles) != arm.nv:
            raise Invalid(
                "ACTUATOR_COUNT_MISMATCH", number, f"{len(point.angles)} angles", len(point.angles), arm.nv
            )
        if not (np.isfinite(point.duration) and point.duration >= MIN_DURATION):
            raise Invalid("INVALID_DURATION", number, f"duration {point.duration:g} s", point.duration)
        if not np.all(np.isfinite(point.angles)):
            raise Invalid("INVALID_JOINT_POSITION", number, "an angle that is no number")
        knots.append(_resolve(arm, np.radians(np.array(point.angles)), knots[-1]))
        times.append(times[-1] + point.duration)
        if not arm.within_limits(knots[-1]):
            raise Invalid("INVALID_JOINT_POSITION", number, "a joint outside its limits")
    return _splined(arm, np.array(times), np.array(knots))


def to_angles(arm: Arm, start: Array, command: pb.ConstrainedJointAngles) -> Trajectory:
    """Return the motion of a command to reach joint angles.

    Raises:
        Invalid: for what is wrong with it.
    """
    angles = {angle.joint_identifier: angle.value for angle in command.joint_angles.joint_angles}
    if len(angles) != arm.nv or set(angles) not in ({*range(arm.nv)}, {*range(1, arm.nv + 1)}):
        raise Invalid("ACTUATOR_COUNT_MISMATCH", 0, f"{len(angles)} joints", len(angles), arm.nv)
    goal = _resolve(arm, np.radians([angles[key] for key in sorted(angles)]), start)
    travel = np.abs(goal - start)
    duration = 2 * float(np.max(travel / (DEFAULT_SPEED * arm.velocity_limit)))
    if command.constraint.type == 1:
        duration = float(command.constraint.value)
    elif command.constraint.type == 2 and command.constraint.value > 0:
        duration = 1.5 * float(travel.max() / np.radians(command.constraint.value))
    point = pb.AngularWaypoint(angles=np.degrees(goal), duration=max(duration, 0.1))
    return through_waypoints(arm, start, pb.WaypointList(waypoints=[pb.Waypoint(angular_waypoint=point)]))


def _resolve(arm: Arm, angles: Array, before: Array) -> Array:
    """Return angles in the turn that is meant: the nearest for continuous joints, around 0 for the others."""
    centre = np.where(np.isfinite(arm.upper), 0.0, before)
    turned: Array = angles - 2 * np.pi * np.round((angles - centre) / (2 * np.pi))
    return turned


def _splined(arm: Arm, times: Array, knots: Array) -> Trajectory:
    spline = CubicSpline(times, knots, bc_type="clamped")
    count = max(int(np.ceil(times[-1] / STEP)), 2)
    time = np.linspace(0.0, times[-1], count + 1)
    speed = np.abs(spline(time, 1)).max(axis=0)
    too_fast = speed > arm.velocity_limit * 1.001
    if np.any(too_fast):
        joint = int(np.argmax(too_fast))
        limit = float(np.degrees(arm.velocity_limit[joint]))
        found = float(np.degrees(speed[joint]))
        words = f"joint {joint + 1} would run at {found:.1f} deg/s, its limit is {limit:.1f}"
        raise Invalid("INVALID_JOINT_SPEED", len(times) - 2, words, found, limit)
    return Trajectory(time, np.asarray(spline(time), float))
