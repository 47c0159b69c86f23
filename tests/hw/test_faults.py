"""Everything that can go wrong on demand ends in a stopped arm, a named error, a readable recording, no hang."""

import time

import numpy as np
import pytest

from dynamics.errors import InvalidInput, UnknownName
from estimation.recording import RunWriter, read_recording
from hw.emulator.faults import Fault
from hw.emulator.kinematic import Block, KinematicRobot
from hw.kortex.errors import (
    ArmFault,
    CheckFailed,
    ConnectionLost,
    EmergencyStopped,
    FeedbackLost,
    GripperStuck,
    LimitExceeded,
    MotionTimeout,
    TrajectoryAborted,
)
from hw.safety import SafetyLimits
from tests.conformance import MOVE, motion
from tests.hw.conftest import driving, serving

LONG = 6 * MOVE  # a second
DEADLINE = 2.0  # s from the fault until the call has come back


def at_rest(emulator, within=0.5):
    """Wait for the emulated arm to stand; tell where."""
    end = time.monotonic() + within
    while emulator.backend.state().arm_moving and time.monotonic() < end:
        time.sleep(0.01)
    assert not emulator.backend.state().arm_moving
    return emulator.backend.state().sample.q


def suffer(fault, error, tmp_path, match="", backend=None, **settings):
    """Move with a fault under way; check that the arm stops, by name, on record and in time."""
    with serving(backend or KinematicRobot()) as emulator, driving(emulator, **settings) as robot:
        with RunWriter.create(tmp_path / "run", {"seed": 0}, "nothing", robot.arm.joint_names) as run:
            robot.listen(run.sample)
            trajectory = motion(robot, LONG)
            robot.hold(0.05)
            emulator.inject(fault + "@0.3")
            started = []
            robot.listen(lambda sample: started.append(time.monotonic()) if not started else None)
            with pytest.raises(error, match=match):
                robot.follow(trajectory)
            assert time.monotonic() - started[0] < 0.3 + DEADLINE + 0.1
        where = at_rest(emulator)
        if fault != "mute":
            assert np.abs(where - trajectory.q[-1]).max() > 0.05, "the arm went on to the end"
            time.sleep(0.1)
            assert np.abs(emulator.backend.state().sample.q - where).max() < 1e-6
    samples = read_recording(tmp_path / "run").samples
    assert len(samples.time) > 30
    assert np.all(np.diff(samples.time) > 0)
    return robot


@pytest.mark.parametrize(
    ("fault", "error", "match"),
    [
        ("silence", FeedbackLost, "no feedback for 0.25 s"),
        ("loss=0.99", FeedbackLost, "no feedback for 0.25 s"),
        ("fault=joint2:0x20", ArmFault, "joint 2 MAXIMUM_TORQUE"),
        ("fault=base:0x8000", ArmFault, "MINIMUM_VOLTAGE"),
        ("estop", EmergencyStopped, "EMERGENCY_STOP_ACTIVATED"),
        ("abort", TrajectoryAborted, r"CONTROL_WAYPOINT_TRAJECTORY_ABORTED \(140\)"),
        ("drop", ConnectionLost, "closed the connection"),
        ("garbage", ConnectionLost, "without the mark"),
        ("delay=5", (FeedbackLost, ConnectionLost), "no feedback"),
    ],
)
def test_fault_in_a_motion(fault, error, match, tmp_path):
    suffer(fault, error, tmp_path, match)


def test_dead_network_is_said_aloud(tmp_path):
    """Nothing reaches the arm any more: the call returns in time and says that the arm was not stopped."""
    with serving() as emulator, driving(emulator) as robot:
        trajectory = motion(robot, LONG)
        robot.hold(0.05)
        emulator.inject("mute@0.3")
        began = time.monotonic()
        with pytest.raises(ConnectionLost, match="press the emergency stop"):
            robot.follow(trajectory)
        assert time.monotonic() - began < 0.5 + 0.3 + DEADLINE + 0.1  # check, fault, deadline
        began = time.monotonic()
        with pytest.raises(FeedbackLost):
            robot.hold(0.1)
        assert time.monotonic() - began < 0.1


def test_a_failed_robot_stays_failed():
    with serving() as emulator, driving(emulator) as robot:
        robot.follow(motion(robot, MOVE))
        emulator.inject("estop")
        with pytest.raises(EmergencyStopped):
            robot.hold(1.0)
        for call in (robot.read, lambda: robot.hold(0.1), lambda: robot.grip(0.05, 0.05, 1.0)):
            with pytest.raises(EmergencyStopped):
                call()


