"""Inverse kinematics: joint positions that put the tool where it should be, and straight lines of the tool."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, NDArray

from dynamics.arm import Arm
from dynamics.errors import InvalidInput, MotionRefused

Array = NDArray[np.float64]

_TOLERANCE = 1e-9  # norm of the pose error [m and rad]
_ITERATIONS = 100
_RESTARTS = 30
_ROTATION = 1e-6  # by which the columns of a rotation may fail to be orthonormal
_LINE_STEP = 0.01  # m or rad between the poses of a straight line
_JUMP = 0.25  # rad that one joint may turn between them


def tool_down(position: ArrayLike, yaw: float, tilt: float = 0.0) -> Array:
    """Return a tool pose that looks down, (4, 4).

    Args:
        position: of the tool frame in the base [m], (3,).
        yaw: angle of the tool's y axis (along which the pads close) from the base's y axis, about the vertical
            [rad].
        tilt: lean of the approach direction from the vertical, about the tool's y axis [rad].
    """
    pose = np.eye(4)
    about_z = pin.utils.rotate("z", yaw)
    pose[:3, :3] = about_z @ pin.utils.rotate("y", np.pi) @ pin.utils.rotate("y", tilt)
    pose[:3, 3] = np.asarray(position, float)
    return pose


def solve_pose(arm: Arm, pose: Array, near: Array, restarts: int = _RESTARTS) -> Array:
    """Return joint positions whose tool pose is the wanted one, close to given ones.

    Levenberg-Marquardt on the logarithm of the pose error, with the damping of Sugihara (T-RO 2011); the arm's
    redundancy is resolved by starting from ``near``, other starts are tried only when that one fails.

    Args:
        arm: the arm.
        pose: wanted tool pose, (4, 4).
        near: joint positions to start from [rad], (nv,).
        restarts: how many other starts to try.

    Raises:
        MotionRefused: if no start leads there within the joint limits.
        InvalidInput: for a pose that is none, or joint positions that are not finite.
    """
    rng = np.random.default_rng(0)  # fixed: the same question gets the same answer
    target = _pose(pose)
    start = near = _joints(arm, near)
    spread = np.minimum(arm.upper - arm.lower, 2.0)
    for attempt in range(restarts + 1):
        solution = _descend(arm, target, start)
        if solution is not None and arm.within_limits(solution):
            return solution
        wider = (attempt + 1) / (restarts + 1)
        start = np.clip(near + rng.uniform(-0.5, 0.5, arm.nv) * spread * wider, *_box(arm))
    where = ", ".join(f"{x:.3f}" for x in target.translation)
    raise MotionRefused(f"no joint position of {arm.name} puts the tool at ({where}) m as asked: out of reach")


def straight_line(arm: Arm, start: Array, pose: Array) -> Array:
    """Return joint positions that move the tool along a straight line to a pose, (N, nv).

    Raises:
        MotionRefused: if the line leaves the reach or the limits, or would make a joint jump.
        InvalidInput: for a pose that is none, or joint positions that are not finite.
    """
    start, last = _joints(arm, start), _pose(pose)
    first = pin.SE3(arm.tool_pose(start))
    twist = pin.log6(first.actInv(last)).vector
    count = max(int(np.ceil(np.linalg.norm(twist) / _LINE_STEP)), 1)
    path = [start]
    for share in np.linspace(0, 1, count + 1)[1:]:
        middle = first.translation + share * (last.translation - first.translation)
        turned = first.rotation @ pin.exp3(share * pin.log3(first.rotation.T @ last.rotation))
        solution = _descend(arm, pin.SE3(turned, middle), path[-1])
        if solution is None or not arm.within_limits(solution) or np.abs(solution - path[-1]).max() > _JUMP:
            raise MotionRefused(
                f"the tool cannot go straight to ({', '.join(f'{x:.3f}' for x in last.translation)}) m: "
                f"the line leaves the arm's reach at {100 * share:.0f} % of its length"
            )
        path.append(solution)
    return np.array(path)


def straight_joints(start: Array, end: Array, step: float = 0.02) -> Array:
    """Return joint positions on the straight line between two, in joint space, (N, nv).

    Args:
        start, end: joint positions [rad], (nv,).
        step: largest joint motion between two of them [rad].

    Raises:
        InvalidInput: for positions that are not finite or not of one shape, or a step that is not positive.
    """
    if np.ndim(start) != 1 or np.shape(start) != np.shape(end) or not np.all(np.isfinite([start, end])):
        raise InvalidInput("straight motion", f"{start} to {end}", "two finite joint positions, (nv,)")
    if not step > 0:
        raise InvalidInput("straight motion: step", step, "a number > 0 [rad]")
    count = max(int(np.ceil(np.abs(np.subtract(end, start)).max() / step)), 1)
    return np.linspace(start, end, count + 1)


def _descend(arm: Arm, target: pin.SE3, start: Array) -> Array | None:
    """Return the joint positions that a descent from a start leads to, or None if it does not converge."""
    q = np.array(start, float)
    for _ in range(_ITERATIONS):
        error_pose = pin.SE3(arm.tool_pose(q)).actInv(target)
        error = pin.log6(error_pose).vector
        size = float(np.linalg.norm(error))
        if size < _TOLERANCE:
            return q
        jacobian = pin.Jlog6(error_pose.inverse()) @ arm.tool_jacobian(q)
        damped = jacobian.T @ jacobian + (0.5 * size**2 + 1e-10) * np.eye(arm.nv)
        step = np.linalg.solve(damped, jacobian.T @ error)
        q = q + step * min(1.0, 0.5 / max(np.abs(step).max(), 1e-12))
    return None


def _pose(pose: Array) -> pin.SE3:
    """Return Pinocchio's pose of a matrix that is one."""
    matrix = np.asarray(pose, float)
    if matrix.shape != (4, 4) or not np.all(np.isfinite(matrix)):
        raise InvalidInput("tool pose", f"shape {matrix.shape}", "a finite homogeneous matrix, (4, 4)")
    rotation = matrix[:3, :3]
    skew = np.abs(rotation.T @ rotation - np.eye(3)).max()
    if skew > _ROTATION or np.linalg.det(rotation) < 0 or np.any(matrix[3] != [0, 0, 0, 1]):
        raise InvalidInput("tool pose", "no rotation and translation", "a homogeneous matrix of a rigid motion")
    return pin.SE3(matrix)


def _joints(arm: Arm, q: Array) -> Array:
    """Return joint positions that are finite and as many as the arm has joints."""
    positions = np.array(q, float)
    if positions.shape != (arm.nv,) or not np.all(np.isfinite(positions)):
        raise InvalidInput(f"{arm.name}: joint positions", positions, f"finite angles, ({arm.nv},)")
    return positions


def _box(arm: Arm) -> tuple[Array, Array]:
    """Return finite joint limits: a turn either way where a joint has none."""
    turn = 2 * np.pi
    return np.maximum(arm.lower, -turn), np.minimum(arm.upper, turn)
