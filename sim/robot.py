"""The simulated robot: a Gen3 with its gripper over a table in MuJoCo, read through a declared sensor model.

Only what the `Robot` protocol offers leaves this class; what the object really is stays inside.
"""

from __future__ import annotations

import dataclasses
import math
import warnings
from collections.abc import Callable
from typing import TYPE_CHECKING

import mujoco
import numpy as np
from numpy.typing import NDArray

from dynamics.arm import Arm
from dynamics.errors import InvalidInput, MotionRefused, PalpateError, UnknownName
from dynamics.gripper import ParallelGripper, robotiq_2f85
from dynamics.kinematics import solve_pose, tool_down
from dynamics.robot import CannotDraw, GripResult, SampleSink
from dynamics.signals import Sample
from dynamics.trajectory import Trajectory
from models.robot import Revision
from sim.bodies import Fidelity, prepare
from sim.contact import TIMESTEP
from sim.opengl import PACKAGES, check_drawing
from sim.scene import ARM_GAINS, GRIPPER_DAMPING, GRIPPER_STIFFNESS, scene_mjcf
from sim.sensors import SensorModel, Sensors
from sim.stepping import Stepper
from sim.truth import TrueObject

if TYPE_CHECKING:
    from sim.viewer import Viewer

Array = NDArray[np.float64]

SAMPLE_STEPS = 5  # simulation steps a sample: 100 Hz
_SETTLE = 0.4  # s for the object to come to rest on the table before the robot's clock starts
_START_TOLERANCE = 0.02  # rad between where a trajectory starts and where the arm stands
_SPEED_ROUNDING = 1 + 1e-6
_STALL_MARGIN = 0.95  # share of the gripper's own force at which it stalls
_MAX_FORCE = 60.0  # N, what the gripper can press
_GRIP_ACCELERATION = 0.3  # m/s^2 of the pads
_GRIPPER_STIFFNESS, _GRIPPER_STIFFNESS_SD = 1.242e7, 2e5  # N/m, by `python -m sim.rigid_block`
_ELBOW_UP = np.radians([0.0, 20.0, 180.0, -110.0, 0.0, -50.0, 90.0])


class SimulationError(PalpateError):
    """The physics engine reported a warning, so nothing it computes can be trusted any more."""


