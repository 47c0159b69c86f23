"""The arm: rigid-body dynamics of a manipulator with a named tool frame, by Pinocchio.

Conventions, for the whole project: joint positions ``q`` in rad, one number a joint also for continuous
joints; torque ``tau`` in N m, positive along the joint's axis, as the arm exerts it on its links, so that at
rest ``tau = gravity(q)``. Gravity points along -z of the base and is 9.81 m/s^2. Poses are 4 x 4 homogeneous
matrices that take tool coordinates to base coordinates.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, NDArray

from dynamics.errors import InvalidInput, UnknownName
from dynamics.named import example_description
from dynamics.payload import dynamic_wrench_regressor, static_wrench_regressor
from models.robot import Revision, as_file, gen3_mjcf

Array = NDArray[np.float64]

# Kinova Gen3: speeds and torques of the maker's URDF, accelerations of its motion-planning configuration.
_GEN3_VELOCITY = np.array([1.3963] * 4 + [1.2218] * 3)  # rad/s
_GEN3_ACCELERATION = np.array([1.0] * 4 + [10.0] * 3)  # rad/s^2
_GEN3_EFFORT = np.array([39.0] * 4 + [9.0] * 3)  # N m


class Arm:
    """A serial arm with a tool frame.

    Attributes:
        name: what the arm is called in messages and files.
        tool_frame: name of the frame that payloads and poses refer to.
        nv: number of joints.
        joint_names: their names, in order.
        lower, upper: joint limits [rad], infinite where a joint has none, (nv,).
        velocity_limit, acceleration_limit, effort_limit: [rad/s, rad/s^2, N m], infinite where unknown, (nv,).
        geometry: collision shapes of the links, where the description has them.
        torque_gain_sd: how well the scale of its torque sensors is known, relative [-]; who has better calibrated
            ones, as a simulation has, sets it.
    """

    torque_gain_sd = 0.01  # what makers of joint torque sensors state at best; it does not average out

    def __init__(
        self,
        model: pin.Model,
        tool_frame: str,
        geometry: pin.GeometryModel | None = None,
        acceleration_limit: ArrayLike | None = None,
    ) -> None:
        names = [frame.name for frame in model.frames]
        if tool_frame not in names:
            raise UnknownName(f"tool frame of {model.name}", tool_frame, names)
        self.name = model.name
        self.tool_frame = tool_frame
        self.nv: int = model.nv
        self.joint_names = tuple(model.names)[1:]
        self.geometry = geometry
        self.model = model
        self._data = model.createData()
        self._tool = model.getFrameId(tool_frame)
        self._continuous = np.array([joint.nq == 2 for joint in model.joints][1:])
        if not all(joint.nv == 1 for joint in list(model.joints)[1:]):
            raise InvalidInput(f"robot {model.name}", "a joint of several degrees of freedom", "1-dof joints")
        index_q = np.array([joint.idx_q for joint in list(model.joints)[1:]])
        no_limit = np.full(self.nv, np.inf)
        self.lower = np.where(self._continuous, -no_limit, model.lowerPositionLimit[index_q])
        self.upper = np.where(self._continuous, no_limit, model.upperPositionLimit[index_q])
        self.velocity_limit: Array = np.where(model.velocityLimit > 0, model.velocityLimit, np.inf)
        self.effort_limit: Array = np.where(model.effortLimit > 0, model.effortLimit, np.inf)
        self.acceleration_limit: Array = (
            no_limit if acceleration_limit is None else np.asarray(acceleration_limit, float)
        )

    @classmethod
    def gen3(cls, revision: Revision = "V12", vision: bool = True, gripper: str | None = "2f85") -> Arm:
        """Return the Kinova Gen3 with its fingers locked open.

        Args:
            revision: hardware revision, ``V12`` or ``BRAKES``; they differ by up to 0.4 N m of gravity torque.
            vision: whether the bracelet carries the vision module.
            gripper: ``2f85``, or None for the bare flange.
        """
        try:
            mjcf = gen3_mjcf(revision, vision, gripper)
        except ValueError as error:
            raise InvalidInput("Arm.gen3", (revision, vision, gripper), str(error)) from None
        with as_file(mjcf) as path:
            model = pin.buildModelFromMJCF(str(path))
            geometry = pin.buildGeomFromMJCF(model, str(path), pin.GeometryType.COLLISION)
        fingers = [model.getJointId(name) for name in model.names if name.endswith(("_crank_joint", "_pad_joint"))]
        model, geometry = pin.buildReducedModel(model, geometry, fingers, pin.neutral(model))
        model.name = f"gen3-{revision}" + ("-vision" if vision else "") + (f"-{gripper}" if gripper else "")
        model.velocityLimit = _GEN3_VELOCITY
        model.effortLimit = _GEN3_EFFORT
        return cls(model, "tool_frame", geometry, _GEN3_ACCELERATION)

    @classmethod
    def named(cls, name: str) -> Arm:
        """Return an arm by name: ``gen3``, or one of example-robot-data such as ``ur10`` or ``panda``.

        Raises:
            UnknownName: if there is no such arm; the message lists those that there are.
        """
        if name == "gen3":
            return cls.gen3()
        path, tool_frame = example_description(name)
        return cls.from_urdf(path, tool_frame)

    @classmethod
    def from_urdf(cls, path: str | Path, tool_frame: str) -> Arm:
        """Load an arm from a URDF file; joints that do not move the tool are locked at zero."""
        return cls(_chain(_load(pin.buildModelFromUrdf, path), tool_frame), tool_frame)

    @classmethod
    def from_mjcf(cls, path: str | Path, tool_frame: str) -> Arm:
        """Load an arm from an MJCF file; joints that do not move the tool are locked at zero."""
        return cls(_chain(_load(pin.buildModelFromMJCF, path), tool_frame), tool_frame)

    def gravity(self, q: ArrayLike) -> Array:
        """Return the torque that holds the arm still, g(q) [N m], (nv,)."""
        torque: Array = pin.computeGeneralizedGravity(self.model, self._data, self.configuration(q))
        return torque.copy()

    def inverse_dynamics(self, q: ArrayLike, dq: ArrayLike, ddq: ArrayLike, rotors: bool = True) -> Array:
        """Return the torque of a motion, M(q) ddq + C(q, dq) dq + g(q) [N m], (nv,).

        Args:
            q, dq, ddq: position, velocity and acceleration [rad, rad/s, rad/s^2], (nv,).
            rotors: include the reflected inertia of the rotors, as a motor feels it. A torque sensor at the
                joint's output does not: pass False for its reading.
        """
        acceleration = self._vector(ddq, "ddq")
        torque: Array = pin.rnea(
            self.model, self._data, self.configuration(q), self._vector(dq, "dq"), acceleration
        ).copy()
        return torque if rotors else torque - self.model.armature * acceleration

    def payload_regressor(self, q: ArrayLike, dq: ArrayLike | None = None, ddq: ArrayLike | None = None) -> Array:
        """Return what a body in the tool adds to the joint torques, linear in its parameters.

        tau = B(q) [m, m c] at rest, tau = B(q, dq, ddq) [m, m c, I] in motion; see :mod:`dynamics.payload`.

        Args:
            q: joint positions [rad], (nv,).
            dq, ddq: velocity and acceleration [rad/s, rad/s^2], (nv,); both, or neither for an arm at rest.

        Returns:
            (nv, 4) at rest, (nv, 10) in motion.
        """
        if (dq is None) != (ddq is None):
            raise InvalidInput(f"{self.name}: payload regressor", "dq or ddq alone", "both, or neither")
        if dq is None or ddq is None:
            rotation = self.tool_pose(q)[:3, :3]
            wrench = static_wrench_regressor(rotation.T @ self.model.gravity.linear)
        else:
            motion = (self.configuration(q), self._vector(dq, "dq"), self._vector(ddq, "ddq"))
            pin.forwardKinematics(self.model, self._data, *motion)
            pose = pin.updateFramePlacement(self.model, self._data, self._tool)
            tool = (self.model, self._data, self._tool, pin.ReferenceFrame.LOCAL)
            velocity = pin.getFrameVelocity(*tool).vector
            acceleration = pin.getFrameAcceleration(*tool).vector.copy()
            acceleration[:3] -= pose.rotation.T @ self.model.gravity.linear
            wrench = dynamic_wrench_regressor(velocity, acceleration)
        regressor: Array = self.tool_jacobian(q).T @ wrench
        return regressor

    def mass_matrix(self, q: ArrayLike) -> Array:
        """Return the joint-space mass matrix, rotors included [kg m^2], (nv, nv)."""
        upper = np.triu(pin.crba(self.model, self._data, self.configuration(q)))
        matrix: Array = upper + np.triu(upper, 1).T
        return matrix

    def tool_pose(self, q: ArrayLike) -> Array:
        """Return the pose of the tool frame in the base, (4, 4)."""
        pin.forwardKinematics(self.model, self._data, self.configuration(q))
        pose: Array = pin.updateFramePlacement(self.model, self._data, self._tool).homogeneous
        return pose

    def tool_jacobian(self, q: ArrayLike) -> Array:
        """Return the Jacobian of the tool's twist in the tool frame, linear rows first, (6, nv)."""
        jacobian: Array = pin.computeFrameJacobian(
            self.model, self._data, self.configuration(q), self._tool, pin.ReferenceFrame.LOCAL
        )
        return jacobian

    @property
    def reach(self) -> float:
        """Distance from the first joint to the tool along the links [m], an upper limit of its reach."""
        steps = [placement.translation for placement in list(self.model.jointPlacements)[2:]]
        return float(
            sum(np.linalg.norm(step) for step in [*steps, self.model.frames[self._tool].placement.translation])
        )

    def within_limits(self, q: ArrayLike) -> bool:
        """Tell whether every joint is inside its limits."""
        angles = self._vector(q, "q")
        return bool(np.all(angles >= self.lower) and np.all(angles <= self.upper))

    def configuration(self, q: ArrayLike) -> Array:
        """Return Pinocchio's configuration of joint angles: continuous joints become cosine and sine."""
        angles = self._vector(q, "q")
        if not self._continuous.any():
            return angles
        parts = [
            [np.cos(a), np.sin(a)] if turning else [a] for a, turning in zip(angles, self._continuous, strict=True)
        ]
        return np.concatenate(parts)

    def _vector(self, values: ArrayLike, name: str) -> Array:
        vector = np.asarray(values, float)
        if vector.shape != (self.nv,):
            raise InvalidInput(f"{self.name}: {name}", f"shape {vector.shape}", f"({self.nv},), one a joint")
        return vector


def _chain(model: pin.Model, tool_frame: str) -> pin.Model:
    """Lock the joints that do not move the tool, such as fingers."""
    if not model.existFrame(tool_frame):
        return model  # the constructor names what is wrong
    moving = set(model.supports[model.frames[model.getFrameId(tool_frame)].parentJoint])
    locked = [joint for joint in range(1, model.njoints) if joint not in moving]
    return pin.buildReducedModel(model, locked, pin.neutral(model)) if locked else model


def _load(build: Any, path: str | Path) -> pin.Model:
    """Build a model from a file; the parser's own words are kept when it fails."""
    if not Path(path).is_file():
        raise InvalidInput("robot description", str(path), "an existing file")
    try:
        return build(str(path))
    except Exception as error:
        raise InvalidInput(f"robot description {path}", str(error), "a model that Pinocchio can load") from None
