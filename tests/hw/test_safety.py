"""Limits on paths and readings, waypoints, the check before the first motion, and dry runs."""

import dataclasses
import math

import numpy as np
import pinocchio as pin
import pytest
from scipy.interpolate import CubicSpline

from dynamics.arm import Arm
from dynamics.errors import InvalidInput, MotionRefused
from dynamics.signals import Sample
from dynamics.trajectory import Trajectory, time_path
from hw.emulator.kinematic import HOME, KinematicRobot
from hw.kortex.errors import ArmFault, EmergencyStopped, LimitExceeded
from hw.kortex.units import Reading
from hw.preflight import torque_check
from hw.safety import FORCE_READINGS, SafetyLimits, SafetyMonitor
from hw.waypoints import waypoints
from tests.conformance import MOVE, motion
from tests.hw.conftest import driving, serving

ARM = Arm.gen3()
ARMS = {"V12": ARM, "BRAKES": Arm.gen3("BRAKES")}
REST = Sample(0.0, HOME, np.zeros(7), ARM.gravity(HOME), 0.085, 0.0)


def reading(**changes):
    return Reading(dataclasses.replace(REST, **changes), 7)


@pytest.fixture
def monitor():
    return SafetyMonitor(ARM, SafetyLimits())


@pytest.mark.parametrize(
    "wrong",
    [
        {"speed_share": 0.0},
        {"speed_share": 1.5},
        {"torque_share": math.nan},
        {"force": -1.0},
        {"force": math.inf},
        {"feedback_timeout": 0.0},
        {"position_margin": -0.1},
        {"workspace_lower": (0.0, 0.0, 2.0)},
        {"workspace_lower": (0.0, 0.0)},
    ],
)
def test_senseless_limits(wrong):
    with pytest.raises(InvalidInput, match="safety"):
        SafetyLimits(**wrong)


def test_a_healthy_reading_passes(monitor):
    monitor.check_reading(Reading(REST, 7))


def joint(index, value, base=None):
    series = np.array(np.zeros(7) if base is None else base)
    series[index] = value
    return series


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"q": joint(1, 2.3, HOME)}, "position of joint 2: 2.300; limit: 2.240 rad"),
        ({"q": joint(5, -2.2, HOME)}, "position of joint 6"),
        ({"dq": joint(0, 1.6)}, "speed of joint 1: 1.600; limit: 1.536 rad/s"),
        ({"dq": joint(6, -1.4)}, "speed of joint 7"),
        ({"tau": joint(3, 40.0)}, "torque of joint 4: 40.000; limit: 39.000 N m"),
        ({"tau": joint(4, -9.5)}, "torque of joint 5"),
    ],
)
def test_reading_outside_a_limit(monitor, changes, words):
    with pytest.raises(LimitExceeded, match=words):
        monitor.check_reading(reading(**changes))


def test_turns_of_a_continuous_joint_are_no_limit(monitor):
    q = joint(0, 20 * np.pi, HOME)
    monitor.check_reading(reading(q=q))


def test_workspace():
    monitor = SafetyMonitor(ARM, SafetyLimits(workspace_lower=(-1.0, -1.0, 0.5)))
    with pytest.raises(LimitExceeded, match="workspace"):
        monitor.check_reading(Reading(REST, 7))


def test_force_is_that_of_the_wrench_on_the_tool(monitor):
    """A known force on the tool, its torques by Pinocchio's own Jacobian: found again within the damping."""
    rng = np.random.default_rng(2)
    frame = ARM.model.getFrameId("tool_frame")
    data = ARM.model.createData()
    for _ in range(50):
        q = HOME + rng.uniform(-0.4, 0.4, 7)
        force = rng.normal(size=3)
        force *= 30 / np.linalg.norm(force)
        jacobian = pin.computeFrameJacobian(
            ARM.model, data, ARM.configuration(q), frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        )
        tau = ARM.gravity(q) - jacobian[:3].T @ force
        assert monitor.tool_force(q, np.zeros(7), tau) == pytest.approx(30, rel=0.2)


