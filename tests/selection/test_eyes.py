"""Classifiers of the object's class: drawn by the confusion matrix, or told by a file that may be wrong."""

import json

import numpy as np
import pytest

from dynamics.errors import PalpateError
from estimation.belief import Belief
from estimation.network import Network
from estimation.observation import Observation
from selection.eyes import Told, chosen_senses, drawn, drawn_senses, read_vision

NETWORK = Network.from_file("household")
SENSOR = NETWORK.sensor("observe")


@pytest.mark.parametrize("truth", ["mug", "of no listed class"])
def test_outcomes_follow_the_confusion_matrix(truth):
    said = [drawn(SENSOR, truth, (seed, 5)).perceive().best for seed in range(2000)]
    column = SENSOR.matrix[:, 0] if truth == "mug" else SENSOR.matrix.mean(axis=1)
    for outcome, p in zip(SENSOR.outcomes, column, strict=True):
        assert said.count(outcome) / 2000 == pytest.approx(p, abs=4.5 * np.sqrt(p * (1 - p) / 2000))


def test_every_look_at_one_object_errs_alike():
    eyes = drawn_senses(NETWORK, {"category": "mug", "material": "glass"}, seed=3)
    assert set(eyes) == {"observe", "sound"}
    assert eyes["observe"].perceive() == eyes["observe"].perceive()
    assert eyes["observe"].perceive().likelihoods == tuple(
        SENSOR.likelihoods(eyes["observe"].perceive().best).items()
    )


def test_no_camera_no_looking():
    own = drawn_senses(NETWORK, {}, 0)
    told = Told(Observation.of("category", {"mug": 1.0}))
    assert set(chosen_senses(own, None, "default", True)) == {"observe", "sound"}
    assert set(chosen_senses(own, None, "none", True)) == {"sound"}
    assert set(chosen_senses(own, None, "default", False)) == {"sound"}
    assert chosen_senses(own, told, "seen.json", False)["observe"] is told


def written(tmp_path, content):
    path = tmp_path / "seen.json"
    path.write_text(content if isinstance(content, str) else json.dumps(content), encoding="utf-8")
    return path


def seen(**content):
    return {"format": "palpate-vision/1", **content}


def test_soft_outputs_go_through_the_confusion_matrix(tmp_path):
    output = {"mug": 0.6, "bowl": 0.4}
    eyes = read_vision(written(tmp_path, seen(variable="category", output=output)), NETWORK)
    expected = 0.6 * SENSOR.matrix[0] + 0.4 * SENSOR.matrix[1]
    assert list(eyes.perceive().by_class.values()) == pytest.approx(list(expected))
    after = Belief(NETWORK).update_class("category", eyes.perceive().by_class)
    assert after.argmax("category") == "mug"
    assert after.probabilities("material")["ceramic"] > 2 * Belief(NETWORK).probabilities("material")["ceramic"]


def test_likelihoods_are_taken_as_they_are(tmp_path):
    table = {name: 2.0 if name == "can" else 0.5 for name in NETWORK.categories}
    eyes = read_vision(written(tmp_path, seen(likelihoods=table)), NETWORK)
    assert eyes.perceive().by_class == table


LIKELY = dict.fromkeys(NETWORK.categories, 1.0)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("", "seen.json"),
        ("[1, 2", "seen.json"),
        ("[" * 100_000, "seen.json"),
        ("[]", "an object"),
        (" " * (1 << 21), "1048576 bytes"),
        ({}, "format"),
        ({"format": "palpate-vision/2", "likelihoods": LIKELY}, "palpate-vision/2"),
        (seen(likelihoods=LIKELY, colour=1), "colour"),
        (seen(likelihoods=LIKELY, variable="material"), "variable"),
        (seen(likelihoods=LIKELY, output={"mug": 1.0}), "either output or likelihoods"),
        (seen(), "neither"),
        (seen(likelihoods=LIKELY | {"spoon": 1.0}), "spoon"),
        (seen(likelihoods={"mug": 1.0}), "a likelihood for bowl"),
        (seen(likelihoods=LIKELY | {"mug": -1.0}), "likelihoods: mug"),
        (seen(likelihoods=LIKELY | {"mug": "high"}), "high"),
        (seen(likelihoods=LIKELY | {"mug": True}), "True"),
        (seen(likelihoods=LIKELY | {"mug": float("nan")}), "nan"),
        (seen(likelihoods=LIKELY | {"mug": float("inf")}), "inf"),
        (seen(likelihoods=dict.fromkeys(LIKELY, 0.0)), "zeros only"),
        (seen(likelihoods=[1.0] * 10), "likelihoods"),
        (seen(output={"mug": 0.7}), "sum"),
        (seen(output={"mug": 0.7, "spoon": 0.3}), "spoon"),
        (seen(output={"mug": 1.5, "bowl": -0.5}), "output: bowl"),
    ],
)
def test_what_is_wrong_in_a_file_is_named_on_one_line(tmp_path, content, said):
    with pytest.raises(PalpateError) as error:
        read_vision(written(tmp_path, content), NETWORK)
    assert said in str(error.value)
    assert "seen.json" in str(error.value)
    assert "\n" not in str(error.value)
    assert len(str(error.value)) < 600


def test_a_reference_without_a_classifier_is_refused(tmp_path):
    with pytest.raises(PalpateError, match="observe"):
        read_vision(written(tmp_path, seen(likelihoods=LIKELY)), Network.from_file("soft-cubes"))
    with pytest.raises(PalpateError, match="missing"):
        read_vision(tmp_path / "missing.json", NETWORK)


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ((("mug", -1.0),), "mug"),
        ((("mug", 0.0),), "one class"),
        ((("mug", 1.0), ("mug", 1.0)), "once"),
        ((), "one"),
    ],
)
def test_observations_that_make_no_sense_are_refused(table, said):
    with pytest.raises(PalpateError, match=said):
        Observation("category", table)
