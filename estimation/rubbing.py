"""What a rub tells: strokes over a surface become a coefficient of friction, through the arm's joint torques."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from dynamics.arm import Arm
from dynamics.errors import InvalidInput
from dynamics.gripper import ParallelGripper
from dynamics.signals import JointReadings, Phase
from estimation.friction import FrictionEstimate, Stroke, estimate_friction
from estimation.measurement import Measurement
from estimation.pinching import measure_pinched_rub

Array = NDArray[np.float64]

RESAMPLED = 200  # readings of a stroke, taken at even shares of its way


def measure_rub(
    arm: Arm, phases: Sequence[Phase], *, gain_sd: float = 0.01, gripper: ParallelGripper | None = None
) -> tuple[FrictionEstimate, Measurement]:
    """Estimate friction from the phases of a rub: along the sides of a pinched object, or over a level surface.

    With phases named ``press`` it is the former, see :mod:`estimation.pinching`, and needs the gripper. Otherwise
    it is strokes over a level surface and the same strokes in the air.

    The torque that a stroke in the air needs (gravity, the joints' own friction in that direction) is taken off
    that of the stroke of the same index on the surface, at the same share of the way; what is left is
    J^T f with the force f on the object. Normal is straight down, tangential is along the first stroke.

    Args:
        arm: its description.
        phases: ``slide``, one a stroke on the surface, and as many ``air``, one a stroke above it.
        gain_sd: relative standard deviation of the torque sensors' scale, over a level surface.
        gripper: its description.

    Raises:
        InvalidInput: if the phases do not match, or a stroke does not move.
    """
    if gripper is not None and any(phase.name == "press" for phase in phases):
        return measure_pinched_rub(arm, gripper, phases)
    slides = [p.joints() for p in phases if p.name == "slide"]
    airs = [p.joints() for p in phases if p.name == "air"]
    if not slides or len(slides) != len(airs):
        raise InvalidInput("rub: phases", f"{len(slides)} slide, {len(airs)} air", "as many of both, at least one")
    axis, strokes = None, []
    for slide, air in zip(slides, airs, strict=True):
        way = _way(arm, slide)
        axis = way / np.linalg.norm(way) if axis is None else axis
        direction = 1 if float(way @ axis) > 0 else -1
        force = contact_forces(arm, slide, air)
        strokes.append(Stroke(force @ axis, -force[:, 2], direction))
    estimate = estimate_friction(strokes, gain_sd=gain_sd)
    return estimate, estimate.measurement()


def contact_forces(arm: Arm, loaded: JointReadings, free: JointReadings) -> Array:
    """Return the force of the tool on its surroundings, in the base frame [N], (RESAMPLED, 3).

    Least squares of J^T w = tau - tau_free over the wrench w at the tool, at even shares of the way.

    Args:
        arm: its description.
        loaded, free: the same motion with and without contact.
    """
    q, tau = _resample(loaded)
    _, tau_free = _resample(free)
    forces = np.empty((RESAMPLED, 3))
    for k in range(RESAMPLED):
        jacobian = arm.tool_jacobian(q[k])
        wrench = np.linalg.lstsq(jacobian.T, tau[k] - tau_free[k], rcond=None)[0]
        forces[k] = arm.tool_pose(q[k])[:3, :3] @ wrench[:3]
    return forces


def _way(arm: Arm, readings: JointReadings) -> Array:
    """Return the level way of the tool over a stroke [m], (3,)."""
    way = arm.tool_pose(readings.q[-1])[:3, 3] - arm.tool_pose(readings.q[0])[:3, 3]
    way[2] = 0.0
    if not np.linalg.norm(way) > 1e-3:
        raise InvalidInput("rub: stroke [m]", round(float(np.linalg.norm(way)), 5), "a level motion over 1 mm")
    return np.asarray(way)


def _resample(readings: JointReadings) -> tuple[Array, Array]:
    """Return position and torque at even shares of the way, (RESAMPLED, nv) each."""
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(readings.q, axis=0), axis=1))])
    share = way / max(float(way[-1]), 1e-12) + 1e-9 * np.arange(len(way))
    at = np.linspace(0.0, float(share[-1]), RESAMPLED)
    columns = range(readings.q.shape[1])
    return (
        np.stack([np.interp(at, share, readings.q[:, j]) for j in columns], axis=1),
        np.stack([np.interp(at, share, readings.tau[:, j]) for j in columns], axis=1),
    )
