"""The gripper over a line that loses commands, and a gripper that falls short of them."""

import math
import socket

import numpy as np
import pytest

from dynamics.robot import GripResult
from hw.emulator.kinematic import Block, KinematicRobot
from hw.kortex import client
from tests.conformance import recorded
from tests.hw.conftest import driving, serving


class Forgetful(KinematicRobot):
    """Ignores every second command to the gripper, beginning with the first."""

    commands = 0

    def start_grip(self, opening, speed):
        self.commands += 1
        if self.commands % 2 == 0:
            super().start_grip(opening, speed)


class Short(KinematicRobot):
    """Settles a little short of where it was sent: 0.9869 where 0.99 was asked for."""

    def start_grip(self, opening, speed):
        super().start_grip(opening + 0.0003, speed)


@pytest.mark.parametrize("kind", [Forgetful, Short])
@pytest.mark.parametrize("opening", [0.075, 0.06])
def test_commands_are_sent_again_until_the_opening_is_reached(kind, opening):
    with serving(kind()) as emulator, driving(emulator) as robot:
        assert robot.grip(opening, 0.1, math.inf) is GripResult.REACHED
        assert robot.read().opening == pytest.approx(opening, abs=0.001)


@pytest.mark.parametrize("speed", [0.02, 0.05, 0.15])
def test_openings_are_met_at_every_speed(speed):
    with serving(command_period=0.025) as emulator, driving(emulator) as robot:
        for opening in (0.078, 0.0765, 0.085):
            assert robot.grip(opening, speed, math.inf) is GripResult.REACHED
            assert robot.read().opening == pytest.approx(opening, abs=0.001)


def test_a_squeeze_runs_at_its_speed_to_the_end():
    """No faster bit at the end, which would shake a viscous object: every step of the opening takes its time."""
    with serving(KinematicRobot(block=Block(0.08, 2000.0)), command_period=0.025) as emulator:
        with driving(emulator) as robot:
            samples = recorded(robot)
            robot.grip(0.075, 0.02, 0.9)
        times = np.array([s.time for s in samples])
        openings = np.array([s.opening for s in samples])
        moved, passed = openings[:-4] - openings[4:], times[4:] - times[:-4]
        assert np.all(moved <= 0.02 * (passed + 0.005) + 1.1 * robot.gripper.opening_quantum)


def test_a_closed_gripper_that_is_told_to_close_is_there():
    with serving() as emulator, driving(emulator) as robot:
        for _ in range(2):
            assert robot.grip(0.0, 0.15, math.inf) is GripResult.REACHED
        assert robot.read().opening == pytest.approx(0.0, abs=0.001)


def test_stall_at_the_grippers_own_limit():
    with serving(KinematicRobot(block=Block(0.08, 20000.0))) as emulator, driving(emulator) as robot:
        samples = recorded(robot)
        assert robot.grip(0.02, 0.1, math.inf) is GripResult.STALLED
        assert max(s.effort for s in samples) == pytest.approx(1.0, abs=0.011)
        assert robot.read().opening == pytest.approx(0.08 - 60.5 / 20000, abs=0.0005)
        assert robot.grip(0.085, 0.1, math.inf) is GripResult.REACHED


def test_random_datagrams_do_the_emulator_no_harm(emulator):
    rng = np.random.default_rng(4)
    with driving(emulator) as robot, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as vandal:
        for _ in range(2000):
            vandal.sendto(rng.bytes(int(rng.integers(0, 200))), ("127.0.0.1", emulator.udp_port))
        robot.hold(0.2)
        assert client.arm_state(robot._tcp) == 7
