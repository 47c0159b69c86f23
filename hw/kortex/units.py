"""One table between the arm's units and SI: degrees, percent, and the sign of the torques.

==================  =====================  ===========================================================
quantity            the arm                here
==================  =====================  ===========================================================
joint position      deg, 0 to 360          rad, from -174 to 186 deg; then turns are counted
joint velocity      deg/s                  rad/s
joint torque        N m, of the reaction   N m, of the arm on its links: at rest ``tau = gravity(q)``
gripper position    percent, 0 open        opening [m]
gripper command     0 open to 1 closed     opening [m]
gripper speed       share of full speed    m/s
gripper current     A                      A
==================  =====================  ===========================================================

The reversed torque is Kinova's own note (example 108 of its API) and seen on arms: joint 4 read -12.127 N m
where the model says +12.168. The gripper's percent runs with the angle of its cranks, not with millimetres:
one revolution of its worm turns them by the same angle everywhere.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dynamics.gripper import ParallelGripper
from dynamics.signals import Sample
from hw.kortex import codes
from hw.kortex import messages_pb2 as pb
from hw.kortex.errors import FrameError

Array = NDArray[np.float64]

TORQUE_SIGN = -1.0
FIRST_TURN = 0.1  # rad, middle of the first turn: 180 deg, where joint 3 rests at home, reads the same every time


@dataclass(frozen=True)
class Reading:
    """What one feedback says, in SI units.

    Attributes:
        sample: the signals.
        state: what the arm is doing, a number of codes.ArmState.
        faults: names of what is wrong, each with its place.
        warnings: names of what is about to go wrong.
        emergency: whether an emergency stop is among the faults.
    """

    sample: Sample
    state: int
    faults: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    emergency: bool = False


def angles_from_arm(degrees: ArrayLike, near: Array | None = None) -> Array:
    """Return joint angles in SI [rad].

    Args:
        degrees: as the arm says them [deg], (nv,).
        near: the angles a moment ago [rad], (nv,); the result is within half a turn of them. In the turn from
            -174 to 186 deg if None.
    """
    centre = np.full(1, FIRST_TURN) if near is None else near
    angles = np.deg2rad(np.asarray(degrees, float)) - centre
    turned: Array = angles - 2 * np.pi * np.round(angles / (2 * np.pi)) + centre
    return turned


def angles_to_arm(angles: ArrayLike) -> Array:
    """Return joint angles as the arm says them [deg], 0 to 360."""
    degrees: Array = np.mod(np.rad2deg(np.asarray(angles, float)), 360.0)
    return degrees


def velocities_from_arm(degrees: ArrayLike) -> Array:
    """Return joint velocities in SI [rad/s]."""
    velocities: Array = np.deg2rad(np.asarray(degrees, float))
    return velocities


def velocities_to_arm(velocities: ArrayLike) -> Array:
    """Return joint velocities as the arm says them [deg/s]."""
    degrees: Array = np.rad2deg(np.asarray(velocities, float))
    return degrees


def torques_from_arm(torques: ArrayLike) -> Array:
    """Return the torques of the arm on its links [N m]."""
    return TORQUE_SIGN * np.asarray(torques, float)


def torques_to_arm(torques: ArrayLike) -> Array:
    """Return torques with the sign the arm gives them [N m]."""
    return TORQUE_SIGN * np.asarray(torques, float)


def opening_from_percent(gripper: ParallelGripper, percent: float) -> float:
    """Return the distance of the pads [m] of the gripper's position, 0 open to 100 closed."""
    wide, shut = _crank_range(gripper)
    angle = wide + min(max(percent, 0.0), 100.0) / 100.0 * (shut - wide)
    return 2 * (gripper.crank_offset + gripper.crank_length * math.sin(angle))


