"""A recorded motion as rows of a linear model: what link inertias, friction and a payload ask of the drives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from dynamics.arm import Arm
from dynamics.errors import InvalidInput
from estimation.payload.derivatives import smooth
from estimation.recording.data import Recording

Array = NDArray[np.float64]

BLOCK = 0.05  # s over which both sides of the model are averaged, so that white noise of the drives matters less
SLOW = 0.02  # rad/s below which Coulomb friction changes sign gradually


@dataclass(frozen=True)
class JointLog:
    """A recorded motion.

    Attributes:
        time: [s], increasing, (N,).
        q: joint positions [rad], (N, nv).
        effort: torque [N m] or motor current [A], (N, nv).
        effort_kind: which of the two.
        dq: velocities where recorded [rad/s], (N, nv).
    """

    time: Array
    q: Array
    effort: Array
    effort_kind: Literal["torque", "current"]
    dq: Array | None = None

    @classmethod
    def of(cls, recording: Recording) -> JointLog:
        """Return the joint signals of a recording; of rows with one time, the first.

        Raises:
            InvalidInput: if it holds neither torques nor currents of the joints.
        """
        samples = recording.samples
        if not np.all(np.isfinite(samples.tau)):
            raise InvalidInput(
                f"{recording.source}", "no torques of the joints", "tau, or current in a column map"
            )
        first = np.diff(samples.time, prepend=-np.inf) > 0
        kept = (samples.time[first], samples.q[first], samples.tau[first])
        dq = samples.dq[first] if recording.has_velocities else None
        return cls(*kept, recording.drive_effort, dq)

    def __len__(self) -> int:
        return len(self.time)


@dataclass(frozen=True)
class MotionRows:
    """Rows of one run, averaged over blocks of time.

    Attributes:
        time: [s], (T,).
        effort: measured torque [N m] or motor current [A], (T, nv).
        effort_kind: which of the two.
        model: matrix of [link inertias (10 nv), Coulomb, viscous, offset, rotor (nv each)], (T, nv, 14 nv).
        payload: matrix of the payload's ten parameters, (T, nv, 10).
    """

    time: Array
    effort: Array
    effort_kind: Literal["torque", "current"]
    model: Array
    payload: Array

    def __len__(self) -> int:
        return len(self.time)


def motion_rows(arm: Arm, log: JointLog) -> MotionRows:
    """Return the rows of a recorded motion; velocity and acceleration come from a smoother.

    Raises:
        InvalidInput: if the log is of another arm, in other units, or too short.
    """
    if log.q.shape[1] != arm.nv:
        raise InvalidInput("log: joints", log.q.shape[1], f"{arm.nv}: {', '.join(arm.joint_names)}")
    if np.abs(log.q).max() > 4 * np.pi:
        raise InvalidInput(
            "log: joint positions", f"up to {np.abs(log.q).max():.4g} rad", "angles in rad, not degrees"
        )
    q, dq, ddq = smooth(log.time, log.q, log.dq)
    block = np.floor((log.time - log.time[0]) / BLOCK).astype(int)
    starts = np.flatnonzero(np.diff(block, prepend=-1))
    if len(starts) < 20:
        raise InvalidInput("log: duration", f"{log.time[-1] - log.time[0]:.2f} s", f"at least {20 * BLOCK:g} s")
    counts = np.diff(np.append(starts, len(block)))

    def averaged(rows: Array) -> Array:
        sums: Array = np.add.reduceat(rows, starts, axis=0)
        return sums / counts.reshape(-1, *[1] * (rows.ndim - 1))

    data, samples = arm.model.createData(), list(zip(q, dq, ddq, strict=True))
    links = np.array(
        [
            pin.computeJointTorqueRegressor(arm.model, data, arm.configuration(s[0]), s[1], s[2]).copy()
            for s in samples
        ]
    )
    body = np.array([arm.payload_regressor(*s) for s in samples])
    eye = np.eye(arm.nv)
    columns = [np.tanh(dq / SLOW), dq, np.ones_like(dq), ddq]
    friction = np.concatenate([column[:, :, None] * eye for column in columns], axis=2)
    return MotionRows(
        averaged(log.time),
        averaged(log.effort),
        log.effort_kind,
        averaged(np.concatenate([links, friction], axis=2)),
        averaged(body),
    )
