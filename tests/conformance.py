"""What every robot must do: checks for anything that claims to be a `Robot`, simulated or real.

A test file gives a fresh robot, at rest and with an open, empty gripper, and runs each of CHECKS on it:

    @pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.__name__)
    def test_conformance(check): check(robot)
"""

import math

import numpy as np
import pytest

from dynamics.errors import InvalidInput, MotionRefused
from dynamics.robot import GripResult, Robot
from dynamics.trajectory import Trajectory, time_path

MOVE = np.array([0.04, -0.04, 0.04, 0.05, -0.15, 0.15, 0.25])  # rad; quick where the joints are
ARRIVAL = 0.03  # rad; servos that give way under gravity may stay that far off
TORQUE = 4.0  # N m of offsets, noise and friction that a torque reading at rest may carry
STEP = 0.011  # s; 100 Hz and a tenth for the clock
OPENING = 0.0015  # m


def motion(robot, delta, speed=1.0):
    """Return a straight trajectory from where the robot stands."""
    start = robot.read().q
    return time_path(robot.arm, start + np.linspace(0, 1, 41)[:, None] * delta, speed)


def recorded(robot):
    """Return a list that fills with every further sample."""
    samples = []
    robot.listen(samples.append)
    return samples


def assert_steady(samples, seconds):
    """Samples come in order, at 100 Hz on average, for as long as the primitive took."""
    times = np.array([s.time for s in samples])
    assert np.all(np.diff(times) > 0)
    assert times[-1] - times[0] == pytest.approx(seconds, abs=0.15 * seconds + 0.1)
    assert (times[-1] - times[0]) / (len(times) - 1) <= STEP


def is_a_robot(robot):
    assert isinstance(robot, Robot)
    assert robot.arm.nv == 7
    assert robot.gripper.max_opening == pytest.approx(0.085)


def reads_finite_numbers_of_the_right_shape(robot):
    sample = robot.read()
    for series in (sample.q, sample.dq, sample.tau):
        assert series.shape == (robot.arm.nv,)
        assert np.all(np.isfinite(series))
    assert sample.opening == pytest.approx(robot.gripper.max_opening, abs=OPENING)
    assert abs(sample.effort) < 0.2
    assert math.isfinite(sample.time)


def torque_at_rest_is_gravity_with_its_sign(robot):
    samples = recorded(robot)
    robot.hold(0.2)
    tau = np.mean([s.tau for s in samples], axis=0)
    gravity = robot.arm.gravity(samples[-1].q)
    assert np.abs(gravity).max() > 2 * TORQUE / 2, "the pose tells nothing"
    assert np.abs(tau - gravity).max() < TORQUE
    assert tau @ gravity > 0


def hold_stands_still_and_samples(robot):
    samples = recorded(robot)
    robot.hold(0.3)
    assert_steady(samples, 0.3)
    q = np.array([s.q for s in samples])
    assert np.ptp(q, axis=0).max() < 0.01
    robot.hold(0.0)


def newest_sample_is_the_last_one_handed_on_or_later(robot):
    samples = recorded(robot)
    robot.hold(0.1)
    assert robot.read().time >= samples[-1].time


def follow_ends_where_the_trajectory_ends(robot):
    trajectory = motion(robot, MOVE)
    samples = recorded(robot)
    robot.follow(trajectory)
    assert_steady(samples, trajectory.duration)
    assert np.abs(robot.read().q - trajectory.q[-1]).max() < ARRIVAL
    robot.hold(0.2)
    assert np.abs(samples[-1].dq).max() < 0.05


def follow_stays_on_its_path(robot):
    trajectory = motion(robot, MOVE)
    start = robot.read().q
    samples = recorded(robot)
    robot.follow(trajectory)
    direction = MOVE / np.linalg.norm(MOVE)
    for sample in samples:
        way = sample.q - start
        assert np.linalg.norm(way - (way @ direction) * direction) < 2 * ARRIVAL
    assert np.linalg.norm(samples[0].q - start) < 2 * ARRIVAL


def follow_reports_the_speed_it_moves_at(robot):
    trajectory = motion(robot, MOVE)
    samples = recorded(robot)
    robot.follow(trajectory)
    times = np.array([s.time for s in samples])
    q, dq = np.array([s.q for s in samples]), np.array([s.dq for s in samples])
    travelled = np.sum((dq[1:] + dq[:-1]) / 2 * np.diff(times)[:, None], axis=0)
    assert np.abs(travelled - (q[-1] - q[0])).max() < 0.02


def two_motions_after_each_other(robot):
    before = robot.read().q
    robot.follow(motion(robot, MOVE))
    robot.follow(motion(robot, -MOVE))
    assert np.abs(robot.read().q - before).max() < 2 * ARRIVAL


def a_motion_of_no_length_is_a_pause(robot):
    q = robot.read().q
    robot.follow(Trajectory(np.array([0.0, 0.1]), np.array([q, q])))
    assert np.abs(robot.read().q - q).max() < ARRIVAL


def follow_refuses_to_start_elsewhere(robot):
    q = robot.read().q
    path = q + 0.1 + np.linspace(0, 1, 11)[:, None] * MOVE
    with pytest.raises(MotionRefused):
        robot.follow(time_path(robot.arm, path, 0.5))
    assert np.abs(robot.read().q - q).max() < 0.01


