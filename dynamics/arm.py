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
    """

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
    def from_urdf(cls, path: str | Path, tool_frame: str) -> Arm:
        """Load an arm from a URDF file."""
        return cls(_load(pin.buildModelFromUrdf, path), tool_frame)

    @classmethod
    def from_mjcf(cls, path: str | Path, tool_frame: str) -> Arm:
        """Load an arm from an MJCF file."""
        return cls(_load(pin.buildModelFromMJCF, path), tool_frame)

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


def _load(build: Any, path: str | Path) -> pin.Model:
    """Build a model from a file; the parser's own words are kept when it fails."""
    if not Path(path).is_file():
        raise InvalidInput("robot description", str(path), "an existing file")
    try:
        return build(str(path))
    except Exception as error:
        raise InvalidInput(f"robot description {path}", str(error), "a model that Pinocchio can load") from None
