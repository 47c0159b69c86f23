"""The check before the first motion: the arm that was meant, in good health, with torques that make sense."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dynamics.arm import Arm
from hw.kortex import client, codes
from hw.kortex.codes import ArmState, ServoingMode, name_of
from hw.kortex.tcp import TcpSession
from hw.kortex.units import Reading

Array = NDArray[np.float64]

MOVING = 0.02  # rad/s; a joint that is faster is not at rest
GRIPPER_MASS = 0.925  # kg, Kinova's figure for the 2F-85
STRANGE_CURRENT = 10.0  # A; a gripper reading above it comes in mA
# N m; what good sensors may be off by from start to start and with the direction of the last motion. Sensors
# that were never zeroed are seen to be off by 1 to 2.5.
TOLERANCES = (1.0, 1.0, 1.0, 1.0, 0.8, 0.8, 0.8)
BETTER = 2.0  # another revision whose torques fit so many times better is the likelier one
TELLING_TOLERANCE = 1.5  # N m; sensors that may be further off cannot tell revisions apart in one pose
TELLING = 0.15  # N m by which it must do so


@dataclass(frozen=True)
class TorqueCheck:
    """Measured torques against the model's, arm at rest, gripper empty.

    Attributes:
        measured, modelled: [N m], (nv,).
        tolerance: how far they may be apart [N m], (nv,).
        misfit: norm of the difference for each hardware revision [N m].
        revision: the one that was assumed.
    """

    measured: Array
    modelled: Array
    tolerance: Array
    misfit: Mapping[str, float]
    revision: str

    @property
    def telling(self) -> bool:
        """Whether the tolerance is tight enough to tell the hardware revisions apart."""
        return float(np.max(self.tolerance, initial=0.0)) < TELLING_TOLERANCE

    @property
    def problems(self) -> tuple[str, ...]:
        """What is wrong, one line each."""
        found = []
        for joint in np.flatnonzero(np.abs(self.measured - self.modelled) > self.tolerance):
            found.append(
                f"joint {joint + 1} reads {self.measured[joint]:+.2f} N m, the {self.revision} model with the "
                f"empty gripper says {self.modelled[joint]:+.2f} (tolerance {self.tolerance[joint]:.2f})"
            )
        own = self.misfit[self.revision]
        for name, other in self.misfit.items():
            if self.telling and own > BETTER * other and own - other > TELLING:
                found.append(
                    f"the torques fit a {name} arm ({other:.2f} N m off) better than a {self.revision} "
                    f"({own:.2f} N m off): is the revision right?"
                )
        if found:
            found.append("an offset of the torque sensors is removed by zeroing or a tare (python -m hw.check)")
        return tuple(found)


@dataclass(frozen=True)
class CheckReport:
    """What the check found.

    Attributes:
        facts: name and value of what was read, for people.
        problems: what makes moving unsafe.
        warnings: what a person should know.
        torques: measured against the model.
    """

    facts: tuple[tuple[str, str], ...]
    problems: tuple[str, ...]
    warnings: tuple[str, ...]
    torques: TorqueCheck


def examine(
    session: TcpSession,
    readings: Sequence[Reading],
    arms: Mapping[str, Arm],
    revision: str,
    vision: bool,
    tolerance: Sequence[float] = TOLERANCES,
) -> CheckReport:
    """Look at everything that must be right before the arm may move; nothing moves.

    Args:
        session: to ask the arm.
        readings: of the last moments, the arm at rest and the gripper empty, torque offsets removed.
        arms: the model of each hardware revision.
        revision: the one that is assumed.
        vision: whether the arm is assumed to carry the vision module.
        tolerance: how far each torque may be off [N m], (nv,).
    """
    arm, newest = arms[revision], readings[-1]
    product = client.product(session)
    mode = client.servoing_mode(session)
    problems = identity_problems(product, arm.nv, vision)
    problems += [f"fault: {fault}" for fault in newest.faults]
    if newest.state != ArmState.SERVOING_READY:
        problems.append(f"arm state {name_of(ArmState, newest.state)}; valid: SERVOING_READY")
    if mode != ServoingMode.SINGLE_LEVEL:
        problems.append(f"servoing mode {name_of(ServoingMode, mode)}; valid: SINGLE_LEVEL")
    q, speed = newest.sample.q, np.abs(newest.sample.dq).max() if len(newest.sample.dq) else 0.0
    if speed > MOVING:
        problems.append(f"the arm is moving at {speed:.2f} rad/s")
    tool, payload = client.tool_mass(session), client.payload_mass(session)
    warnings = [f"warning: {warning}" for warning in newest.warnings]
    if abs(tool - GRIPPER_MASS) > 0.05:
        warnings.append(f"the arm counts with a tool of {tool:.3f} kg, the gripper has {GRIPPER_MASS} kg")
    if payload > 0:
        warnings.append(f"the arm counts with a payload of {payload:.3f} kg: set it to 0 for the empty gripper")
    if abs(newest.sample.effort) > STRANGE_CURRENT:
        problems.append(f"the gripper's current reads {newest.sample.effort:g} A: it seems to come in mA")
    if len(q) == arm.nv:
        if not arm.within_limits(q):
            problems.append("a joint is outside its limits")
        torques = torque_check(readings, arms, revision, tolerance)
        problems += torques.problems
        if not torques.telling:
            warnings.append("the torque tolerance is too wide to tell the hardware revisions apart")
    else:
        torques = TorqueCheck(np.zeros(0), np.zeros(0), np.zeros(0), {revision: 0.0}, revision)
    facts = (
        ("model", name_of(codes.Model, product.model)),
        ("serial", product.serial),
        ("joints", str(product.joints)),
        ("gripper", name_of(codes.EndEffector, product.end_effector)),
        ("vision", name_of(codes.Vision, product.vision)),
        ("state", name_of(ArmState, newest.state)),
        ("servoing", name_of(ServoingMode, mode)),
        ("tool, payload", f"{tool:.3f} kg, {payload:.3f} kg"),
        ("opening", f"{1000 * newest.sample.opening:.1f} mm at {newest.sample.effort:.2f} A"),
    )
    return CheckReport(facts, tuple(problems), tuple(warnings), torques)


def identity_problems(product: client.Product, joints: int, vision: bool) -> list[str]:
    """Return why this is not the arm that was meant."""
    found = []
    if product.model != codes.Model.GEN3:
        found.append(f"model {name_of(codes.Model, product.model)}; valid: GEN3")
    if product.joints != joints:
        found.append(f"an arm of {product.joints} joints; valid: {joints}")
    if product.end_effector not in (codes.EndEffector.ROBOTIQ_2F_85, codes.EndEffector.UNSPECIFIED):
        found.append(f"gripper {name_of(codes.EndEffector, product.end_effector)}; valid: ROBOTIQ_2F_85")
    carries = product.vision not in (codes.Vision.NOT_INSTALLED, codes.Vision.UNSPECIFIED)
    if product.vision != codes.Vision.UNSPECIFIED and carries != vision:
        found.append(f"the arm is {'with' if carries else 'without'} a vision module, the model is not")
    return found


def torque_check(
    readings: Sequence[Reading], arms: Mapping[str, Arm], revision: str, tolerance: Sequence[float] = TOLERANCES
) -> TorqueCheck:
    """Return the mean measured torque beside the model's, for each hardware revision."""
    q = np.mean([r.sample.q for r in readings], axis=0)
    measured = np.mean([r.sample.tau for r in readings], axis=0)
    modelled = {name: arm.gravity(q) for name, arm in arms.items()}
    misfit = {name: float(np.linalg.norm(measured - torque)) for name, torque in modelled.items()}
    return TorqueCheck(measured, modelled[revision], np.asarray(tolerance, float), misfit, revision)
