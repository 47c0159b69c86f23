"""The limits that this side enforces, before a motion on its path and during it on every reading."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dynamics.arm import Arm
from dynamics.errors import InvalidInput, MotionRefused
from dynamics.trajectory import Trajectory
from hw.kortex.codes import ArmState, name_of
from hw.kortex.errors import ArmFault, EmergencyStopped, LimitExceeded
from hw.kortex.units import Reading

Array = NDArray[np.float64]

START_TOLERANCE = 0.02  # rad between where a trajectory starts and where the arm stands
PATH_STEP = 0.05  # s between the checked points of a trajectory
DAMPING = 1e-3  # of the wrench; offsets of 0.3 N m then look like 8 N at most, over 3000 random poses
FORCE_READINGS = 5  # readings in a row before a force counts: impacts of the arm's own start pass


@dataclass(frozen=True)
class SafetyLimits:
    """What must never be exceeded.

    Attributes:
        position_margin: distance kept from the joint limits [rad].
        speed_share: of the joint speed limits [-]; measured speed may be a tenth above it.
        torque_share: of the joint torque limits [-].
        force: on the tool, as the joint torques tell it [N].
        workspace_lower, workspace_upper: corners of the box for the tool frame, in the base frame [m].
        feedback_timeout: silence of the feedback after which the arm is stopped [s].
    """

    position_margin: float = 0.02
    speed_share: float = 1.0
    torque_share: float = 1.0
    force: float = 80.0
    workspace_lower: tuple[float, float, float] = (-1.0, -1.0, -0.05)
    workspace_upper: tuple[float, float, float] = (1.0, 1.0, 1.4)
    feedback_timeout: float = 0.25

    def __post_init__(self) -> None:
        for name in ("speed_share", "torque_share"):
            if not 0 < getattr(self, name) <= 1:
                raise InvalidInput(f"safety: {name}", getattr(self, name), "a share in (0, 1]")
        for name in ("force", "feedback_timeout"):
            if not (math.isfinite(getattr(self, name)) and getattr(self, name) > 0):
                raise InvalidInput(f"safety: {name}", getattr(self, name), "a number > 0")
        if not 0 <= self.position_margin < 1:
            raise InvalidInput("safety: position_margin", self.position_margin, "0 to 1 rad")
        corners = self.workspace_lower, self.workspace_upper
        if not all(len(corner) == 3 for corner in corners) or not np.all(np.less(*corners)):
            raise InvalidInput("safety: workspace", corners, "two corners of 3 numbers, lower below upper")


class SafetyMonitor:
    """Checks paths and readings against the limits.

    Args:
        arm: the description; the monitor computes on a copy, for it runs beside its owner.
        limits: what must not be exceeded.
    """

    def __init__(self, arm: Arm, limits: SafetyLimits) -> None:
        self.limits = limits
        self._arm = Arm(arm.model, arm.tool_frame, arm.geometry, arm.acceleration_limit)
        self._pressed = 0
        self._lower = arm.lower + limits.position_margin
        self._upper = arm.upper - limits.position_margin
        self._speed = limits.speed_share * arm.velocity_limit
        self._torque = limits.torque_share * arm.effort_limit

    def check_reading(self, found: Reading) -> None:
        """Look at a reading.

        Raises:
            EmergencyStopped: if the emergency stop is active.
            ArmFault: if the arm reports another fault.
            LimitExceeded: if a measured quantity is outside its limit.
        """
        if found.emergency:
            raise EmergencyStopped(found.faults)
        if found.faults or found.state == ArmState.IN_FAULT:
            raise ArmFault(found.faults or (name_of(ArmState, found.state),))
        sample = found.sample
        margin = self.limits.position_margin
        self._bound("position", sample.q, self._lower - margin, self._upper + margin, "rad")
        self._bound("speed", sample.dq, -1.1 * self._speed, 1.1 * self._speed, "rad/s")
        self._bound("torque", sample.tau, -self._torque, self._torque, "N m")
        self._place(self._arm.tool_pose(sample.q)[:3, 3])
        force = self.tool_force(sample.q, sample.dq, sample.tau)
        self._pressed = self._pressed + 1 if force > self.limits.force else 0
        if self._pressed >= FORCE_READINGS:
            raise LimitExceeded(f"force on the tool: {force:.0f} N; limit: {self.limits.force:g} N")

    def tool_force(self, q: Array, dq: Array, tau: Array) -> float:
        """Return the force on the tool that best explains the torques beyond the model's [N]."""
        rest = tau - self._arm.inverse_dynamics(q, dq, np.zeros(self._arm.nv), rotors=False)
        jacobian = self._arm.tool_jacobian(q)
        normal = jacobian @ jacobian.T + DAMPING * np.eye(6)
        wrench = np.linalg.solve(normal, jacobian @ rest)
        return float(np.linalg.norm(wrench[:3]))

    def check_path(self, trajectory: Trajectory, q: Array) -> None:
        """Look at a trajectory before it is run.

        Args:
            trajectory: the motion.
            q: where the arm stands [rad], (nv,).

        Raises:
            InvalidInput: if it is none for this arm.
            MotionRefused: if it starts elsewhere or leaves a limit.
        """
        arm, path, time = self._arm, np.asarray(trajectory.q, float), np.asarray(trajectory.time, float)
        if path.ndim != 2 or path.shape[1] != arm.nv or len(path) < 2 or not np.all(np.isfinite(path)):
            raise InvalidInput("trajectory", f"shape {path.shape}", f"finite positions, (N, {arm.nv}), N > 1")
        if time.shape != (len(path),) or not np.all(np.isfinite(time)) or np.any(np.diff(time) <= 0):
            raise InvalidInput("trajectory: time", f"shape {time.shape}", f"increasing times, ({len(path)},)")
        away = np.abs(path[0] - q)
        if away.max() > START_TOLERANCE:
            joint = int(np.argmax(away))
            raise MotionRefused(
                f"the trajectory does not start where the arm stands: joint {joint + 1} is at {q[joint]:.3f} rad, "
                f"the trajectory starts at {path[0, joint]:.3f}"
            )
        try:
            self._bound("position", path.min(axis=0), self._lower, self._upper, "rad")
            self._bound("position", path.max(axis=0), self._lower, self._upper, "rad")
            speed = np.abs(np.diff(path, axis=0) / np.diff(time)[:, None]).max(axis=0)
            self._bound("speed", speed, -np.inf * self._speed, 1.001 * self._speed, "rad/s")
            for moment in np.append(np.arange(0.0, trajectory.duration, PATH_STEP), trajectory.duration):
                point = trajectory.position(float(moment))
                self._place(arm.tool_pose(point)[:3, 3])
                self._bound("gravity torque", arm.gravity(point), -self._torque, self._torque, "N m")
        except LimitExceeded as error:
            raise MotionRefused(f"the trajectory leaves a limit: {error}") from None

    def _bound(self, name: str, values: Array, lower: Array, upper: Array, unit: str) -> None:
        outside = (values < lower) | (values > upper)
        if np.any(outside):
            joint = int(np.argmax(outside))
            limit = upper[joint] if values[joint] > upper[joint] else lower[joint]
            raise LimitExceeded(f"{name} of joint {joint + 1}: {values[joint]:.3f}; limit: {limit:.3f} {unit}")

    def _place(self, point: Array) -> None:
        lower, upper = np.array(self.limits.workspace_lower), np.array(self.limits.workspace_upper)
        if np.any(point < lower) or np.any(point > upper):
            found = ", ".join(f"{x:.3f}" for x in point)
            raise LimitExceeded(f"tool at ({found}) m; workspace: {lower.tolist()} to {upper.tolist()} m")
