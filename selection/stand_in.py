"""A robot in thought: it follows every plan at once, and reads what is nominal.

The torques are those of the arm alone. The object between the pads has its declared width, gives way evenly, and
holds against pads that slide down on it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dynamics.arm import Arm
from dynamics.errors import MotionRefused
from dynamics.gripper import ParallelGripper
from dynamics.objects import DeclaredObject
from dynamics.robot import GripResult, Robot, SampleSink
from dynamics.signals import Sample
from dynamics.trajectory import Trajectory

Array = NDArray[np.float64]
Judge = Callable[[Trajectory], None]

SAMPLE_TIME = 0.01  # s
EFFORT_PER_STRAIN = 3.0  # A for an object compressed by all of its width
TORQUE_SD = 0.3  # N m; readings as poor as can be expected, so that nothing ends early for having been read well
PULL = 10.0  # N by which an object between the pads holds against a motion downward
DOWNWARD = 0.002  # m
START_TOLERANCE = 0.02  # rad between where a motion starts and where the arm would stand
SPEED_ROUNDING = 1 + 1e-6


@dataclass(frozen=True)
class Move:
    """One motion of the plan.

    Attributes:
        kind: ``arm``, ``gripper`` or ``hold``.
        start: by the robot's clock [s].
        seconds: its duration.
        place: where the tool would be at its end, in the base frame [m], (3,).
        opening: of the gripper at its end [m].
    """

    kind: str
    start: float
    seconds: float
    place: Array
    opening: float


class StandIn:
    """A robot in thought: it follows every plan at once, and reads what is nominal.

    Args:
        robot: whose place it takes, from where that stands.
        declared: the object between its fingers.
        judge: what the robot itself has to say to a motion; raises a PalpateError.
    """

    def __init__(self, robot: Robot, declared: DeclaredObject, judge: Judge | None = None) -> None:
        self._robot, self._judge = robot, judge
        self._newest = robot.read()
        fitting = [edge for edge in declared.size[:2] if edge <= robot.gripper.max_opening]
        self._width = min(fitting, default=robot.gripper.max_opening)
        self._sinks: list[SampleSink] = []
        self._rng = np.random.default_rng(0)
        self._static: tuple[Array, Array] | None = None
        self._pull = 0.0
        self.moves: list[Move] = []

    @property
    def arm(self) -> Arm:
        """The arm's description."""
        return self._robot.arm

    @property
    def gripper(self) -> ParallelGripper:
        """The gripper's description."""
        return self._robot.gripper

    def listen(self, sink: SampleSink) -> None:
        """Hand every further sample to a function."""
        self._sinks.append(sink)

    def read(self) -> Sample:
        """Return where the robot would be."""
        return self._newest

    def follow(self, trajectory: Trajectory) -> None:
        """Check a motion and be at its end.

        Raises:
            MotionRefused: if it does not start where the arm would stand, leaves a limit, or the arm refuses it.
        """
        path, arm = np.asarray(trajectory.q, float), self.arm
        if np.abs(path[0] - self._newest.q).max() > START_TOLERANCE:
            raise MotionRefused("the trajectory does not start where the arm would stand")
        if not all(arm.within_limits(q) for q in path):
            raise MotionRefused("the trajectory leaves the joint limits")
        speed = np.abs(np.diff(path, axis=0)) / np.diff(trajectory.time)[:, None]
        if np.any(speed > arm.velocity_limit * SPEED_ROUNDING):
            raise MotionRefused("the trajectory is faster than the joints can turn")
        if self._judge is not None:
            self._judge(trajectory)
        height = float(arm.tool_pose(self._newest.q)[2, 3])
        goes_down = arm.tool_pose(path[-1])[2, 3] < height - DOWNWARD
        self._pull = PULL if goes_down and self._newest.opening < self._width else 0.0
        self._go("arm", trajectory.duration, trajectory.position, lambda elapsed: self._newest.opening)

    def hold(self, seconds: float) -> None:
        """Let time pass."""
        q, opening = self._newest.q, self._newest.opening
        self._go("hold", seconds, lambda elapsed: q, lambda elapsed: opening)

    def grip(self, opening: float, speed: float, max_effort: float) -> GripResult:
        """Be at an opening, or where the object would meet the limit of the effort."""
        gripper, start, q = self.gripper, self._newest.opening, self._newest.q
        speed = min(max(speed, gripper.min_speed), gripper.max_speed)
        met = self._width * (1 - max_effort / EFFORT_PER_STRAIN) if math.isfinite(max_effort) else 0.0
        stalls = opening < min(met, start)
        goal = max(opening, min(met, start)) if stalls else opening
        sign = math.copysign(1.0, goal - start)
        self._go(
            "gripper",
            abs(goal - start) / speed,
            lambda elapsed: q,
            lambda elapsed: start + sign * min(speed * elapsed, abs(goal - start)),
        )
        return GripResult.STALLED if stalls else GripResult.REACHED

    def stop(self) -> None:
        """Nothing moves."""

    def close(self) -> None:
        """Nothing is held; the robot in whose place this stands has an owner."""

    def _go(
        self, kind: str, seconds: float, path: Callable[[float], Array], opening: Callable[[float], float]
    ) -> None:
        begin = self._newest.time
        for elapsed in np.append(np.arange(SAMPLE_TIME, seconds, SAMPLE_TIME), seconds):
            self._newest = self._sample(
                begin + float(elapsed), path(float(elapsed)), opening(float(elapsed)), kind
            )
            for sink in self._sinks:
                sink(self._newest)
        place = self.arm.tool_pose(self._newest.q)[:3, 3]
        self.moves.append(Move(kind, begin, seconds, place, self._newest.opening))

    def _sample(self, time: float, q: Array, opening: float, kind: str) -> Sample:
        last = self._newest
        if self._pull and opening >= self._width:
            self._pull, self._static = 0.0, None
        if self._static is None or self._static[0] is not q:
            self._static = (q, self._torque(q))
        tau = self._static[1] + TORQUE_SD * self._rng.standard_normal(len(q))
        dq = (q - last.q) / (time - last.time) if time > last.time else last.dq
        closing = kind == "gripper" and opening < last.opening
        effort = EFFORT_PER_STRAIN * max(1 - opening / self._width, 0.0) if closing else 0.0
        return Sample(time, q, dq, tau, opening, effort)

    def _torque(self, q: Array) -> Array:
        """Return what holds the arm against gravity and the pull at its pads [N m]."""
        torque = self.arm.gravity(q)
        if self._pull:
            up = self.arm.tool_pose(q)[:3, :3].T @ np.array([0.0, 0.0, self._pull])
            torque = torque - self.arm.tool_jacobian(q)[:3].T @ up
        return torque