def percent_from_opening(gripper: ParallelGripper, opening: float) -> float:
    """Return the gripper's position, 0 open to 100 closed, of a distance of the pads [m]."""
    wide, shut = _crank_range(gripper)
    return 100.0 * (gripper.crank_angle(min(max(opening, 0.0), gripper.max_opening)) - wide) / (shut - wide)


def speed_share(gripper: ParallelGripper, speed: float) -> float:
    """Return a speed [m/s] as a share of the gripper's highest, within what it can run at."""
    return min(max(speed, gripper.min_speed), gripper.max_speed) / gripper.max_speed


def speed_from_share(gripper: ParallelGripper, share: float) -> float:
    """Return the speed [m/s] of a share of the gripper's highest; it never runs slower than its lowest."""
    return 0.0 if share == 0 else max(abs(share) * gripper.max_speed, gripper.min_speed)


def reading(feedback: pb.Feedback, time: float, gripper: ParallelGripper, near: Array | None = None) -> Reading:
    """Return what a feedback says.

    Args:
        feedback: as the arm sent it.
        time: when it was received [s].
        gripper: converts percent to an opening.
        near: the joint angles a moment ago [rad], (nv,), to count turns.

    Raises:
        FrameError: if a number in it is not finite, or the number of joints changed.
    """
    joints = feedback.actuators
    if near is not None and len(joints) != len(near):
        raise FrameError(f"feedback of {len(joints)} joints; valid: {len(near)}")
    motors = feedback.interconnect.gripper_feedback.motor
    sample = Sample(
        time=time,
        q=angles_from_arm([joint.position for joint in joints], near),
        dq=velocities_from_arm([joint.velocity for joint in joints]),
        tau=torques_from_arm([joint.torque for joint in joints]),
        opening=opening_from_percent(gripper, motors[0].position) if motors else gripper.max_opening,
        effort=motors[0].current_motor if motors else 0.0,
    )
    numbers = (*sample.q, *sample.dq, *sample.tau, sample.opening, sample.effort)
    if not all(map(math.isfinite, numbers)):
        raise FrameError("feedback with numbers that are not finite")
    faults = _faults(feedback)
    return Reading(
        sample=sample,
        state=feedback.base.active_state,
        faults=faults,
        warnings=_warnings(feedback),
        emergency=bool(feedback.base.fault_bank_a & codes.EMERGENCY_BITS),
    )


def _crank_range(gripper: ParallelGripper) -> tuple[float, float]:
    return gripper.crank_angle(gripper.max_opening), gripper.crank_angle(0.0)


def _faults(feedback: pb.Feedback) -> tuple[str, ...]:
    """Return the names of the fault bits that are set."""
    base, wrist = feedback.base, feedback.interconnect
    found = [f"base {name}" for name in codes.bit_names(base.fault_bank_a, codes.BASE_FAULTS)]
    found += [f"base bank b {name}" for name in codes.bit_names(base.fault_bank_b, {})]
    for number, joint in enumerate(feedback.actuators, start=1):
        found += [f"joint {number} {name}" for name in codes.bit_names(joint.fault_bank_a, codes.ACTUATOR_FAULTS)]
        found += [f"joint {number} bank b {name}" for name in codes.bit_names(joint.fault_bank_b, {})]
    for place, part in (("wrist", wrist), ("gripper", wrist.gripper_feedback)):
        found += [
            f"{place} {name}"
            for bank in (part.fault_bank_a, part.fault_bank_b)
            for name in codes.bit_names(bank, {})
        ]
    return tuple(found)


def _warnings(feedback: pb.Feedback) -> tuple[str, ...]:
    """Return the names of the warning bits that are set."""
    found = [f"base {name}" for name in codes.bit_names(feedback.base.warning_bank_a, codes.BASE_FAULTS)]
    for number, joint in enumerate(feedback.actuators, start=1):
        names = codes.bit_names(joint.warning_bank_a, codes.ACTUATOR_FAULTS)
        found += [f"joint {number} {name}" for name in names]
    return tuple(found)