class MujocoRobot:
    """A robot that lives in MuJoCo.

    Args:
        truth: the object on the table.
        noise: what the sensors add.
        seed: of everything random.
        fidelity: how the object deforms, see `sim.bodies`.
        revision, vision: which arm.
    """

    def __init__(
        self,
        truth: TrueObject,
        noise: SensorModel | None = None,
        seed: int = 0,
        fidelity: Fidelity = "uniform",
        revision: Revision = "V12",
        vision: bool = True,
    ) -> None:
        noise = noise or SensorModel()
        self._arm = Arm.gen3(revision, vision)
        self._arm.torque_gain_sd = noise.torque_gain
        self._gripper = _described(noise, fidelity)
        self._model = mujoco.MjModel.from_xml_string(scene_mjcf(truth, self._gripper, revision, vision, fidelity))
        prepare(self._model, truth)
        self._data = mujoco.MjData(self._model)
        self._sensors = Sensors(noise, np.random.default_rng(seed), self._arm.nv, SAMPLE_STEPS * TIMESTEP)
        self._sinks: list[SampleSink] = []
        self._joints = slice(0, self._arm.nv)
        gains = [ARM_GAINS["large"]] * 4 + [ARM_GAINS["small"]] * 3
        self._stiffness, self._damping = (np.array([g[i] for g in gains]) for i in (0, 1))
        self._armature = self._model.dof_armature[self._joints].copy()
        self._cranks = [self._model.joint(f"{side}_crank_joint").qposadr[0] for side in ("left", "right")]
        cranks = [self._model.joint(f"{side}_crank_joint").dofadr[0] for side in ("left", "right")]
        self._crank_dofs = np.array(cranks)
        self._open_angle = self._gripper.crank_angle(self._gripper.max_opening)
        self._grip_command = self._gripper.max_opening
        self._arm_command = start_position(self._arm)
        self._data.qpos[self._joints] = self._arm_command
        mujoco.mj_forward(self._model, self._data)
        self._stepper = Stepper(self._model, self._data, truth)
        self._finger_inertia = _finger_inertia(self._model, self._data)
        self._viewer: Viewer | None = None
        self._renderers: dict[tuple[int, int], mujoco.Renderer] = {}
        self._clock_start = 0.0
        self._advance(self._controls(round(_SETTLE / TIMESTEP)))
        self._clock_start = float(self._data.time)
        self._newest = self._sample(moving=False)

    @property
    def arm(self) -> Arm:
        """The arm's description."""
        return self._arm

    @property
    def gripper(self) -> ParallelGripper:
        """The gripper's description."""
        return self._gripper

    def listen(self, sink: SampleSink) -> None:
        """Hand every further sample to a function."""
        self._sinks.append(sink)

    def read(self) -> Sample:
        """Return the newest sample."""
        return self._newest

    def follow(self, trajectory: Trajectory) -> None:
        """Move the joints along a trajectory."""
        path = np.asarray(trajectory.q)
        if path.ndim != 2 or path.shape[1] != self._arm.nv or not np.all(np.isfinite(path)):
            raise InvalidInput("trajectory", f"shape {path.shape}", f"finite positions, (N, {self._arm.nv})")
        if np.abs(path[0] - self._arm_command).max() > _START_TOLERANCE:
            raise MotionRefused("the trajectory does not start where the arm stands")
        if not all(self._arm.within_limits(q) for q in path):
            raise MotionRefused("the trajectory leaves the joint limits")
        speed = np.abs(np.diff(path, axis=0)) / np.diff(trajectory.time)[:, None]
        if np.any(speed > self._arm.velocity_limit * _SPEED_ROUNDING):
            raise MotionRefused("the trajectory is faster than the joints can turn")

        def command(elapsed: Array) -> tuple[Array, bool]:
            positions = trajectory.positions(elapsed)
            self._arm_command = positions[-1]
            controls = self._controls(len(elapsed))
            controls[:, self._joints] = positions
            return controls, bool(elapsed[-1] >= trajectory.duration)

        self._run(command, moving_gripper=False)

    def hold(self, seconds: float) -> None:
        """Stand still for a time."""
        if not (math.isfinite(seconds) and seconds >= 0):
            raise InvalidInput("hold: seconds", seconds, "a number >= 0")
        controls = self._controls(SAMPLE_STEPS)
        self._run(lambda elapsed: (controls, bool(elapsed[-1] >= seconds - TIMESTEP / 2)), moving_gripper=False)

    def grip(self, opening: float, speed: float, max_effort: float = math.inf) -> GripResult:
        """Drive the gripper to an opening, or until its motor current exceeds a limit."""
        gripper = self._gripper
        if not 0 <= opening <= gripper.max_opening:
            raise InvalidInput("grip: opening", opening, f"0 to {gripper.max_opening} m")
        if not (math.isfinite(speed) and speed > 0 and max_effort > 0):
            raise InvalidInput("grip: speed and effort limit", (speed, max_effort), "numbers > 0")
        speed = min(max(speed, gripper.min_speed), gripper.max_speed)
        limit = min(max_effort, _STALL_MARGIN * _MAX_FORCE / gripper.force_per_ampere)
        start = self._grip_command
        closing = opening < start

        def command(elapsed: Array) -> tuple[Array, bool]:
            travels = [_ramped(float(at), abs(opening - start), speed) for at in elapsed]
            openings = [start + math.copysign(travel, opening - start) for travel in travels]
            self._grip_command = openings[-1]
            controls = self._controls(len(elapsed))
            controls[:, self._arm.nv] = [self._open_angle - gripper.crank_angle(at) for at in openings]
            return controls, travels[-1] >= abs(opening - start)

        stalled = self._run(
            command, moving_gripper=True, interrupt=lambda sample: closing and sample.effort > limit
        )
        return GripResult.STALLED if stalled else GripResult.REACHED

    def stop(self) -> None:
        """Stand still where the arm is; the gripper keeps its grip."""
        self._arm_command = self._data.qpos[self._joints].copy()

    def close(self) -> None:
        """Forget the listeners, and close what shows pictures."""
        self._sinks.clear()
        if self._viewer is not None:
            self._viewer.close()
            self._viewer = None
        while self._renderers:
            self._renderers.popitem()[1].close()

    @property
    def cameras(self) -> tuple[str, ...]:
        """Names of the cameras."""
        return tuple(self._model.camera(number).name for number in range(self._model.ncam))

    def picture(self, camera: str = "overview", width: int = 1080, height: int = 720) -> NDArray[np.uint8]:
        """Return what a camera of the scene sees, (height, width, 3).

        Without a display, `sim.opengl.choose_backend` has to be called before MuJoCo is first imported.

        Raises:
            UnknownName: if there is no camera of that name.
            CannotDraw: if there is no OpenGL.
        """
        if camera not in self.cameras:
            raise UnknownName("camera", camera, self.cameras)
        check_drawing()
        try:
            if (width, height) not in self._renderers:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")  # of a window library without a display
                    self._renderers[width, height] = mujoco.Renderer(self._model, height, width)
            renderer = self._renderers[width, height]
            renderer.update_scene(self._data, camera=camera)
            pixels: NDArray[np.uint8] = renderer.render()
            return pixels.copy()
        except Exception as error:  # whatever the system's OpenGL lacks
            raise CannotDraw(f"no picture without OpenGL (on Debian: {PACKAGES}): {error}") from error

    def show(self, speed: float = 1.0) -> None:
        """Open MuJoCo's interactive viewer, and from now on be no faster than a multiple of real time.

        Raises:
            CannotDraw: if there is no display.
        """
        from sim.viewer import Viewer

        self._viewer = Viewer(self._model, self._data, speed)
        self.listen(self._viewer.follow)

    def _run(
        self,
        command: Callable[[Array], tuple[Array, bool]],
        moving_gripper: bool,
        interrupt: Callable[[Sample], bool] | None = None,
    ) -> bool:
        """Step until a command says it is done, sample by sample; tell whether it was interrupted.

        Args:
            command: returns, for the times since its start at the ends of the next steps [s], (SAMPLE_STEPS,), the
                controls of these steps, (SAMPLE_STEPS, nu), and whether it is done with them.
            moving_gripper: whether the motor current tells of force.
            interrupt: tells whether to end after a sample.
        """
        elapsed, done = 0.0, False
        while not done:
            times = np.add.accumulate([elapsed, *[TIMESTEP] * SAMPLE_STEPS])[1:]
            elapsed = times[-1]
            controls, done = command(times)
            self._advance(controls)
            sample = self._sample(moving=moving_gripper)
            self._newest = sample
            for sink in self._sinks:
                sink(sample)
            if interrupt is not None and interrupt(sample):
                return True
        return False

    def _controls(self, count: int) -> Array:
        """Return the controls that keep arm and gripper where they were commanded to, (count, nu)."""
        controls = np.empty((count, self._model.nu))
        controls[:, self._joints] = self._arm_command
        controls[:, self._arm.nv] = self._open_angle - self._gripper.crank_angle(self._grip_command)
        return controls

    def _advance(self, controls: Array) -> None:
        """Step with every row of controls."""
        self._stepper.advance(controls)

    def _sample(self, moving: bool) -> Sample:
        """Read the sensors after a step."""
        data = self._data
        if data.warning.number.any():
            names = [mujoco.mjtWarning(i).name for i, w in enumerate(data.warning) if w.number]
            raise SimulationError(f"MuJoCo warned at {data.time:.3f} s: {', '.join(names)}")
        velocity, timestep = data.qvel[self._joints], self._stepper.timestep
        change = velocity - self._stepper.velocity_before[self._joints]
        # The engine reports the drives' force at the start of the step but applies it, implicitly, at its end;
        # a sensor behind the gear does not feel the rotor.
        applied = data.qfrc_actuator[self._joints] - self._stiffness * timestep * velocity - self._damping * change
        torque = applied - self._armature * change / timestep
        return self._sensors.sample(
            time=float(data.time) - self._clock_start,
            q=data.qpos[self._joints].copy(),
            dq=velocity.copy(),
            tau=torque,
            opening=self._opening(),
            current=self._current() if moving else None,
        )

    def _opening(self) -> float:
        """Return the true distance of the pads [m]."""
        angles = self._open_angle - self._data.qpos[self._cranks]
        return sum(self._gripper.opening(float(angle)) / 2 for angle in angles)

    def _current(self) -> float:
        """Return the current that the closing gripper draws for its force [A]."""
        data, gripper, timestep = self._data, self._gripper, self._stepper.timestep
        speed = data.qvel[self._crank_dofs].mean()
        change = speed - self._stepper.velocity_before[self._crank_dofs].mean()
        drive = data.actuator_force[self._arm.nv] - GRIPPER_STIFFNESS * timestep * speed - GRIPPER_DAMPING * change
        drive -= self._finger_inertia * change / timestep
        force = gripper.pad_force(float(drive), self._opening())
        friction = self._sensors.model.grip_friction
        return max(force - friction, 0.0) / gripper.force_per_ampere


