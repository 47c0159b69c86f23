"""What a recording holds: samples as arrays, marked phases, and what was decided, measured and believed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from dynamics.errors import InvalidInput
from dynamics.signals import GripperReadings, JointReadings, Phase, Sample
from estimation.measurement import Measurement
from estimation.observation import Observation

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Samples:
    """The samples of a recording, column by column; a signal that a log lacks is NaN.

    Attributes:
        time: the robot's clock [s], (N,).
        q, dq, tau: joint position, velocity and torque [rad, rad/s, N m], (N, nv).
        opening: distance between the pads [m], (N,).
        effort: motor current of the gripper [A], (N,).

    Raises:
        InvalidInput: if the columns differ in length.
    """

    time: Array
    q: Array
    dq: Array
    tau: Array
    opening: Array
    effort: Array

    def __post_init__(self) -> None:
        count, joints = len(self.time), self.q.shape[1:]
        shapes = {"q": joints, "dq": joints, "tau": joints, "opening": (), "effort": ()}
        for name, shape in shapes.items():
            found = getattr(self, name).shape
            if found != (count, *shape):
                raise InvalidInput(f"samples: {name}", f"shape {found}", f"{(count, *shape)}, as time and q have")

    def __len__(self) -> int:
        return len(self.time)

    def __getitem__(self, rows: slice) -> Samples:
        columns = (self.time, self.q, self.dq, self.tau, self.opening, self.effort)
        return Samples(*(column[rows] for column in columns))

    def joints(self) -> JointReadings:
        """Return the joint signals."""
        return JointReadings(q=self.q, tau=self.tau, dq=self.dq, time=self.time)

    def gripper(self) -> GripperReadings:
        """Return the gripper signals."""
        return GripperReadings(opening=self.opening, effort=self.effort, time=self.time)

    def as_tuple(self) -> tuple[Sample, ...]:
        """Return the samples one by one."""
        opening, effort = self.opening.tolist(), self.effort.tolist()
        rows = zip(self.time.tolist(), self.q, self.dq, self.tau, opening, effort, strict=True)
        return tuple(Sample(*row) for row in rows)


def no_samples(nv: int = 0) -> Samples:
    """Return samples of length zero for a number of joints."""
    joints = np.empty((0, nv))
    return Samples(np.empty(0), joints, joints, joints, np.empty(0), np.empty(0))


@dataclass(frozen=True)
class Mark:
    """Where a phase stands in a recording: samples ``start`` to ``stop``, the last excluded.

    Attributes:
        action, name, index: as in :class:`dynamics.signals.Phase`.
        start, stop: rows of the samples.
    """

    action: str
    name: str
    index: int
    start: int
    stop: int


@dataclass(frozen=True)
class Entry:
    """Something that was decided or believed.

    Attributes:
        time: of the robot's clock [s].
        data: what.
        row: how many samples came before it.
    """

    time: float
    data: Mapping[str, Any]
    row: int = 0


@dataclass(frozen=True)
class Recorded:
    """A measurement as it was taken.

    Attributes:
        time: of the robot's clock [s].
        action: which measured it.
        measurement: its value.
        row: how many samples came before it.
    """

    time: float
    action: str
    measurement: Measurement
    row: int = 0


@dataclass(frozen=True)
class Observed:
    """An observation as it was made.

    Attributes:
        time: of the robot's clock [s].
        action: which made it.
        observation: what was perceived.
        row: how many samples came before it.
    """

    time: float
    action: str
    observation: Observation
    row: int = 0


@dataclass(frozen=True)
class Rejections:
    """Rows of a log that could not be used.

    Attributes:
        count: how many there were.
        reasons: the first of them, each with its place.
    """

    count: int = 0
    reasons: tuple[str, ...] = ()


@dataclass(frozen=True)
class Recording:
    """Everything that is known of what happened.

    Attributes:
        source: the folder or file it was read from.
        samples: what the robot reported.
        marks: where its phases stand, in order; empty when nobody marked them.
        decisions, beliefs: in order of time.
        measurements: in order of time.
        observations: of classes, in order of time.
        config: the resolved configuration of the run.
        object_name: what was explored, where it is known.
        started: when the run began, in universal time, where it is known.
        joint_names: in the order of the columns; empty when unknown.
        drive_effort: what ``samples.tau`` holds: torques [N m], or the motor currents [A] of drives that report no
            torque.
        has_velocities: whether the log had them; else they were derived from the positions.
        complete: whether the recording was closed properly.
        clock: the robot's own time of every sample, where it began anew during the run [s], (N,).
        rejections: rows that could not be used.
        notes: what a reader should know of how the data were understood.
    """

    source: Path
    samples: Samples
    marks: tuple[Mark, ...] = ()
    decisions: tuple[Entry, ...] = ()
    measurements: tuple[Recorded, ...] = ()
    beliefs: tuple[Entry, ...] = ()
    config: Mapping[str, Any] = field(default_factory=dict)
    object_name: str = ""
    started: str = ""
    joint_names: tuple[str, ...] = ()
    drive_effort: Literal["torque", "current"] = "torque"
    has_velocities: bool = True
    complete: bool = True
    clock: Array | None = None
    rejections: Rejections = Rejections()
    notes: tuple[str, ...] = ()
    observations: tuple[Observed, ...] = ()

    @property
    def phases(self) -> tuple[Phase, ...]:
        """The marked phases with their samples, in order; built anew at every call."""
        return tuple(self.phase(mark) for mark in self.marks)

    def phase(self, mark: Mark) -> Phase:
        """Return one marked phase with its samples; their times are the robot's own."""
        rows = slice(mark.start, mark.stop)
        samples = self.samples[rows]
        if self.clock is not None:
            samples = replace(samples, time=self.clock[rows])
        return Phase(mark.action, mark.name, mark.index, samples.as_tuple())
