"""What the emulator's server needs of the robot behind it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from dynamics.arm import Arm
from dynamics.gripper import ParallelGripper
from dynamics.signals import Sample
from dynamics.trajectory import Trajectory


@dataclass(frozen=True)
class State:
    """What the robot does at one instant.

    Attributes:
        sample: its signals.
        arm_moving, gripper_moving: whether a motion is under way.
        gripper_speed: the speed that was commanded [m/s], 0 while it stands.
        failed: whether the last motion ended because the robot could not do it.
    """

    sample: Sample
    arm_moving: bool
    gripper_moving: bool
    gripper_speed: float = 0.0
    failed: bool = False


class Backend(Protocol):
    """A robot that is told to start and to stop motions and goes on in real time.

    Motions of the arm and of the gripper may run at the same time where the robot can do that. None of the
    calls waits for a motion to end.
    """

    @property
    def arm(self) -> Arm:
        """The arm as it really is, hardware revision included."""
        ...

    @property
    def gripper(self) -> ParallelGripper:
        """The gripper as it really is."""
        ...

    def state(self) -> State:
        """Return what the robot does now."""
        ...

    def start_trajectory(self, trajectory: Trajectory) -> None:
        """Start moving the joints along a trajectory."""
        ...

    def start_grip(self, opening: float, speed: float) -> None:
        """Start driving the gripper to an opening [m] at a speed [m/s]."""
        ...

    def halt_arm(self) -> None:
        """Bring the joints to rest."""
        ...

    def halt_gripper(self) -> None:
        """Bring the gripper to rest; it keeps its grip."""
        ...

    def jam(self) -> None:
        """Let the gripper no longer move."""
        ...

    def close(self) -> None:
        """Release what the robot holds."""
        ...