def start_position(arm: Arm) -> Array:
    """Return the joint positions in which the simulated arm starts: elbow up, over the table [rad], (nv,)."""
    return solve_pose(arm, tool_down([0.42, 0.0, 0.38], 0.0), _ELBOW_UP)


def _described(noise: SensorModel, fidelity: Fidelity) -> ParallelGripper:
    """Return the gripper as its user knows it: calibrated as well as the sensors allow."""
    gripper = robotiq_2f85("face" if fidelity == "uniform" else "pad")
    return dataclasses.replace(
        gripper,
        opening_quantum=noise.opening_quantum,
        effort_quantum=noise.effort_quantum,
        force_per_ampere_sd=noise.effort_gain * gripper.force_per_ampere,
        friction_force=noise.grip_friction,
        friction_force_sd=0.0,
        stiffness=_GRIPPER_STIFFNESS,
        stiffness_sd=_GRIPPER_STIFFNESS_SD,
    )


def _ramped(elapsed: float, distance: float, speed: float) -> float:
    """Return the way made after a time by a move that speeds up and slows down at a constant rate [m]."""
    speed = min(speed, math.sqrt(distance * _GRIP_ACCELERATION))
    if speed == 0:
        return distance
    ramp = speed / _GRIP_ACCELERATION
    duration = distance / speed + ramp
    if elapsed >= duration:
        return distance
    if elapsed < ramp:
        return _GRIP_ACCELERATION * elapsed**2 / 2
    if elapsed <= duration - ramp:
        return speed * (elapsed - ramp / 2)
    return distance - _GRIP_ACCELERATION * (duration - elapsed) ** 2 / 2


def _finger_inertia(model: mujoco.MjModel, data: mujoco.MjData) -> float:
    """Return the inertia that the drive of the gripper feels when both fingers move [kg m^2]."""
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    names = [f"{side}_{part}_joint" for side in ("left", "right") for part in ("crank", "pad")]
    fingers = np.array([model.joint(name).dofadr[0] for name in names])
    return float(mass[np.ix_(fingers, fingers)].sum())
