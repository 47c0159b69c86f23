"""The signals of a robot: one sample as it is read, and series of them, in SI units.

Torques follow the convention of :mod:`dynamics.arm`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dynamics.errors import InvalidInput

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Sample:
    """What a robot reports at one instant.

    Attributes:
        time: the robot's clock [s].
        q, dq, tau: joint position, velocity and measured torque [rad, rad/s, N m], (nv,).
        opening: distance between the pads as the gripper reports it [m].
        effort: motor current of the gripper [A]; it tells of force only while the gripper moves.
    """

    time: float
    q: Array
    dq: Array
    tau: Array
    opening: float
    effort: float


@dataclass(frozen=True)
class JointReadings:
    """A series of joint signals.

    Attributes:
        q, tau: position and torque [rad, N m], (N, nv).
        dq, ddq: velocity and acceleration where known [rad/s, rad/s^2], (N, nv).
        time: [s], (N,), not decreasing.

    Raises:
        InvalidInput: for a wrong shape, a number that is not finite, or time that runs backwards.
    """

    q: Array
    tau: Array
    dq: Array | None = None
    ddq: Array | None = None
    time: Array | None = None

    def __post_init__(self) -> None:
        _check(self.q, "joint readings: q", (None, None))
        for name in ("tau", "dq", "ddq"):
            series = getattr(self, name)
            if series is not None:
                _check(series, f"joint readings: {name}", self.q.shape)
        if self.time is not None:
            _check_time(self.time, "joint readings: time", len(self.q))

    def __len__(self) -> int:
        return len(self.q)


@dataclass(frozen=True)
class GripperReadings:
    """A series of gripper signals.

    Attributes:
        opening: distance between the pads [m], (N,).
        effort: motor current [A], (N,).
        time: [s], (N,), not decreasing.

    Raises:
        InvalidInput: for a wrong shape, a number that is not finite, or time that runs backwards.
    """

    opening: Array
    effort: Array
    time: Array

    def __post_init__(self) -> None:
        _check(self.opening, "gripper readings: opening", (None,))
        _check(self.effort, "gripper readings: effort", self.opening.shape)
        _check_time(self.time, "gripper readings: time", len(self.opening))

    def __len__(self) -> int:
        return len(self.opening)


@dataclass(frozen=True)
class Phase:
    """A marked stretch of an action.

    Attributes:
        action: the action it belongs to, such as ``weigh``.
        name: what happens in it: ``tare``, ``approach``, ``close``, ``lift``, ``hold``, ``compress``,
            ``dwell``, ``release``, ``retreat`` ...
        index: counts the phases of one name within an action, from 0.
        samples: what the robot reported during it, in order of time.
    """

    action: str
    name: str
    index: int
    samples: tuple[Sample, ...]

    def joints(self) -> JointReadings:
        """Return the joint signals of the phase."""
        return JointReadings(
            q=np.array([s.q for s in self.samples]),
            tau=np.array([s.tau for s in self.samples]),
            dq=np.array([s.dq for s in self.samples]),
            time=np.array([s.time for s in self.samples]),
        )

    def gripper(self) -> GripperReadings:
        """Return the gripper signals of the phase."""
        return GripperReadings(
            opening=np.array([s.opening for s in self.samples]),
            effort=np.array([s.effort for s in self.samples]),
            time=np.array([s.time for s in self.samples]),
        )


def _check(series: Array, where: str, shape: tuple[int | None, ...]) -> None:
    found = np.shape(series)
    if len(found) != len(shape) or any(b is not None and a != b for a, b in zip(found, shape, strict=True)):
        wanted = ", ".join("any" if n is None else str(n) for n in shape)
        raise InvalidInput(where, f"shape {found}", f"shape ({wanted})")
    if not np.all(np.isfinite(series)):
        first = np.argwhere(~np.isfinite(series))[0]
        raise InvalidInput(where, f"{series[tuple(first)]} at {tuple(int(i) for i in first)}", "finite numbers")


def _check_time(time: Array, where: str, count: int) -> None:
    _check(time, where, (count,))
    if np.any(np.diff(time) < 0):
        at = int(np.argmax(np.diff(time) < 0)) + 1
        raise InvalidInput(where, f"time runs backwards at sample {at}", "times in order")
