"""What the simulated gripper is said to give way by is what a rigid cylinder between its pads shows."""

import pytest

from sim.rigid_block import squeeze_rigid_block
from sim.robot import MujocoRobot
from sim.sensors import SensorModel
from tests.sim.objects import block


def test_described_stiffness_is_the_simulated_one():
    gripper = MujocoRobot(block(1e5, 0.1), SensorModel.none()).gripper
    for width in (0.05, 0.056):
        stiffness, sd = squeeze_rigid_block(width)
        assert stiffness == pytest.approx(gripper.stiffness, abs=3 * gripper.stiffness_sd + 3 * sd)
    # A cube of 1 MPa has 5.6e4 N/m, so this is half a per cent of it.
    assert 0.004 < 5.6e4 / gripper.stiffness < 0.006
