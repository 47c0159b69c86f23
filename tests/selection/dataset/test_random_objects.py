"""Random objects: the same from the same numbers, within what can be held and simulated, as the prior says."""

import dataclasses
from collections import Counter

import numpy as np
import pytest

from dynamics.errors import InvalidInput
from dynamics.gripper import robotiq_2f85
from estimation.network import Network
from estimation.recording.files import to_toml
from selection.dataset.one import Setup, draw
from selection.dataset.random_objects import DRAWN_SHAPES, Ranges, Sampler, can_be_held, read_object
from sim.truth import read_truth

NETWORK = Network.from_file("soft-cubes")
SAMPLER = Sampler(NETWORK)
GRIPPER = robotiq_2f85()
DRAWN = [SAMPLER.draw(7, index) for index in range(400)]


def test_an_object_depends_on_seed_and_number_alone():
    assert Sampler(NETWORK).draw(7, 5) == DRAWN[5]
    assert SAMPLER.draw(8, 5) != DRAWN[5]
    assert len({drawn.mass for drawn in DRAWN}) > 390


def test_objects_lie_within_what_can_be_held_and_simulated():
    ranges = Ranges()
    for drawn in DRAWN:
        assert can_be_held(drawn, GRIPPER)
        assert 5e3 <= drawn.young_modulus <= 1e6 or 3e7 <= drawn.young_modulus <= 1e12
        assert ranges.mass[0] <= drawn.mass <= ranges.mass[1]
        assert ranges.friction[0] <= drawn.friction <= ranges.friction[1]
        known = drawn.declared
        assert min(known.size[:2]) + 2 * known.size_sd <= GRIPPER.max_opening - 0.004
        assert np.abs(np.subtract(drawn.size, known.size)).max() <= 2 * known.size_sd + 1e-6
        assert ranges.radius[0] - 1e-4 <= np.hypot(*known.position) <= ranges.radius[1] + 1e-4
    assert max(abs(drawn.declared.yaw) for drawn in DRAWN) > 3.0
    shapes = Counter(drawn.declared.shape for drawn in DRAWN)
    assert set(shapes) == set(DRAWN_SHAPES)
    assert min(shapes.values()) > len(DRAWN) / 10


def test_the_rule_of_holding_is_that_of_statics():
    # 2 mu F = 1.5 m g at F = 0.35 E A_pad: the heaviest that a sponge of 10 kPa and friction 0.5 may be
    heaviest = 2 * 0.5 * 0.35 * 1e4 * GRIPPER.pad_area / (1.5 * 9.81)
    box = next(drawn for drawn in DRAWN if drawn.declared.shape == "box")
    cube = dataclasses.replace(box, size=(0.06,) * 3, young_modulus=1e4, friction=0.5, mass=0.999 * heaviest)
    assert can_be_held(cube, GRIPPER)
    assert not can_be_held(dataclasses.replace(cube, mass=1.001 * heaviest), GRIPPER)
    assert not can_be_held(dataclasses.replace(cube, size=(0.03, 0.06, 0.061)), GRIPPER)


def test_materials_come_as_often_as_the_prior_says():
    # All but the gel's can be held often enough to be drawn; what is not drawn again keeps its share.
    counts = Counter(drawn.material for drawn in DRAWN)
    expected = {name: (1 - 0.05) / len(NETWORK.materials) for name in NETWORK.materials} | {"unknown": 0.05}
    passed_over = set(expected) - set(counts)
    total = 1 - sum(expected[name] for name in passed_over)
    chi_square = sum(
        (counts[name] - len(DRAWN) * p / total) ** 2 / (len(DRAWN) * p / total)
        for name, p in expected.items()
        if name not in passed_over
    )
    assert len(passed_over) <= 1
    assert chi_square < 31.3  # 11 degrees of freedom: exceeded once in a thousand


def test_an_object_file_says_all_there_is(tmp_path):
    for index, drawn in enumerate(DRAWN[:20]):
        path = tmp_path / f"{index}.toml"
        path.write_text(to_toml("object", drawn.tables("one")))
        assert read_object(path) == drawn
        truth = read_truth(path)  # and the simulator reads it
        assert (truth.mass, truth.young_modulus, truth.size) == (drawn.mass, drawn.young_modulus, drawn.size)
        assert truth.volume == pytest.approx(drawn.volume)


def test_places_are_drawn_until_the_arm_reaches_them():
    seen = []

    def reaches(declared):
        seen.append(declared.position)
        return len(seen) == 3

    assert SAMPLER.draw(1, 1, reaches).declared.position == seen[-1]
    assert len(set(seen)) == 3
    with pytest.raises(InvalidInput, match="out of reach"):
        SAMPLER.draw(1, 1, lambda declared: False)


def test_the_arm_reaches_what_is_drawn_for_it():
    first, seed = draw(Setup(seed=2), 0)
    assert draw(Setup(seed=2), 0) == (first, seed)
    assert 0 <= seed < 1 << 52


def test_materials_out_of_range_are_refused_by_name():
    steel = Network.from_file("thesis-3.1").without_unknown()
    with pytest.raises(InvalidInput, match="steel"):
        Sampler(steel, Ranges(rigid=(1e13, 1e14))).draw(0, 0)
