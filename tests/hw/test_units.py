"""The one table of units, against published figures and by hand."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dynamics.arm import Arm
from dynamics.gripper import robotiq_2f85
from hw.kortex import messages_pb2 as pb
from hw.kortex import units
from hw.kortex.errors import FrameError

GRIPPER = robotiq_2f85()


def feedback(joints=7, **joint):
    actuators = [pb.ActuatorFeedback(**joint) for _ in range(joints)]
    return pb.Feedback(actuators=actuators, base=pb.BaseFeedback(active_state=7))


def test_torque_sign_on_a_published_reading():
    # rammp: joint 4 of an arm at rest read -12.127 N m where its model says +12.168
    found = units.reading(feedback(torque=-12.127), 0.0, GRIPPER).sample.tau[3]
    assert found == pytest.approx(12.127, abs=1e-5)
    assert abs(found - 12.168) < 0.1


def test_torque_at_kinovas_home_has_the_sign_of_the_model():
    # A raised forearm pulls joint 2 forward: the arm holds against it, and the sensor reads the reaction.
    gravity = Arm.gen3().gravity(np.radians([0, 15, 180, -130, 0, 55, 90]))
    assert units.torques_to_arm(gravity)[1] > 0 > gravity[1]


@pytest.mark.parametrize(
    ("degrees", "radians"),
    [(0.0, 0.0), (90.0, math.pi / 2), (180.0, math.pi), (230.0, math.radians(-130)), (359.0, math.radians(-1))],
)
def test_first_turn(degrees, radians):
    assert units.angles_from_arm([degrees])[0] == pytest.approx(radians, abs=1e-9)


@given(st.floats(-50, 50), st.floats(-3, 3))
def test_turns_are_counted(angle, step):
    now = units.angles_from_arm(units.angles_to_arm([angle + step]), np.array([angle]))
    assert now[0] == pytest.approx(angle + step, abs=1e-9)


@given(st.floats(-10, 10))
def test_angles_to_arm_are_within_its_circle(angle):
    degrees = units.angles_to_arm([angle])[0]
    assert 0 <= degrees <= 360
    assert math.cos(math.radians(degrees) - angle) == pytest.approx(1.0, abs=1e-12)


def test_velocity():
    assert units.reading(feedback(velocity=180.0), 0.0, GRIPPER).sample.dq == pytest.approx(np.full(7, math.pi))
    assert units.velocities_to_arm([math.pi]) == pytest.approx([180.0])


def test_opening_at_the_ends_and_between():
    assert units.opening_from_percent(GRIPPER, 0.0) == pytest.approx(0.085)
    assert units.opening_from_percent(GRIPPER, 100.0) == pytest.approx(0.0, abs=1e-12)
    # the cranks' swing, half way: 2 (5.5 + 57.5 sin 17.28 deg) mm
    assert units.opening_from_percent(GRIPPER, 50.0) == pytest.approx(0.0452, abs=5e-5)


@given(st.floats(0, 0.085))
def test_opening_round_trip(opening):
    percent = units.percent_from_opening(GRIPPER, opening)
    assert units.opening_from_percent(GRIPPER, percent) == pytest.approx(opening, abs=1e-12)


def test_speeds():
    assert units.speed_share(GRIPPER, 0.075) == pytest.approx(0.5)
    assert units.speed_share(GRIPPER, 1.0) == 1.0
    assert units.speed_from_share(GRIPPER, -0.5) == pytest.approx(0.075)
    assert units.speed_from_share(GRIPPER, 0.01) == GRIPPER.min_speed
    assert units.speed_from_share(GRIPPER, 0.0) == 0.0


def test_faults_are_named_with_their_place():
    message = feedback()
    message.base.fault_bank_a = 0x800010
    message.actuators[1].fault_bank_a = 0x20
    message.actuators[4].warning_bank_a = 0x20000
    message.interconnect.gripper_feedback.fault_bank_a = 0x2
    found = units.reading(message, 0.0, GRIPPER)
    assert found.faults == (
        "base JOINT_FAULT",
        "base EMERGENCY_STOP_ACTIVATED",
        "joint 2 MAXIMUM_TORQUE",
        "gripper 0x2",
    )
    assert found.emergency
    assert found.warnings == ("joint 5 MAXIMUM_MOTOR_TEMPERATURE",)


@pytest.mark.parametrize("wrong", [math.nan, math.inf])
def test_numbers_that_are_none(wrong):
    with pytest.raises(FrameError, match="not finite"):
        units.reading(feedback(torque=wrong), 0.0, GRIPPER)


def test_another_number_of_joints():
    with pytest.raises(FrameError, match="6 joints; valid: 7"):
        units.reading(feedback(6), 0.0, GRIPPER, np.zeros(7))
