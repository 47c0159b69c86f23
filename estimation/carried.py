"""The weight that hangs between the pads, roughly, off joint torques: closing pads swing down and feel it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from dynamics.arm import Arm
from dynamics.gripper import ParallelGripper
from dynamics.signals import Phase, Sample

Array = NDArray[np.float64]


def carried_weight(arm: Arm, before: Sequence[Sample], after: Sequence[Sample]) -> float:
    """Return what the arm carries more after than before, at about the same pose, roughly [N].

    From the change of torque that gravity of the arm itself does not explain, on all joints at once.
    """
    change = _residual(arm, after) - _residual(arm, before)
    q = np.mean([s.q for s in after], axis=0)
    up = arm.tool_pose(q)[:3, :3].T @ np.array([0.0, 0.0, 1.0])
    lever = arm.tool_jacobian(q)[:3].T @ up
    return float(lever @ change / (lever @ lever))


def held_weight(arm: Arm, phases: Sequence[Phase]) -> float:
    """Return the weight of a squeezed object by the ``look`` phases before and after the grasp [N]; 0 without."""
    looks = [phase.samples for phase in phases if phase.name == "look" and phase.samples]
    return max(carried_weight(arm, looks[0], looks[1]), 0.0) if len(looks) > 1 else 0.0


def pull_of_weight(gripper: ParallelGripper, weight: float, opening: Array) -> Array:
    """Return what a hanging weight takes off the force that a closing pad's motor feels [N], (N,).

    The pads come down by ``swing`` of their way as they close, and half the weight hangs on each.
    """
    return weight / 2 * np.array([gripper.swing(float(at)) for at in opening])


def _residual(arm: Arm, samples: Sequence[Sample]) -> Array:
    q = np.mean([s.q for s in samples], axis=0)
    residual: Array = np.mean([s.tau for s in samples], axis=0) - arm.gravity(q)
    return residual