def test_force_counts_when_it_lasts():
    monitor = SafetyMonitor(ARM, SafetyLimits(force=20.0))
    push = ARM.tool_jacobian(HOME)[:3].T @ np.array([0.0, 0.0, 40.0])
    pushed = reading(tau=REST.tau + push)
    for _ in range(3):
        for _ in range(FORCE_READINGS - 1):
            monitor.check_reading(pushed)
        monitor.check_reading(Reading(REST, 7))
    for _ in range(FORCE_READINGS - 1):
        monitor.check_reading(pushed)
    with pytest.raises(LimitExceeded, match="force on the tool"):
        monitor.check_reading(pushed)


def test_faults_come_before_limits(monitor):
    with pytest.raises(EmergencyStopped):
        monitor.check_reading(Reading(REST, 4, ("base EMERGENCY_STOP_ACTIVATED",), emergency=True))
    with pytest.raises(ArmFault, match="joint 1 FOLLOWING_ERROR"):
        monitor.check_reading(Reading(REST, 7, ("joint 1 FOLLOWING_ERROR",)))
    with pytest.raises(ArmFault, match="IN_FAULT"):
        monitor.check_reading(Reading(REST, 4))


def path(delta, seconds=2.0, start=HOME):
    s = (1 - np.cos(np.linspace(0, np.pi, 200))) / 2
    return Trajectory(np.linspace(0, seconds, 200), start + s[:, None] * delta)


@pytest.mark.parametrize(
    ("trajectory", "words"),
    [
        (path(MOVE, start=HOME + 0.1), "does not start where the arm stands: joint"),
        (path(joint(1, 2.0), 20), "position of joint 2"),
        (path(joint(6, 3.0), 1.0), "speed of joint 7"),
        (path(joint(1, 1.9), 20), "tool at .* workspace"),
    ],
)
def test_paths_that_leave_a_limit(monitor, trajectory, words):
    monitor.check_path(path(MOVE), HOME)
    with pytest.raises(MotionRefused, match=words):
        monitor.check_path(trajectory, HOME)


@pytest.mark.parametrize(
    ("time", "q"),
    [
        ([0.0, 1.0], np.zeros((2, 6))),
        ([0.0, 1.0], np.full((2, 7), np.nan)),
        ([0.0], HOME[None]),
        ([0.0, 0.0], np.array([HOME, HOME])),
        ([0.0, math.inf], np.array([HOME, HOME])),
        ([0.0, 1.0, 2.0], np.array([HOME, HOME])),
    ],
)
def test_what_is_no_trajectory(monitor, time, q):
    with pytest.raises(InvalidInput, match="trajectory"):
        monitor.check_path(Trajectory(np.array(time), q), HOME)


def test_waypoints_reproduce_the_trajectory():
    trajectory = time_path(ARM, HOME + np.linspace(0, 1, 60)[:, None] * 6 * MOVE, 0.6)
    found = waypoints(trajectory, ARM.velocity_limit)
    assert len(found.q) < 30
    assert found.durations.sum() == pytest.approx(trajectory.duration)
    spline = CubicSpline(np.append(0, np.cumsum(found.durations)), np.vstack([HOME, found.q]), bc_type="clamped")
    assert np.abs(spline(trajectory.time) - trajectory.q).max() <= 0.002
    assert np.allclose(found.q[-1], trajectory.q[-1])


