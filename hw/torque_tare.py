"""What the torque sensors read too much, told apart from a wrong model by readings in several poses.

An offset is the same in every pose, a wrong hardware revision is not: for the right model the differences
between measured torque and gravity are one constant a joint, tau_k - g(q_k) = offset + noise. The spread that a
wrong revision adds is about 0.1 N m on joint 2: sensors that depend on the direction of the last motion by more
than that hide it, and then the tare does not speak on the revision.
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
FLOOR = 0.01  # N m; no torque is known better
CLEAR = 16.0  # of evidence; chance alone gives it once in a hundred tares at most
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
        revision: the hardware revision whose model they belong to.
        misfit: for each revision, what an offset leaves unexplained, rms over joints and poses [N m].
        evidence: for each other revision, how much better it fits: the drop of the squared residuals, each in
            units of its joint's spread.
        poses: how many were visited.
    """

    offset: Array
    sd: Array
    revision: str
    misfit: Mapping[str, float]
    evidence: Mapping[str, float]
    poses: int

    @property
    def likelier(self) -> str | None:
        """Another revision that the torques clearly speak for, None if there is none."""
        best = max(self.evidence, key=lambda name: self.evidence[name], default=None)
        return best if best is not None and self.evidence[best] > CLEAR else None

    @property
    def telling(self) -> bool:
        """Whether the torques clearly speak for a revision, this one or another."""
        return self.likelier is not None or all(-value > CLEAR for value in self.evidence.values())

    def save(self, path: Path) -> None:
        """Write the tare to a JSON file."""
        content = {
            "torque_offset_N_m": self.offset.tolist(),
            "sd_N_m": self.sd.tolist(),
            "revision": self.revision,
            "misfit_N_m": dict(self.misfit),
            "evidence": dict(self.evidence),
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
            misfit, evidence = dict(found["misfit_N_m"]), dict(found["evidence"])
            tare = cls(offset, sd, str(found["revision"]), misfit, evidence, int(found["poses"]))
        except (OSError, UnicodeDecodeError, ValueError, KeyError, TypeError) as error:
            raise InvalidInput(
                f"torque tare {path}", f"{type(error).__name__}: {error}", "a file of a tare"
            ) from None
        if offset.shape != (7,) or sd.shape != (7,) or not np.all(np.isfinite([offset, sd])):
            raise InvalidInput(f"torque tare {path}", found["torque_offset_N_m"], "7 finite numbers [N m]")
        return tare


def fit_tare(arms: Mapping[str, Arm], revision: str, q: Array, tau: Array) -> TorqueTare:
    """Return the offsets that explain torques at rest with an empty gripper.

    Args:
        arms: the model of each hardware revision.
        revision: the one that is assumed.
        q, tau: mean position and torque in each pose [rad, N m], (N, nv).

    Raises:
        InvalidInput: for less than three poses.
    """
    if len(q) < MIN_POSES or q.shape != tau.shape:
        raise InvalidInput("torque tare", f"{len(q)} poses", f"at least {MIN_POSES}")
    residuals = {name: tau - np.array([arm.gravity(pose) for pose in q]) for name, arm in arms.items()}
    squares = {name: np.sum((r - r.mean(axis=0)) ** 2, axis=0) for name, r in residuals.items()}
    variance = np.maximum(np.min(list(squares.values()), axis=0) / (len(q) - 1), FLOOR**2)
    own = squares[revision]
    return TorqueTare(
        offset=residuals[revision].mean(axis=0),
        sd=np.sqrt(own / (len(q) - 1) / len(q)),
        revision=revision,
        misfit={name: float(np.sqrt(np.sum(value) / q.size)) for name, value in squares.items()},
        evidence={n: float(np.sum((own - value) / variance)) for n, value in squares.items() if n != revision},
        poses=len(q),
    )


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
