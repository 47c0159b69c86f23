"""The simulation behind the emulated arm: the same promises, the same knowledge at the end of an exploration."""

import math
import re
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from dynamics.errors import MotionRefused
from hw.emulator.robot_backend import RobotBackend
from hw.kortex.errors import EmergencyStopped, GripperStuck, TrajectoryAborted
from models import objects
from selection import run
from sim.robot import MujocoRobot
from sim.sensors import SensorModel
from sim.truth import read_truth
from tests.conformance import CHECKS, MOVE, motion
from tests.hw.conftest import driving, serving

THOROUGH = ["--quiet", "--price", "0.0005", "--confidence", "0.9999"]  # weighs and squeezes


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


@pytest.mark.slow
def test_exploration_through_the_emulator_finds_what_the_simulation_finds(tmp_path, monkeypatch):
    """Two processes and real sockets; about 90 s, for the arm moves in real time."""
    monkeypatch.setenv("PALPATE_KORTEX_USER", "admin")
    monkeypatch.setenv("PALPATE_KORTEX_PASSWORD", "admin")
    command = [sys.executable, "-m", "hw.emulator", "--backend", "mujoco", "--port", "0", "--udp-port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        tcp, udp = (int(port) for port in re.findall(r":(\d+)", server.stdout.readline()))

        # The simulated cube deforms evenly over the pads' face.
        arm = ["--host", "127.0.0.1", "--port", str(tcp), "--udp-port", str(udp), "--load-spread", "face", "--yes"]
        found = {}
        try:
            for name, more in (("sim", []), ("kortex", arm)):
                assert run.main(["--robot", name, "--out", str(tmp_path / name), *THOROUGH, *more]) == 0
                found[name] = measured(tmp_path / name)
        finally:
            server.send_signal(signal.SIGTERM)
            server.wait(5)
    assert {"mass", "elasticity"} <= set(found["sim"]) & set(found["kortex"])
    print(found)
    for quantity in found["sim"]:
        one, other = found["sim"][quantity], found["kortex"][quantity]
        assert abs(one[0] - other[0]) < 3 * math.hypot(one[1], other[1]), quantity


def measured(directory):
    """Return mean and standard deviation of what a run measured, by quantity."""
    from estimation.recording import read_recording

    return {
        recorded.measurement.property: (recorded.measurement.mean, recorded.measurement.sd)
        for recorded in read_recording(directory).measurements
    }
