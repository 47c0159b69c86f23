"""What is round is carried without turning in the hand, and lies where it was when it is set down.

What stands elsewhere all the same is pushed between the pads and told of.
"""

from dataclasses import replace

import numpy as np
import pytest

from dynamics.errors import ActionFailed
from selection.actions import Squeeze, Weigh
from selection.actions.hand import Hand
from selection.tape import Tape
from sim.bodies import object_bodies, object_pose
from sim.robot import MujocoRobot
from sim.sensors import SensorModel
from tests.sim.objects import thing

# Random objects as they were drawn. Held by points they turned between the pads all the time, by half a radian,
# and rolled 10 to 17 mm aside when they were set down; a patch 8 mm wide holds a hundred times what turns them.
LENS = thing("ellipsoid", 547215, 0.0768, (0.0651, 0.0659, 0.0365), -2.27, (0.1293, 0.424), 0.876)
FLAT = thing("ellipsoid", 32420, 0.0672, (0.0735, 0.1004, 0.0427), -2.556, (0.4301, -0.3866), 0.922)
LONG = thing("ellipsoid", 11618, 0.1482, (0.1064, 0.0586, 0.0458), 1.501, (0.5427, -0.2626), 0.906)
# These jumped from pads that pressed them onto the table, or rose with pads that opened, and fell 25 mm aside.
LIGHT = thing("cylinder", 6000, 0.006, (0.0710, 0.0710, 0.0610), 0.4, (0.42, 0.1), 0.81)
AIRY = thing("sphere", 11249, 0.0049, (0.0688,) * 3, 1.779, (0.3369, -0.0059), 0.91)
BALL = thing("sphere", 13999, 0.0408, (0.0696,) * 3, 1.307, (-0.1029, -0.4435), 0.598)


class Turning:
    """Follows how far an object has turned in the hand since it was lifted.

    Attributes:
        most: the most of it [rad].
    """

    def __init__(self, robot):
        self._data, self._nodes = robot._data, object_bodies(robot._model)
        self._tool = robot._model.site("tool_frame").id
        self._lifted = None
        self.most = 0.0
        robot.listen(self._follow)

    def _follow(self, _):
        nodes = self._data.xpos[self._nodes]
        if nodes[:, 2].min() < 0.005:
            self._lifted = None
            return
        in_hand = (nodes - nodes.mean(axis=0)) @ self._data.site_xmat[self._tool].reshape(3, 3)
        if self._lifted is None:
            self._lifted = in_hand
        u, _, vt = np.linalg.svd(self._lifted.T @ in_hand)
        self.most = max(self.most, float(np.arccos(np.clip((np.trace(u @ vt) - 1) / 2, -1, 1))))


@pytest.mark.parametrize(
    ("truth", "action"),
    [
        pytest.param(LENS, Squeeze(), id="lens-squeezed"),
        pytest.param(FLAT, Weigh(), id="flat-weighed"),
        pytest.param(AIRY, Weigh(), id="airy-weighed"),
        pytest.param(LIGHT, Squeeze(), id="light-squeezed"),
        pytest.param(LENS, Weigh(), id="lens-weighed", marks=pytest.mark.slow),
        pytest.param(LONG, Weigh(), id="long-weighed", marks=pytest.mark.slow),
        pytest.param(BALL, Weigh(), id="ball-weighed", marks=pytest.mark.slow),
        pytest.param(BALL, Squeeze(), id="ball-squeezed", marks=pytest.mark.slow),
    ],
)
def test_round_things_neither_turn_in_the_hand_nor_roll_away(truth, action):
    robot = MujocoRobot(truth, SensorModel.none())
    hand = Hand(robot, truth.declared, Tape(robot))
    home = object_pose(robot._model, robot._data)
    turning = Turning(robot)
    action.perform(hand)
    assert 0 < turning.most < 0.1  # it was in the air
    assert np.linalg.norm(object_pose(robot._model, robot._data) - home) < 0.003


@pytest.mark.parametrize("aside", [0.009, -0.009, 0.0])
def test_what_stands_aside_is_centred_and_told_of(aside):
    truth = thing("box", mass=0.2)  # 50 mm along x, which the pads close on
    robot = MujocoRobot(truth, SensorModel())
    x, y = truth.declared.position
    hand = Hand(robot, replace(truth.declared, position=(x + aside, y)), Tape(robot))
    home = object_pose(robot._model, robot._data)
    hand.gate()
    hand.grasp("weigh")
    assert object_pose(robot._model, robot._data)[0] - home[0] == pytest.approx(aside, abs=0.0015)
    assert len(hand.remarks) == bool(aside)
    assert all("did not stand where" in remark for remark in hand.remarks)


def test_what_is_wider_than_declared_is_displaced():
    truth = thing("box", 5e5, 0.5, (0.065, 0.07, 0.06))
    robot = MujocoRobot(truth, SensorModel())
    narrow = replace(truth.declared, size=(0.05, 0.06, 0.06))
    with pytest.raises(ActionFailed, match=r"^displaced: "):
        Hand(robot, narrow, Tape(robot)).grasp("weigh")
