"""What the torque sensors read too much, told apart from a wrong model by readings in several poses.

An offset is the same in every pose, a wrong hardware revision is not: for the right model the differences
between measured torque and gravity are one constant a joint, tau_k - g(q_k) = offset + noise.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from dynamics.arm import Arm
from dynamics.errors import InvalidInput, MotionRefused
from dynamics.robot import Robot
from dynamics.signals import Sample
from dynamics.trajectory import time_path
from hw.kortex.errors import NotConfirmed

Array = NDArray[np.float64]

MIN_POSES = 3
SETTLE, AVERAGE = 0.5, 1.0  # s in each pose
SPEED = 0.4  # share of the arm's limits
STEPS = np.radians(
    [
        [0, 0, 0, 0, 0, 0, 0],
        [0, -20, 0, 0, 0, 0, 0],
        [0, 0, 0, 25, 0, 0, 0],
        [0, -15, 0, 20, 0, -30, 0],
        [0, 0, 20, 0, 0, -30, 60],
        [0, -10, -20, 0, 40, 0, 120],
    ]
)  # rad from where the arm stands; every joint that feels gravity feels it differently


@dataclass(frozen=True)
class TorqueTare:
    """Offsets of the torque sensors.

    Attributes:
        offset: what each sensor reads too much [N m], (nv,).
        sd: how well it is known [N m], (nv,).
        revision: the hardware revision whose model fits.
        misfit: for each revision, what an offset leaves unexplained, rms over joints and poses [N m].
        poses: how many were visited.
    """

    offset: Array
    sd: Array
    revision: str
    misfit: Mapping[str, float]
    poses: int

    def save(self, path: Path) -> None:
        """Write the tare to a JSON file."""
        content = {
            "torque_offset_N_m": self.offset.tolist(),
            "sd_N_m": self.sd.tolist(),
            "revision": self.revision,
            "misfit_N_m": dict(self.misfit),
            "poses": self.poses,
        }
        path.write_text(json.dumps(content, indent=1) + "\n")

    @classmethod
    def load(cls, path: Path) -> TorqueTare:
        """Read a tare from its JSON file.

        Raises:
            InvalidInput: if it is none.
        """
        try:
            found = json.loads(path.read_text())
            offset, sd = np.array(found["torque_offset_N_m"], float), np.array(found["sd_N_m"], float)
            tare = cls(offset, sd, str(found["revision"]), dict(found["misfit_N_m"]), int(found["poses"]))
        except (OSError, UnicodeDecodeError, ValueError, KeyError, TypeError) as error:
            raise InvalidInput(
                f"torque tare {path}", f"{type(error).__name__}: {error}", "a file of a tare"
            ) from None
        if offset.shape != (7,) or sd.shape != (7,) or not np.all(np.isfinite([offset, sd])):
            raise InvalidInput(f"torque tare {path}", found["torque_offset_N_m"], "7 finite numbers [N m]")
        return tare


def fit_tare(arms: Mapping[str, Arm], q: Array, tau: Array) -> TorqueTare:
    """Return the offsets that explain torques at rest with an empty gripper, and the revision they speak for.

    Args:
        arms: the model of each hardware revision.
        q, tau: mean position and torque in each pose [rad, N m], (N, nv).

    Raises:
        InvalidInput: for less than three poses.
    """
    if len(q) < MIN_POSES or q.shape != tau.shape:
        raise InvalidInput("torque tare", f"{len(q)} poses", f"at least {MIN_POSES}")
    residuals = {name: tau - np.array([arm.gravity(pose) for pose in q]) for name, arm in arms.items()}
    spread = {name: residual - residual.mean(axis=0) for name, residual in residuals.items()}
    misfit = {name: float(np.sqrt(np.mean(values**2))) for name, values in spread.items()}
    best = min(misfit, key=lambda name: misfit[name])
    sd = np.sqrt(np.sum(spread[best] ** 2, axis=0) / (len(q) - 1) / len(q))
    return TorqueTare(residuals[best].mean(axis=0), sd, best, misfit, len(q))


def visit_poses(robot: Robot, steps: Array = STEPS) -> tuple[Array, Array]:
    """Go through poses around where the arm stands, and back; return mean position and torque in each.

    Poses that the robot refuses are left out.

    Args:
        robot: with an empty gripper, in free space.
        steps: of each pose from where it stands [rad], (N, nv).

    Returns:
        q, tau: [rad, N m], (M, nv).
    """
    samples: list[Sample] = []
    robot.listen(samples.append)
    start = robot.read().q.copy()
    here, found = start, list[tuple[Array, Array]]()
    for step in (*steps, np.zeros(len(start))):
        goal = start + step
        try:
            if np.any(goal != here):
                robot.follow(time_path(robot.arm, np.linspace(here, goal, 60), SPEED))
        except NotConfirmed:
            raise
        except MotionRefused:
            continue
        here = goal
        if len(found) < len(steps):
            robot.hold(SETTLE)
            samples.clear()
            robot.hold(AVERAGE)
            found.append(_mean(samples))
    q, tau = (np.array(series) for series in zip(*found, strict=True))
    return q, tau


def _mean(samples: Sequence[Sample]) -> tuple[Array, Array]:
    return np.mean([s.q for s in samples], axis=0), np.mean([s.tau for s in samples], axis=0)
