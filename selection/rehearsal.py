"""Rehearse the next action: every motion planned and checked, none of them made, nothing recorded.

A stand-in for the robot follows the plan in thought. What its sensors would say is nominal: the torques of the arm
alone, and an object of the declared width that gives way evenly. What an action does by what it reads (how far and
how often it presses, when it has weighed enough) can therefore turn out otherwise.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dynamics.arm import Arm
from dynamics.errors import MotionRefused
from dynamics.gripper import ParallelGripper
from dynamics.objects import DeclaredObject
from dynamics.robot import GripResult, Robot, SampleSink
from dynamics.signals import Phase, Sample
from dynamics.trajectory import Trajectory

Array = NDArray[np.float64]
Judge = Callable[[Trajectory], None]

SAMPLE_TIME = 0.01  # s
EFFORT_PER_STRAIN = 3.0  # A for an object compressed by all of its width
TORQUE_SD = 0.3  # N m; readings as poor as can be expected, so that nothing ends early for having been read well
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


@dataclass(frozen=True)
class Rehearsed:
    """What a rehearsal came to.

    Attributes:
        action: its name.
        moves: all of them, in order; up to the one that failed, if any.
        phases: the stretches that would be measured.
        problem: why the action can not be done; empty if it can.
    """

    action: str
    moves: tuple[Move, ...]
    phases: tuple[Phase, ...]
    problem: str = ""

    @property
    def seconds(self) -> float:
        """How long the motions would take [s]."""
        return sum(move.seconds for move in self.moves)

    def phase_of(self, move: Move) -> str:
        """Return the name of the phase in which a move would be measured, or nothing."""
        middle = move.start + move.seconds / 2
        for phase in self.phases:
            if phase.samples and phase.samples[0].time - SAMPLE_TIME <= middle <= phase.samples[-1].time:
                return f"{phase.action} {phase.name}"
        return ""


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
        self._gravity: tuple[Array, Array] | None = None
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
        if self._gravity is None or self._gravity[0] is not q:
            self._gravity = (q, self.arm.gravity(q))
        tau = self._gravity[1] + TORQUE_SD * self._rng.standard_normal(len(q))
        dq = (q - last.q) / (time - last.time) if time > last.time else last.dq
        closing = kind == "gripper" and opening < last.opening
        effort = EFFORT_PER_STRAIN * max(1 - opening / self._width, 0.0) if closing else 0.0
        return Sample(time, q, dq, tau, opening, effort)


def told(rehearsed: Rehearsed) -> Sequence[str]:
    """Return a rehearsal as lines for people."""
    lines = []
    for move in rehearsed.moves:
        x, y, z = move.place
        where = {
            "arm": f"tool to ({x:.3f}, {y:.3f}, {z:.3f}) m",
            "gripper": f"to {1000 * move.opening:.1f} mm",
            "hold": "",
        }[move.kind]
        lines.append(f"  {move.seconds:6.2f} s  {move.kind:8} {where:34} {rehearsed.phase_of(move)}".rstrip())
    if rehearsed.problem:
        lines.append(f"cannot    {rehearsed.action}: {rehearsed.problem}")
        return lines
    count = {kind: sum(move.kind == kind for move in rehearsed.moves) for kind in ("arm", "gripper")}
    motions = f"{count['arm']} motions of the arm and {count['gripper']} of the gripper"
    lines.append(f"possible  {rehearsed.action}: {motions}, {rehearsed.seconds:.0f} s; nothing moved")
    lines.append("what it reads decides how far and how often it presses, and what comes after it")
    return lines
