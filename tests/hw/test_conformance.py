"""The driver with the emulator behind it passes the checks that every robot passes."""

import pytest

from hw.emulator.kinematic import Block, KinematicRobot
from tests.conformance import CHECKS, squeezes_until_the_effort_limit
from tests.hw.conftest import driving, serving


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.__name__)
def test_conformance(check, robot):
    check(robot)


def test_squeeze():
    with (
        serving(KinematicRobot(block=Block(width=0.05, stiffness=3000.0))) as emulator,
        driving(emulator) as robot,
    ):
        squeezes_until_the_effort_limit(robot, 0.05)
