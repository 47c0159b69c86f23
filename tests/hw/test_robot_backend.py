"""The simulation behind the emulated arm: the same promises."""

import math
import time

import numpy as np
import pytest

from dynamics.errors import MotionRefused
from hw.emulator.robot_backend import RobotBackend
from hw.kortex.errors import EmergencyStopped, GripperStuck, TrajectoryAborted
from models import objects
from sim.robot import MujocoRobot
from sim.sensors import SensorModel
from sim.truth import read_truth
from tests.conformance import CHECKS, MOVE, motion
from tests.hw.conftest import driving, serving


@pytest.fixture
def simulated():
    robot = MujocoRobot(read_truth(objects.locate("soft-cube")), SensorModel.none())
    with serving(RobotBackend(robot)) as emulator, driving(emulator) as driver:
        yield emulator, driver


def test_moves_and_grips_in_real_time(simulated):
    _, robot = simulated
    began = time.monotonic()
    trajectory = motion(robot, MOVE)
    robot.follow(trajectory)
    assert time.monotonic() - began > trajectory.duration
    assert np.abs(robot.read().q - trajectory.q[-1]).max() < 0.01
    robot.grip(0.06, 0.1, math.inf)
    assert robot.read().opening == pytest.approx(0.06, abs=0.0015)
    assert np.abs(robot.read().tau - robot.arm.gravity(robot.read().q)).max() < 0.3


def test_emergency_stop_halts_the_simulation(simulated):
    emulator, robot = simulated
    emulator.inject("estop@0.3")
    goal = motion(robot, 5 * MOVE)
    with pytest.raises(EmergencyStopped):
        robot.follow(goal)
    time.sleep(0.2)
    where = emulator.backend.state().sample.q
    time.sleep(0.2)
    assert np.abs(emulator.backend.state().sample.q - where).max() < 1e-3
    assert np.abs(where - goal.q[-1]).max() > 0.05


def test_what_the_simulation_refuses_is_an_aborted_trajectory(simulated, monkeypatch):
    emulator, robot = simulated

    def refuse(trajectory):
        raise MotionRefused("no")

    monkeypatch.setattr(emulator.backend._robot, "follow", refuse)
    with pytest.raises(TrajectoryAborted, match="CONTROL_WAYPOINT_TRAJECTORY_ABORTED"):
        robot.follow(motion(robot, MOVE))
    monkeypatch.undo()
    robot.follow(motion(robot, MOVE))


def test_stuck_gripper_of_the_simulation(simulated):
    emulator, robot = simulated
    emulator.inject("stuck-gripper@0.1")
    with pytest.raises(GripperStuck):
        robot.grip(0.03, 0.05, math.inf)


@pytest.mark.slow
@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.__name__)
def test_conformance(check, simulated):
    check(simulated[1])
