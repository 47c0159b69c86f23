"""What friction cannot hold is not squeezed: on the table it would read half as stiff as it is."""

import dataclasses
from types import SimpleNamespace

import pytest

from dynamics.errors import ActionFailed
from dynamics.gripper import robotiq_2f85
from models import objects
from selection.actions import Squeeze
from selection.actions.hand import Hand
from selection.actions.squeeze import _check_grip
from selection.tape import Tape
from sim.robot import MujocoRobot
from sim.sensors import SensorModel
from sim.truth import read_truth

CUBE = read_truth(objects.locate("soft-cube"))


@pytest.mark.parametrize(
    ("fidelity", "mass"),
    [
        ("uniform", 1.0),
        pytest.param("uniform", 0.8, marks=pytest.mark.slow),  # held, but it sags onto the table
        pytest.param("indentation", 1.0, marks=pytest.mark.slow),
    ],
)
def test_a_kilogram_of_sponge_is_refused_by_name(fidelity, mass):
    # 5 kPa bears 5.5 N at the strain of a grasp: 9 N by friction of 0.8, and the cube weighs 9.8 N.
    sponge = dataclasses.replace(CUBE, young_modulus=5e3, mass=mass)
    robot = MujocoRobot(sponge, SensorModel.none(), fidelity=fidelity)
    tape = Tape(robot)
    with pytest.raises(ActionFailed) as failed:
        Squeeze().perform(Hand(robot, sponge.declared, tape))
    # How much of it the arm feels at first depends on how it sags; squeezed harder, it carries more of it.
    # In two cells it bulges by its own weight, up to the pads that come down around it.
    assert failed.value.reason in ("too heavy", "slipped", *(("displaced",) if fidelity == "indentation" else ()))


def test_a_force_that_cannot_be_counted_on_to_hold_is_refused():
    hand = SimpleNamespace(robot=SimpleNamespace(gripper=robotiq_2f85()))
    closing = [SimpleNamespace(effort=0.1)] * 5  # 6.5 N
    _check_grip(hand, closing, weight=5.0)
    with pytest.raises(ActionFailed, match=r"press with 6.5 N .* hold the 5.5 N"):
        _check_grip(hand, closing, weight=5.5)
