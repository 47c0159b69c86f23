"""A light robot for the emulator: exact joints, torques by rigid-body dynamics, a block between the fingers.

It has no contacts and no time steps: what it does at an instant follows from the clock, so it runs anywhere
and never lags.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicSpline

from dynamics.arm import Arm
from dynamics.errors import InvalidInput
from dynamics.gripper import ParallelGripper, robotiq_2f85
from dynamics.signals import Sample
from dynamics.trajectory import Trajectory
from hw.emulator.backend import State
from models.robot import Revision

Array = NDArray[np.float64]

HOME = np.radians([0.0, 15.0, 180.0, -130.0, 0.0, 55.0, 90.0])
BRAKING_TIME = 0.15  # s from the order to stop until the joints rest
CURRENT_LIMIT = 1.0  # A, the most the closing gripper draws
STALL_TIME = 0.15  # s for which a gripper that cannot go on keeps pushing
HOLDING_CURRENT = 0.05  # A of a gripper that stands and presses


@dataclass(frozen=True)
class Block:
    """An elastic block between the fingers.

    Attributes:
        width: [m].
        stiffness: force per compression [N/m].
        mass: carried by the arm as long as the fingers press [kg].
        offset: of its centre of mass from the tool frame [m].
    """

    width: float = 0.05
    stiffness: float = 5000.0
    mass: float = 0.3
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        for name, least in (("width", 0.0), ("stiffness", 0.0), ("mass", -1e-12)):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > least):
                raise InvalidInput(f"block: {name}", value, "a number > 0 (the mass may be 0)")


@dataclass(frozen=True)
class _Motion:
    """The joints along a spline from a start time on, perhaps braking from a later one."""

    spline: CubicSpline
    duration: float
    start: float
    braking_since: float | None = None

    def path_time(self, now: float) -> tuple[float, float]:
        """Return the time along the spline and how fast it passes."""
        if self.braking_since is None:
            return min(now - self.start, self.duration), float(now - self.start < self.duration)
        since = min(now - self.braking_since, BRAKING_TIME)
        begin = self.braking_since - self.start
        along = begin + since - since**2 / (2 * BRAKING_TIME)
        return min(along, self.duration), (1 - since / BRAKING_TIME) * float(along < self.duration)

    def over(self, now: float) -> bool:
        """Tell whether the joints rest."""
        return self.path_time(now)[1] <= 0


@dataclass(frozen=True)
class _Grip:
    """The gripper on its way to an opening."""

    target: float
    speed: float
    origin: float
    start: float

    def opening(self, now: float) -> float:
        """Return where the drive would have the pads."""
        travel = min(self.speed * (now - self.start), abs(self.target - self.origin))
        return self.origin + math.copysign(travel, self.target - self.origin)


class KinematicRobot:
    """The light robot.

    Args:
        revision, vision: which arm it is.
        block: what is between the fingers; nothing if None.
        q: where it stands at first [rad], (nv,); Kinova's home if None.
        torque_offset: constant error of each torque sensor [N m], (nv,).
        torque_noise: standard deviation of a torque sample [N m].
        seed: of the noise.
        clock: gives the time [s].
    """

    def __init__(
        self,
        revision: Revision = "V12",
        vision: bool = True,
        block: Block | None = None,
        q: ArrayLike | None = None,
        torque_offset: ArrayLike | None = None,
        torque_noise: float = 0.0,
        seed: int = 0,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._arm = Arm.gen3(revision, vision)
        self._gripper = robotiq_2f85()
        self.block = block
        self._stuck = False
        self._loaded = self._arm if block is None else _carrying(self._arm, block)
        self._clock = clock
        self._q = np.array(HOME if q is None else q, float)
        self._offset = np.zeros(self._arm.nv) if torque_offset is None else np.asarray(torque_offset, float)
        self._noise, self._rng = torque_noise, np.random.default_rng(seed)
        self._motion: _Motion | None = None
        self._grip: _Grip | None = None
        self._opening = self._gripper.max_opening
        self._stalled_since: float | None = None

    @property
    def arm(self) -> Arm:
        """The arm as it is."""
        return self._arm

    @property
    def gripper(self) -> ParallelGripper:
        """The gripper as it is."""
        return self._gripper

    def state(self) -> State:
        """Return what the robot does now."""
        now = self._clock()
        q, dq, ddq = self._joints(now)
        opening, effort, gripping = self._fingers(now)
        arm = self._loaded if self._force(opening) > 0 else self._arm
        torque = arm.inverse_dynamics(q, dq, ddq, rotors=False)
        torque += self._offset + self._noise * self._rng.standard_normal(len(q))
        sample = Sample(now, q, dq, torque, self._reported(opening), effort)
        speed = self._grip.speed if self._grip is not None and gripping else 0.0
        return State(sample, self._motion is not None, gripping, speed)

    def start_trajectory(self, trajectory: Trajectory) -> None:
        """Start moving the joints along a trajectory."""
        q = trajectory.q + (self._q - trajectory.q[0])
        spline = CubicSpline(trajectory.time, q, bc_type="clamped")
        self._motion = _Motion(spline, trajectory.duration, self._clock())

    def start_grip(self, opening: float, speed: float) -> None:
        """Start driving the gripper to an opening."""
        now = self._clock()
        self._fingers(now)
        limited = min(max(speed, self._gripper.min_speed), self._gripper.max_speed)
        self._stalled_since = None
        self._grip = _Grip(min(max(opening, 0.0), self._gripper.max_opening), limited, self._opening, now)

    def halt_arm(self) -> None:
        """Brake."""
        if self._motion is not None and self._motion.braking_since is None:
            self._motion = replace(self._motion, braking_since=self._clock())

    def halt_gripper(self) -> None:
        """Stop the gripper where it is."""
        self._fingers(self._clock())
        self._grip = None

    def jam(self) -> None:
        """Let the gripper no longer move."""
        self._stuck = True

    def close(self) -> None:
        """Nothing is held."""

    def _joints(self, now: float) -> tuple[Array, Array, Array]:
        """Return position, velocity and acceleration of the joints."""
        still = np.zeros(self._arm.nv)
        if self._motion is None:
            return self._q, still, still
        along, rate = self._motion.path_time(now)
        spline = self._motion.spline
        self._q = np.asarray(spline(along), float)
        if self._motion.over(now):
            self._motion = None
            return self._q, still, still
        slowing = 0.0 if self._motion.braking_since is None else -1 / BRAKING_TIME
        slope = np.asarray(spline(along, 1), float)
        return self._q, rate * slope, rate**2 * np.asarray(spline(along, 2), float) + slowing * slope

    def _fingers(self, now: float) -> tuple[float, float, bool]:
        """Return opening, current and whether the gripper moves."""
        if self._grip is None or self._stuck:
            pressing = self._force(self._opening) > 0
            return self._opening, HOLDING_CURRENT if pressing else 0.0, self._grip is not None
        wanted = self._grip.opening(now)
        closing = self._grip.target < self._grip.origin
        self._opening = max(wanted, min(self._stall_opening(), self._grip.origin)) if closing else wanted
        if self._opening > wanted:
            self._stalled_since = now if self._stalled_since is None else self._stalled_since
        stalled = self._stalled_since is not None and now - self._stalled_since > STALL_TIME
        if stalled or self._opening == self._grip.target:
            self._grip = self._stalled_since = None
            return self._fingers(now)
        return self._opening, self._current(self._opening) if closing else 0.0, True

    def _force(self, opening: float) -> float:
        """Return the force of the pads on the block [N]."""
        return 0.0 if self.block is None else max(self.block.width - opening, 0.0) * self.block.stiffness

    def _current(self, opening: float) -> float:
        """Return the current that the closing gripper draws [A]."""
        gripper = self._gripper
        current = max(self._force(opening) - gripper.friction_force, 0.0) / gripper.force_per_ampere
        return round(min(current, CURRENT_LIMIT) / gripper.effort_quantum) * gripper.effort_quantum

    def _stall_opening(self) -> float:
        """Return the opening at which the gripper's own force is at its end [m]."""
        if self.block is None:
            return 0.0
        strongest = CURRENT_LIMIT * self._gripper.force_per_ampere + self._gripper.friction_force
        return max(self.block.width - strongest / self.block.stiffness, 0.0)

    def _reported(self, opening: float) -> float:
        """Return the opening as the gripper's counter says it [m]."""
        quantum = self._gripper.opening_quantum
        return min(round(opening / quantum) * quantum, self._gripper.max_opening)


def _carrying(arm: Arm, block: Block) -> Arm:
    """Return the arm with the block's mass fixed in its tool frame."""
    model = pin.Model(arm.model)
    frame = model.frames[model.getFrameId(arm.tool_frame)]
    inertia = pin.Inertia(block.mass, np.array(block.offset), np.zeros((3, 3)))
    model.appendBodyToJoint(frame.parentJoint, inertia, frame.placement)
    return Arm(model, arm.tool_frame)
