"""Any `Robot` behind the emulator's server: its own time is made to pass as fast as the clock on the wall.

The primitives of a robot block and call their listeners sample by sample. They run here in a thread; a listener
waits until each sample's time has come, keeps it for the feedback, and interrupts a motion that is halted.
"""

from __future__ import annotations

import logging
import math
import threading
import time
from collections.abc import Callable
from dataclasses import replace

from dynamics.arm import Arm
from dynamics.errors import PalpateError
from dynamics.gripper import ParallelGripper
from dynamics.robot import Robot
from dynamics.signals import Sample
from dynamics.trajectory import Trajectory
from hw.emulator.backend import State

log = logging.getLogger(__name__)

IDLE = 0.01  # s of standing still at a time, so that a command is obeyed soon
LAG = 0.2  # s behind the clock after which the robot no longer tries to catch up


class _Halted(Exception):
    """A motion was interrupted."""


class RobotBackend:
    """A robot in real time.

    Args:
        robot: what is behind the server; its arm and its gripper move one at a time.
        clock: gives the time [s]; one that runs faster than the wall's makes a faster robot.
        sleep: waits for a time on that clock [s].

    Attributes:
        lag: how far the robot was ever behind the clock [s].
    """

    def __init__(
        self,
        robot: Robot,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self._robot, self._clock, self._sleep = robot, clock, sleep
        self._sample = robot.read()
        self._lock = threading.Condition()
        self._task: Callable[[], object] | None = None
        self._arm_moving = self._gripper_moving = self._halt = self._jammed = self._failed = self._ending = False
        self._speed = self.lag = 0.0
        self._ahead = self._sample.time - clock()
        robot.listen(self._pace)
        self._thread = threading.Thread(target=self._live, name="emulator-robot", daemon=True)
        self._thread.start()

    @property
    def arm(self) -> Arm:
        """The arm as it is."""
        return self._robot.arm

    @property
    def gripper(self) -> ParallelGripper:
        """The gripper as it is."""
        return self._robot.gripper

    def state(self) -> State:
        """Return what the robot does now."""
        return State(self._sample, self._arm_moving, self._gripper_moving, self._speed, self._failed)

    def start_trajectory(self, trajectory: Trajectory) -> None:
        """Start moving the joints along a trajectory."""
        self._start(lambda: self._robot.follow(trajectory), arm=True)

    def start_grip(self, opening: float, speed: float) -> None:
        """Start driving the gripper to an opening."""
        if self._jammed:
            self._gripper_moving = True
            return
        self._start(lambda: self._robot.grip(opening, speed, math.inf), speed=speed)

    def halt_arm(self) -> None:
        """Bring the joints to rest."""
        self._halt = self._halt or self._arm_moving

    def halt_gripper(self) -> None:
        """Bring the gripper to rest."""
        self._halt = self._halt or (self._gripper_moving and not self._jammed)
        self._gripper_moving = self._gripper_moving and not self._jammed

    def jam(self) -> None:
        """Let the gripper no longer move."""
        self.halt_gripper()
        self._jammed = True

    def close(self) -> None:
        """End the robot's life."""
        with self._lock:
            self._ending = True
            self._lock.notify()
        if self._thread is not threading.current_thread():
            self._thread.join(2.0)

    def _start(self, task: Callable[[], object], arm: bool = False, speed: float = 0.0) -> None:
        """Hand a motion to the robot's thread; one that is under way gives way to it."""
        with self._lock:
            self._halt = self._arm_moving or self._gripper_moving
            self._task, self._failed = task, False
            self._arm_moving, self._gripper_moving, self._speed = arm, not arm, speed
            self._lock.notify()

    def _live(self) -> None:
        """Do what is asked for, and stand still otherwise."""
        try:
            while not self._ending:
                with self._lock:
                    task, self._task, self._halt = self._task, None, False
                try:
                    if task is None:
                        self._robot.hold(IDLE)
                        continue
                    task()
                except _Halted:
                    self._robot.stop()
                except PalpateError as error:
                    log.warning("the robot refused a motion: %s", error)
                    self._failed = True
                with self._lock:
                    if self._task is None:
                        self._arm_moving = self._gripper_moving = False
                        self._speed = 0.0
        finally:
            self._robot.close()

    def _pace(self, sample: Sample) -> None:
        """Wait until a sample's time has come; in the robot's thread."""
        early = sample.time - self._ahead - self._clock()
        if early > 0:
            self._sleep(early)
        self.lag = max(self.lag, -early)
        if early < -LAG:
            self._ahead = sample.time - self._clock()
        self._sample = replace(sample, time=self._clock())
        if self._ending or (self._halt and (self._arm_moving or self._gripper_moving)):
            self._halt = False
            raise _Halted
