"""What of a squeeze is believed, held against what is known of the object."""

import dataclasses
import math

import numpy as np
import pytest

from benchmarks.squeezes import Squeeze, squeeze
from dynamics.arm import Arm
from dynamics.compression import geometry_of
from dynamics.errors import ActionFailed
from dynamics.gripper import robotiq_2f85
from estimation.size import SizeEstimate
from estimation.squeezed import METHOD_SD, WIDTH_SD, believe_squeeze

GRIPPER = robotiq_2f85("face")
MODULUS, WIDTH, SD = 5e4, 0.056, 5e-4


@pytest.fixture(scope="module")
def arm() -> Arm:
    return Arm.gen3()


@pytest.fixture(scope="module")
def phases():
    geometry = geometry_of("box", (WIDTH,) * 3, GRIPPER)
    return squeeze(Squeeze(MODULUS, geometry), GRIPPER, np.random.default_rng(0))


def believed(arm, phases, width, edge=1):
    lengths = [0.06, 0.06, 0.05]
    lengths[edge] = width
    return believe_squeeze(arm, GRIPPER, "box", SizeEstimate(tuple(lengths), (SD,) * 3, fill=1.0), edge, phases)


def by_name(found):
    return {one.property: one for one in found.measurements}


def test_what_is_as_known_is_measured(arm, phases):
    found = believed(arm, phases, WIDTH)
    assert found.notes == ()
    assert by_name(found)["width"].mean == pytest.approx(WIDTH, abs=3e-4)
    assert by_name(found)["elasticity"].mean == found.estimate.young_modulus


@pytest.mark.parametrize("edge", [0, 1])
def test_the_edge_says_which_length_the_pads_close_on(arm, phases, edge):
    assert believed(arm, phases, WIDTH, edge).estimate.geometry.width == WIDTH


def test_what_is_met_far_too_wide_is_displaced(arm, phases):
    with pytest.raises(ActionFailed, match=r"it was met 0\.05\d+ m wide, not 0\.0500") as failure:
        believed(arm, phases, 0.05)
    assert failure.value.reason == "displaced"


def test_a_little_too_wide_is_an_uncertain_size(arm, phases):
    found = believed(arm, phases, WIDTH / 1.04)  # 4 sd, and less than the 5 % of another side
    assert "width" in by_name(found)
    assert found.notes == ()


def test_what_is_met_too_narrow_keeps_its_width_to_itself(arm, phases):
    found = believed(arm, phases, WIDTH + 0.005)
    assert set(by_name(found)) == {"elasticity"}
    assert "not 0.0610" in found.notes[0]


def test_a_squeeze_by_hand_adds_what_a_bench_does_not(arm, phases):
    by_hand = [dataclasses.replace(p, name="grasp") if p.name == "close" else p for p in phases]
    bench, hand = (by_name(believed(arm, some, WIDTH)) for some in (phases, by_hand))
    own, more = (one["elasticity"].sd / one["elasticity"].mean for one in (bench, hand))
    # Less the readings of the approach, which a hand's lack.
    assert math.sqrt(more**2 - own**2) == pytest.approx(METHOD_SD, rel=0.2)
    assert bench["width"].sd < WIDTH_SD < hand["width"].sd < 1.5 * WIDTH_SD