def follow_refuses_to_leave_the_joint_limits(robot):
    q = robot.read().q
    beyond = np.array(q)
    beyond[1] = robot.arm.upper[1] + 0.2
    with pytest.raises(MotionRefused):
        robot.follow(time_path(robot.arm, np.linspace(q, beyond, 50), 0.3))
    assert np.abs(robot.read().q - q).max() < 0.01


def follow_refuses_what_is_no_trajectory_of_the_arm(robot):
    time = np.array([0.0, 1.0])
    q = robot.read().q
    for wrong in (np.zeros((2, 6)), np.array([q, np.full(7, np.nan)]), np.zeros(7)):
        with pytest.raises((InvalidInput, MotionRefused)):
            robot.follow(Trajectory(time, wrong))


def grip_reaches_an_opening_in_air(robot):
    for opening in (0.07, 0.08):
        assert robot.grip(opening, 0.05, math.inf) is GripResult.REACHED
        assert robot.read().opening == pytest.approx(opening, abs=OPENING)


def grip_samples_while_it_moves(robot):
    samples = recorded(robot)
    robot.grip(0.072, 0.05, math.inf)
    times = np.array([s.time for s in samples])
    assert np.all(np.diff(times) > 0)
    assert (times[-1] - times[0]) / (len(times) - 1) <= STEP
    openings = np.array([s.opening for s in samples])
    assert np.all(np.diff(openings) < robot.gripper.opening_quantum * 1.5)
    assert openings[0] > openings[-1]


def grip_runs_slower_when_asked_to(robot):
    def seconds(speed):
        samples = recorded(robot)
        robot.grip(0.07, speed, math.inf)
        moving = [s.time for s in samples if 0.072 < s.opening < 0.08]
        robot.grip(0.085, 0.15, math.inf)
        return moving[-1] - moving[0]

    assert seconds(0.02) > 1.5 * seconds(0.08)


def grip_refuses_senseless_numbers(robot):
    top = robot.gripper.max_opening
    for opening, speed, effort in (
        (-0.01, 0.05, 1.0),
        (top + 0.01, 0.05, 1.0),
        (math.nan, 0.05, 1.0),
        (0.05, 0.0, 1.0),
        (0.05, math.nan, 1.0),
        (0.05, 0.05, 0.0),
    ):
        with pytest.raises(InvalidInput):
            robot.grip(opening, speed, effort)
    assert robot.read().opening == pytest.approx(top, abs=OPENING)


def stop_at_rest_does_no_harm(robot):
    q = robot.read().q
    robot.stop()
    robot.hold(0.1)
    assert np.abs(robot.read().q - q).max() < 0.01
    robot.follow(motion(robot, MOVE))


def a_listener_that_fails_stops_the_motion(robot):
    class Full(Exception):
        pass

    trajectory = motion(robot, 3 * MOVE)
    start, seen = robot.read(), []

    def sink(sample):
        seen.append(sample)
        if sample.time > start.time + 0.4 * trajectory.duration:
            raise Full

    robot.listen(sink)
    with pytest.raises(Full):
        robot.follow(trajectory)
    assert np.abs(robot.read().q - trajectory.q[-1]).max() > 0.02


def every_listener_gets_every_sample(robot):
    first, second = recorded(robot), recorded(robot)
    robot.hold(0.1)
    assert len(first) > 5
    assert [s.time for s in first] == [s.time for s in second]


def close_can_be_called_again(robot):
    robot.close()
    robot.close()


CHECKS = (
    is_a_robot,
    reads_finite_numbers_of_the_right_shape,
    torque_at_rest_is_gravity_with_its_sign,
    hold_stands_still_and_samples,
    newest_sample_is_the_last_one_handed_on_or_later,
    follow_ends_where_the_trajectory_ends,
    follow_stays_on_its_path,
    follow_reports_the_speed_it_moves_at,
    two_motions_after_each_other,
    a_motion_of_no_length_is_a_pause,
    follow_refuses_to_start_elsewhere,
    follow_refuses_to_leave_the_joint_limits,
    follow_refuses_what_is_no_trajectory_of_the_arm,
    grip_reaches_an_opening_in_air,
    grip_samples_while_it_moves,
    grip_runs_slower_when_asked_to,
    grip_refuses_senseless_numbers,
    stop_at_rest_does_no_harm,
    a_listener_that_fails_stops_the_motion,
    every_listener_gets_every_sample,
    close_can_be_called_again,
)


def squeezes_until_the_effort_limit(robot, width):
    """With an elastic object of a width between the fingers: closes on it, stops at the limit, keeps the grip."""
    samples = recorded(robot)
    limit = 0.4
    assert robot.grip(0.0, 0.02, limit) is GripResult.STALLED
    reached = max(s.effort for s in samples)
    assert limit <= reached < limit + 0.45
    assert 0 < robot.read().opening < width
    before = [s.effort for s in samples if s.opening > width + 0.002]
    assert max(before, default=0.0) < 0.1
    opening = robot.read().opening
    robot.hold(0.3)
    assert robot.read().opening == pytest.approx(opening, abs=0.002)
    assert robot.read().effort < 0.2, "a gripper that stands locks itself"