@pytest.mark.parametrize("direction", [MOVE, joint(6, 1.0), joint(0, 2.0), -6 * MOVE])
def test_waypoints_at_full_speed_keep_the_limit(direction):
    trajectory = time_path(ARM, HOME + np.linspace(0, 1, 60)[:, None] * direction, 1.0)
    found = waypoints(trajectory, ARM.velocity_limit)
    spline = CubicSpline(np.append(0, np.cumsum(found.durations)), np.vstack([HOME, found.q]), bc_type="clamped")
    times = np.linspace(0, found.durations.sum(), 5000)
    assert np.all(np.abs(spline(times, 1)).max(axis=0) <= ARM.velocity_limit)
    assert found.durations.sum() <= 1.021 * trajectory.duration
    assert len(found.q) < 50


def test_a_sharp_corner_is_refused():
    time = np.linspace(0, 1, 1001)
    corner = HOME + 8 * np.abs(time - 0.503)[:, None] * np.ones(7)
    with pytest.raises(MotionRefused, match="sharp corner"):
        waypoints(Trajectory(time, corner), np.full(7, np.inf))


@pytest.mark.parametrize("true", ["V12", "BRAKES"])
@pytest.mark.parametrize("assumed", ["V12", "BRAKES"])
def test_revision_by_the_torques(true, assumed):
    found = torque_check([reading(tau=ARMS[true].gravity(HOME))], ARMS, assumed)
    assert bool(found.problems) == (true != assumed)
    assert min(found.misfit, key=found.misfit.get) == true


def test_torque_that_is_off_is_named_with_its_numbers():
    found = torque_check([reading(tau=REST.tau + joint(4, 1.5))], ARMS, "V12")
    assert found.problems[0].startswith("joint 5 reads +1.50 N m, the V12 model with the empty gripper says")
    assert "tare" in found.problems[-1]


def test_wide_tolerance_tells_no_revision():
    found = torque_check([reading(tau=ARMS["BRAKES"].gravity(HOME))], ARMS, "V12", (4.0,) * 7)
    assert not found.telling
    assert not found.problems


def test_dry_run_plans_and_moves_nothing():
    with serving() as emulator, driving(emulator, confirm=None, dry_run=True) as robot:
        samples = []
        robot.listen(samples.append)
        start = robot.read().q
        for _ in range(2):
            robot.follow(motion(robot, MOVE))
        robot.grip(0.04, 0.05, 1.0)
        robot.hold(10.0)
        assert robot.read().q == pytest.approx(start + 2 * MOVE, abs=1e-6)
        assert robot.read().opening == 0.04
        with pytest.raises(MotionRefused):
            robot.follow(path(joint(1, 3.0), 20, robot.read().q))
        assert samples == []
        state = emulator.backend.state()
        assert state.sample.q == pytest.approx(HOME)
        assert state.sample.opening == pytest.approx(0.085)
        assert emulator.services.motions == 0


def test_the_arm_has_the_last_word_on_a_trajectory():
    backend = KinematicRobot()
    backend.arm.velocity_limit = backend.arm.velocity_limit / 10
    with serving(backend) as emulator, driving(emulator) as robot:
        with pytest.raises(MotionRefused, match="the arm refuses the trajectory: INVALID_JOINT_SPEED"):
            robot.follow(motion(robot, MOVE))
        assert emulator.services.motions == 0


def test_trajectory_in_another_turn_is_the_same_motion():
    with serving() as emulator, driving(emulator) as robot:
        there = motion(robot, MOVE)
        turned = Trajectory(there.time, there.q + 2 * np.pi * np.array([1, 0, -2, 0, 0, 0, 3]))
        robot.follow(turned)
        assert robot.read().q == pytest.approx(there.q[-1], abs=1e-3)


def test_a_continuous_joint_may_pass_half_a_turn():
    with serving() as emulator, driving(emulator) as robot:
        q = robot.read().q
        robot.follow(time_path(robot.arm, q + np.linspace(0, 1, 50)[:, None] * joint(2, 0.2), 1.0))
        assert robot.read().q[2] == pytest.approx(q[2] + 0.2, abs=1e-3)
        assert robot.read().q[2] > np.radians(186), "beyond the turn in which it was first read"
