"""The robot as the exploration sees it: the same few primitives in simulation and on the real arm."""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from dynamics.arm import Arm
from dynamics.errors import PalpateError
from dynamics.gripper import ParallelGripper
from dynamics.signals import Sample
from dynamics.trajectory import Trajectory

SampleSink = Callable[[Sample], None]


class GripResult(Enum):
    """How a motion of the gripper ended."""

    REACHED = "reached"
    STALLED = "stalled"  # the effort limit was met before the opening


@runtime_checkable
class Robot(Protocol):
    """An arm with a gripper, in SI units. Every primitive blocks until it is done.

    While a primitive runs, every sample is handed to the listeners as it is read, in order of time and never
    slower than 100 Hz. A robot that can no longer be trusted (lost connection, fault, emergency stop) stops and
    raises a PalpateError.
    """

    @property
    def arm(self) -> Arm:
        """The description of the arm, as its user knows it."""
        ...

    @property
    def gripper(self) -> ParallelGripper:
        """The description of the gripper, as its user knows it."""
        ...

    def listen(self, sink: SampleSink) -> None:
        """Hand every further sample to a function."""
        ...

    def read(self) -> Sample:
        """Return the newest sample."""
        ...

    def follow(self, trajectory: Trajectory) -> None:
        """Move the joints along a trajectory that starts where the arm stands, and end at rest.

        Raises:
            MotionRefused: if it starts elsewhere or leaves the limits; nothing has moved then.
        """
        ...

    def hold(self, seconds: float) -> None:
        """Stand still for a time [s]."""
        ...

    def grip(self, opening: float, speed: float, max_effort: float) -> GripResult:
        """Drive the gripper to an opening, or until its motor current exceeds a limit; then it locks.

        Args:
            opening: target distance of the pads [m], in [0, max_opening].
            speed: closing or opening speed [m/s]; limited to what the gripper can do.
            max_effort: motor current at which to stop [A]; infinite for the gripper's own limit.
        """
        ...

    def stop(self) -> None:
        """Stop all motion at once; the gripper keeps its grip."""
        ...

    def close(self) -> None:
        """Release the connection; the robot stands still."""
        ...


class CannotDraw(PalpateError):
    """There is no OpenGL to draw a picture with, or no display to show one on."""


@runtime_checkable
class Camera(Protocol):
    """What a robot may offer besides: pictures of where it works."""

    @property
    def cameras(self) -> tuple[str, ...]:
        """Names of the cameras: ``overview``, ``close`` and ``wrist`` as far as there are such."""
        ...

    def picture(self, camera: str = "overview", width: int = 1080, height: int = 720) -> NDArray[np.uint8]:
        """Return what a camera sees, (height, width, 3), red, green, blue.

        Raises:
            UnknownName: if there is no camera of that name.
            CannotDraw: if a picture cannot be made here.
        """
        ...