def test_an_abort_leaves_a_robot_that_can_go_on():
    with serving() as emulator, driving(emulator) as robot:
        emulator.inject("abort@0.2")
        with pytest.raises(TrajectoryAborted):
            robot.follow(motion(robot, LONG))
        at_rest(emulator)
        robot.follow(motion(robot, MOVE))


def test_motion_without_its_end():
    """An arm that never says it is done: the motion is stopped when it is late."""
    with serving() as emulator, driving(emulator) as robot:
        emulator.services._tell = lambda *arguments: None
        trajectory = motion(robot, MOVE)
        began = time.monotonic()
        with pytest.raises(MotionTimeout):
            robot.follow(trajectory)
        assert time.monotonic() - began < 0.6 + trajectory.duration + DEADLINE


@pytest.mark.parametrize(
    ("limits", "match"),
    [
        (SafetyLimits(force=4.0), "force on the tool"),
        (SafetyLimits(torque_share=0.4), "torque of joint 2"),
    ],
)
def test_limit_exceeded_by_a_load(limits, match, tmp_path):
    """A heavy block in the fingers: torque and force leave limits that the empty arm keeps."""
    backend = KinematicRobot(block=Block(0.06, 5000.0, mass=0.6))
    with serving(backend) as emulator, driving(emulator, limits=limits) as robot:
        robot.grip(0.07, 0.1, 1.0)
        with pytest.raises(LimitExceeded, match=match):
            robot.grip(0.02, 0.05, 0.9)
        assert not emulator.backend.state().gripper_moving


@pytest.mark.parametrize("when", ["from the start", "on its way"])
def test_stuck_gripper(when, tmp_path):
    with serving() as emulator, driving(emulator) as robot:
        robot.grip(0.08, 0.1, 1.0)
        emulator.inject("stuck-gripper" if when == "from the start" else "stuck-gripper@0.3")
        time.sleep(0.05)
        with RunWriter.create(tmp_path / "run", {}, "nothing", robot.arm.joint_names) as run:
            robot.listen(run.sample)
            began = time.monotonic()
            with pytest.raises(GripperStuck, match="presses on nothing"):
                robot.grip(0.02, 0.05, 1.0)
            assert time.monotonic() - began < 0.3 + DEADLINE
        at_rest(emulator)
    samples = read_recording(tmp_path / "run").samples
    assert len(samples.time) > 30
    assert samples.opening[-1] > 0.05


def test_wrong_revision():
    with serving(KinematicRobot("BRAKES")) as emulator, driving(emulator) as robot:
        with pytest.raises(CheckFailed, match=r"fit a BRAKES arm \(0.00 N m off\) better than a V12 \(0.47"):
            robot.follow(motion(robot, MOVE))
        assert not emulator.backend.state().arm_moving
    with serving(KinematicRobot("BRAKES")) as emulator, driving(emulator, revision="BRAKES") as robot:
        robot.follow(motion(robot, MOVE))


def test_limit_that_is_already_exceeded():
    limits = SafetyLimits(torque_share=0.3)
    with serving() as emulator, driving(emulator, limits=limits) as robot:
        with pytest.raises(CheckFailed, match=r"torque of joint 2: -13.365; limit: -11.700 N m"):
            robot.grip(0.05, 0.05, 1.0)
        assert not emulator.backend.state().gripper_moving


@pytest.mark.parametrize("fault", ["estop", "fault=joint5:0x1"])
def test_fault_before_the_first_motion(fault):
    with serving() as emulator, driving(emulator) as robot:
        emulator.inject(fault)
        time.sleep(0.05)
        with pytest.raises(CheckFailed, match=r"fault: base .*arm state IN_FAULT"):
            robot.follow(motion(robot, MOVE))


def test_lost_datagrams_are_asked_for_again():
    with serving() as emulator, driving(emulator) as robot:
        emulator.inject("loss=0.05")
        samples = []
        robot.listen(samples.append)
        robot.hold(1.0)
        assert robot.statistics.repeats > 3
        times = np.array([s.time for s in samples])
        assert (times[-1] - times[0]) / (len(times) - 1) < 0.01
        robot.follow(motion(robot, MOVE))


def test_delayed_answers_are_taken():
    with serving() as emulator, driving(emulator) as robot:
        emulator.inject("delay=0.02")
        robot.follow(motion(robot, MOVE))


@pytest.mark.parametrize(
    "text", ["loss", "loss=1.5", "estop=1", "fault=elbow:1", "fault=joint2:0", "delay=x", "loss=0.1@x"]
)
def test_faults_that_make_no_sense(text):
    with pytest.raises(InvalidInput):
        Fault.parse(text)


def test_unknown_fault():
    with pytest.raises(UnknownName, match="stuck-gripper"):
        Fault.parse("earthquake")
