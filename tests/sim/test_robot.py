"""The simulated robot keeps the promises of the Robot protocol; its torques are those of rigid-body dynamics."""

import dataclasses
import inspect
import math

import mujoco
import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from dynamics.errors import InvalidInput, MotionRefused
from dynamics.kinematics import straight_joints
from dynamics.robot import GripResult, Robot
from dynamics.trajectory import Trajectory, time_path
from sim.robot import MujocoRobot
from sim.scene import ARM_GAINS, TIMESTEP
from sim.sensors import SensorModel
from tests.sim.objects import block

PERIOD = 0.01  # s between samples
DELTA = np.array([0.3, -0.2, 0.25, 0.3, -0.4, 0.3, 0.5])  # rad


def new(noise=None, seed=0):
    return MujocoRobot(block(), noise or SensorModel.none(), seed)


@pytest.fixture
def robot():
    return new()


def listening(robot):
    samples = []
    robot.listen(samples.append)
    return samples


def motion(robot, delta=DELTA, speed=0.6):
    q = robot.read().q
    return time_path(robot.arm, straight_joints(q, q + delta), speed)


def series(samples, name):
    return np.array([getattr(sample, name) for sample in samples])


def test_is_a_robot(robot):
    assert isinstance(robot, Robot)
    for name, promised in inspect.getmembers(Robot, inspect.isfunction):
        if not name.startswith("_"):
            given = inspect.signature(getattr(MujocoRobot, name))
            assert list(given.parameters) == list(inspect.signature(promised).parameters), name


def test_samples_come_at_100_hz_in_order_from_every_primitive(robot):
    first, second = listening(robot), listening(robot)
    ends = [robot.read().time]
    for primitive in (
        lambda: robot.hold(0.2),
        lambda: robot.follow(motion(robot)),
        lambda: robot.grip(0.06, 0.1, math.inf),
        lambda: robot.grip(0.08, 0.1, math.inf),
        robot.stop,
    ):
        primitive()
        ends.append(robot.read().time)
        assert not first or robot.read() is first[-1]
    times = series(first, "time")
    np.testing.assert_allclose(np.diff(times, prepend=ends[0]), PERIOD, atol=1e-9)
    assert [id(sample) for sample in first] == [id(sample) for sample in second]
    assert ends[1] - ends[0] == pytest.approx(0.2, abs=PERIOD / 2)
    assert all(sample.q.shape == sample.dq.shape == sample.tau.shape == (7,) for sample in first)


class Kept(MujocoRobot):
    """A robot that keeps the controls of every step."""

    def __init__(self):
        self.controls = []
        super().__init__(block())

    def _advance(self, controls):
        self.controls.append(controls)
        super()._advance(controls)


def test_steps_are_those_of_the_engine_alone():
    robot = Kept()
    robot.grip(0.05, 0.1, math.inf)
    robot.follow(motion(robot, 0.3 * DELTA))
    model, data = robot._model, mujoco.MjData(robot._model)
    data.qpos[:7] = robot.controls[0][0][:7]
    mujoco.mj_forward(model, data)
    for row in np.concatenate(robot.controls):
        data.ctrl[:] = row
        mujoco.mj_step(model, data)
    np.testing.assert_array_equal(data.qpos, robot._data.qpos)
    np.testing.assert_array_equal(data.qvel, robot._data.qvel)


def test_starts_at_rest_open_and_at_time_zero(robot):
    sample = robot.read()
    assert sample.time == 0.0
    assert sample.opening == pytest.approx(robot.gripper.max_opening, abs=1e-6)
    assert np.abs(sample.dq).max() < 1e-6
    assert robot.arm.within_limits(sample.q)


def test_torque_at_rest_is_gravity(robot):
    for delta in (DELTA, -2 * DELTA):
        robot.follow(motion(robot, delta))
        robot.hold(2.0)  # the drives swing out: 6 Hz, damped by a tenth a radian and more
        sample = robot.read()
        np.testing.assert_allclose(sample.tau, robot.arm.gravity(sample.q), atol=1e-6)


@pytest.mark.parametrize("speed", [0.3, 0.6, 1.0])
def test_torque_in_motion_is_that_of_the_links(robot, speed):
    """The torque is M a + C v + g without rotors, as a sensor behind the gear feels it.

    It is that of the simulation step before the sample, so position and velocity are taken at its start and the
    acceleration in its middle, from a spline through the samples. What it cannot see is the ripple at the rate of
    the samples: the command moves straight between points 10 ms apart, off the smooth motion by up to
    a (10 ms)^2 / 8, and the drives' stiffness k turns that into torque.
    """
    samples = listening(robot)
    robot.hold(0.1)
    trajectory = motion(robot, DELTA, speed)
    robot.follow(trajectory)
    robot.hold(0.3)
    time = series(samples, "time")
    q, dq = (CubicSpline(time, series(samples, name)) for name in ("q", "dq"))
    tau = series(samples, "tau")[5:-5]
    states = [(q(t - TIMESTEP), dq(t - TIMESTEP), dq(t - TIMESTEP / 2, 1)) for t in time[5:-5]]
    links = np.array([robot.arm.inverse_dynamics(*state, rotors=False) for state in states])
    stiffness = np.array([ARM_GAINS["large"][0]] * 4 + [ARM_GAINS["small"][0]] * 3)
    acceleration = np.abs(np.diff(trajectory.q, 2, axis=0)).max(axis=0) / np.diff(trajectory.time)[0] ** 2
    ripple = stiffness * acceleration * PERIOD**2 / 8
    assert np.all(np.abs(tau - links).max(axis=0) < ripple)
    # This would not pass with the rotors' share of the torque in it, nor without the motion's.
    motors = np.array([robot.arm.inverse_dynamics(*state) for state in states])
    still = np.array([robot.arm.gravity(state[0]) for state in states])
    for wrong in (motors, still):
        assert np.all(np.abs(tau - wrong).max(axis=0)[:4] > 2 * ripple[:4])


