"""Which way a hand closes on an object and how high, and what it refuses."""

import numpy as np
import pytest

from dynamics.errors import InvalidInput
from dynamics.grasping import PAD_CLEARANCE, TOP_CLEARANCE, grasp_height
from dynamics.gripper import robotiq_2f85
from dynamics.objects import DeclaredObject
from selection.actions.reach import closing_edge

GRIPPER = robotiq_2f85()


def declared(shape, size, sd=0.0005):
    return DeclaredObject("thing", shape, size, sd, (0.5, 0.0), 0.0, "thing.toml")


@pytest.mark.parametrize(
    ("shape", "size", "height"),
    [
        ("box", (0.05, 0.05, 0.02), 0.01875 + PAD_CLEARANCE),  # fingertips over the table
        ("box", (0.05, 0.05, 0.05), 0.025),  # its middle
        ("box", (0.05, 0.05, 0.12), 0.12 - 0.029 + TOP_CLEARANCE),  # under the cranks
        ("cylinder", (0.05, 0.05, 0.12), 0.12 - 0.029 + TOP_CLEARANCE),
        ("sphere", (0.06, 0.06, 0.06), 0.03),
        ("sphere", (0.08, 0.08, 0.08), 0.04),  # its top is narrow enough for the cranks
        ("sphere", (0.03, 0.03, 0.03), 0.01875 + PAD_CLEARANCE),
    ],
)
def test_height_varies_with_the_object(shape, size, height):
    assert grasp_height(GRIPPER, declared(shape, size), 1) == pytest.approx(height)


@pytest.mark.parametrize("size", [(0.04, 0.04, 0.07), (0.06, 0.06, 0.09), (0.05, 0.08, 0.1)])
def test_what_rises_above_the_pads_stays_clear_of_the_cranks(size):
    thing = declared("ellipsoid", size)
    height = grasp_height(GRIPPER, thing, 1)
    angle = GRIPPER.crank_angle(size[1])
    for share in np.linspace(0, 1, 50):  # along a crank, from the pad up to its pivot
        z = height + GRIPPER.pad_height + share * GRIPPER.crank_length * np.cos(angle)
        inner = size[1] / 2 * (1 - share)
        middle = size[2] / 2
        half = size[1] / 2 * np.sqrt(max(1 - ((z - middle) / middle) ** 2, 0))
        assert half <= inner + TOP_CLEARANCE


def test_round_object_too_tall_for_the_pads_is_refused():
    with pytest.raises(InvalidInput, match=r"thing.toml: size_m.*widest place"):
        grasp_height(GRIPPER, declared("ellipsoid", (0.06, 0.06, 0.2)), 1)


def test_closing_on_the_shorter_side_that_fits():
    assert closing_edge(GRIPPER, declared("box", (0.05, 0.06, 0.07)))[0] == 0
    assert closing_edge(GRIPPER, declared("box", (0.2, 0.06, 0.07)))[0] == 1
    edge, turns = closing_edge(GRIPPER, declared("cylinder", (0.05, 0.05, 0.07)))
    assert len(turns) == 8
    assert edge == 1
    with pytest.raises(InvalidInput, match=r"thing.toml: size_m.*opens"):
        closing_edge(GRIPPER, declared("sphere", (0.09, 0.09, 0.09)))