def test_velocity_is_that_of_the_positions(robot):
    samples = listening(robot)
    robot.follow(motion(robot))
    q, dq = series(samples, "q"), series(samples, "dq")
    change = (q[2:] - q[:-2]) / (2 * PERIOD)
    # Steps of h move the positions with the velocity of their end, half a step (so h a / 2) ahead; and central
    # differences miss a sixth of the velocities' second differences.
    ahead = TIMESTEP / 2 * np.abs(np.diff(dq, axis=0)).max(axis=0) / PERIOD
    missed = np.abs(np.diff(dq, 2, axis=0)).max(axis=0) / 6
    assert np.all(np.abs(change - dq[1:-1]).max(axis=0) < ahead + 2 * missed + 1e-9)
    assert (ahead + 2 * missed).max() < 0.01 * np.abs(dq).max()


def test_follow_ends_where_the_trajectory_ends(robot):
    trajectory = motion(robot)
    before = robot.read().time
    robot.follow(trajectory)
    assert robot.read().time - before == pytest.approx(trajectory.duration, abs=PERIOD)
    robot.hold(2.0)
    # Compensated gravity leaves no load on the drives.
    np.testing.assert_allclose(robot.read().q, trajectory.q[-1], atol=1e-6)


@pytest.mark.parametrize("noise", [SensorModel(), SensorModel.none()], ids=["noisy", "exact"])
def test_same_seed_same_samples_bit_for_bit(noise):
    def run(seed):
        robot = new(noise, seed)
        samples = listening(robot)
        robot.hold(0.1)
        robot.follow(motion(robot, 0.1 * DELTA))
        robot.grip(0.07, 0.1, math.inf)
        return [np.hstack([np.hstack(dataclasses.astuple(sample))]) for sample in samples]

    first, second, other = run(5), run(5), run(6)
    assert len(first) == len(second)
    np.testing.assert_array_equal(first, second)
    assert (noise == SensorModel.none()) == (len(first) == len(other) and np.array_equal(first, other))


def bad_trajectories(robot):
    q = robot.read().q
    time, aside, wrist, lower = np.array([0.0, 1.0]), np.array(q), np.array(q), np.array(q)
    aside[3] += 0.03
    wrist[6] += 0.1
    lower[1] = robot.arm.lower[1] - 0.01
    far = straight_joints(q, lower)
    return {
        "starts elsewhere": time_path(robot.arm, straight_joints(q + 0.1, q + 0.2)),
        "starts a little elsewhere": time_path(robot.arm, straight_joints(aside, q)),
        "leaves the limits": time_path(robot.arm, far),
        "leaves the limits in between": Trajectory(np.linspace(0, 30, 2 * len(far)), np.vstack([far, far[::-1]])),
        "is too fast": Trajectory(time * 0.05, np.array([q, wrist])),
        "is another arm's": Trajectory(time, np.zeros((2, 6))),
    }


CASES = ("starts elsewhere", "starts a little elsewhere", "leaves the limits", "leaves the limits in between")


@pytest.mark.parametrize("case", [*CASES, "is too fast", "is another arm's"])
def test_follow_refuses_and_nothing_moves(robot, case):
    robot.hold(0.5)
    before, samples = robot.read(), listening(robot)
    trajectory = bad_trajectories(robot)[case]
    with pytest.raises((MotionRefused, InvalidInput)):
        robot.follow(trajectory)
    assert samples == []
    assert robot.read() is before
    robot.hold(0.2)
    assert np.ptp(series(samples, "q"), axis=0).max() < 1e-9
    robot.follow(motion(robot, 0.05 * DELTA))  # and it still moves


def test_senseless_numbers_are_refused_and_nothing_moves(robot):
    samples = listening(robot)
    for seconds in (-0.1, math.nan, math.inf):
        with pytest.raises(InvalidInput, match="hold: seconds"):
            robot.hold(seconds)
    top = robot.gripper.max_opening
    for opening, speed, effort in (
        (-0.001, 0.05, 1.0),
        (top + 0.001, 0.05, 1.0),
        (math.nan, 0.05, 1.0),
        (0.05, 0.0, 1.0),
        (0.05, math.nan, 1.0),
        (0.05, math.inf, 1.0),
        (0.05, 0.05, 0.0),
        (0.05, 0.05, math.nan),
    ):
        with pytest.raises(InvalidInput, match="grip"):
            robot.grip(opening, speed, effort)
    assert samples == []


@pytest.mark.parametrize("noise", [SensorModel(), SensorModel.none()], ids=["noisy", "exact"])
def test_grip_reaches_in_air_within_a_quantum_and_says_so(noise):
    robot = new(noise)
    for opening in (0.07, 0.02, 0.0, 0.085):
        assert robot.grip(opening, 0.1, math.inf) is GripResult.REACHED
        robot.hold(0.2)
        quantum = max(noise.opening_quantum, 1e-6)
        assert robot.read().opening == pytest.approx(opening, abs=quantum)


def test_stop_stands_still_and_the_robot_goes_on(robot):
    robot.follow(motion(robot, 0.1 * DELTA))
    robot.stop()
    samples = listening(robot)
    robot.hold(0.5)
    assert np.ptp(series(samples, "q"), axis=0).max() < 1e-3
    robot.follow(motion(robot, -0.1 * DELTA))


def test_closed_robot_hands_on_nothing(robot):
    samples = listening(robot)
    robot.close()
    robot.close()
    robot.hold(0.05)
    assert samples == []
