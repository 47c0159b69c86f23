"""Whole explorations of objects drawn from the published network: speed of learning, and calibration."""

from __future__ import annotations

import numpy as np
import pytest

from estimation.belief import Belief
from estimation.network import Network
from selection.baselines import random_choice
from selection.planner import ActionModel, PlanState, StopRules, plan
from selection.virtual import VirtualObject

SECONDS = {
    "mat-vision": 1.0,
    "mat-sound": 10.0,
    "cat-vision": 1.0,
    "density": 20.0,
    "elasticity": 15.0,
    "volume": 5.0,
    "friction": 12.0,
}


def seven_actions(network: Network) -> tuple[ActionModel, ...]:
    return tuple(
        ActionModel(name, (network.sensor(name),), seconds, repeat_cap=1) for name, seconds in SECONDS.items()
    )


OBJECTS, CAP = {"exact": 1000, "random": 400}, 6


@pytest.fixture(scope="module")
def counts() -> dict[str, np.ndarray]:
    network = Network.from_file("network-8x10").without_unknown()
    actions = {action.name: action for action in seven_actions(network)}
    rules = StopRules(confidence=1.0)
    found = {name: np.zeros(count) for name, count in OBJECTS.items()}
    found["correct"] = np.zeros(OBJECTS["exact"])
    for policy in ("exact", "random"):
        for i in range(OBJECTS[policy]):
            thing = VirtualObject(network, np.random.default_rng([11, i]))
            rng = np.random.default_rng([12, i])
            belief, state = Belief(network), PlanState()
            needed = CAP
            for step in range(1, CAP + 1):
                if policy == "exact":
                    name = plan(belief, tuple(actions.values()), "material", 0.0, state, rules).choice
                else:
                    name = random_choice(tuple(actions.values()), state, rng)
                assert name is not None
                belief = thing.learn(belief, network.sensor(name))
                state = state.after(actions[name])
                if policy == "exact" and step == 3:
                    found["correct"][i] = belief.argmax("material") == thing.material
                if max(belief.probabilities("material").values()) >= 0.95:
                    needed = step
                    break
            found[policy][i] = needed
            if policy == "exact" and needed < 3:
                found["correct"][i] = belief.argmax("material") == thing.material
    return found


def test_exact_planner_needs_about_three_actions(counts: dict[str, np.ndarray]) -> None:
    assert counts["exact"].mean() <= 3.2
    assert counts["exact"].mean() == pytest.approx(3.10, abs=0.25)


def test_random_order_needs_more(counts: dict[str, np.ndarray]) -> None:
    assert counts["random"].mean() >= 4.4
    assert counts["random"].mean() - counts["exact"].mean() >= 1.0


def test_accuracy_after_three_actions(counts: dict[str, np.ndarray]) -> None:
    assert counts["correct"].mean() >= 0.88


def _calibration_error(confidence: np.ndarray, correct: np.ndarray, bins: int = 10) -> float:
    """Return the expected calibration error: mean |accuracy - confidence| over bins of equal width."""
    index = np.minimum((confidence * bins).astype(int), bins - 1)
    size = np.bincount(index, minlength=bins)
    gap = np.abs(np.bincount(index, correct - confidence, minlength=bins))
    return float(gap[size > 0].sum() / len(confidence))


@pytest.fixture(scope="module")
def explored() -> dict[str, np.ndarray]:
    """What is believed about 3000 objects after three weighings and three other random actions."""
    network = Network.from_file("network-8x10").without_unknown()
    others = [name for name in SECONDS if name != "density"]
    rows: dict[str, list[float]] = {"p": [], "right": [], "naive p": [], "naive right": [], "pit": []}
    prior = Belief(network).probabilities("material")
    for i in range(3000):
        rng = np.random.default_rng([21, i])
        thing, belief, naive = VirtualObject(network, rng), Belief(network), Belief(network)
        order = ["density"] * 3 + list(rng.choice(others, 3, replace=False))
        for turn, name in enumerate(order):
            sensor = network.sensor(name)
            belief = thing.learn(belief, sensor, turn)
            if name == "density":
                alone = thing.learn(Belief(network), sensor, turn).probabilities("material")
                naive = naive.update_class("material", {m: alone[m] / prior[m] for m in prior})
            else:
                naive = thing.learn(naive, sensor, turn)
        for key, final in (("", belief), ("naive ", naive)):
            found = final.probabilities("material")
            best = max(found, key=lambda name: found[name])
            rows[key + "p"].append(found[best])
            rows[key + "right"].append(best == thing.material)
        truth = thing.value("density")
        rows["pit"].append(float(belief.marginal("density").cdf(truth)))
    return {key: np.array(values, dtype=float) for key, values in rows.items()}


def test_probabilities_are_calibrated(explored: dict[str, np.ndarray]) -> None:
    assert _calibration_error(explored["p"], explored["right"]) < 0.02


def test_treating_repeats_as_new_objects_is_overconfident(explored: dict[str, np.ndarray]) -> None:
    """The thesis multiplies the likelihood of every repeat: its confidence runs ahead of its accuracy."""
    naive = _calibration_error(explored["naive p"], explored["naive right"])
    assert naive > 2 * _calibration_error(explored["p"], explored["right"])


def test_credible_intervals_cover(explored: dict[str, np.ndarray]) -> None:
    inside = (explored["pit"] > 0.05) & (explored["pit"] < 0.95)
    assert 0.875 <= inside.mean() <= 0.925


def test_true_values_fall_evenly_in_the_marginals(explored: dict[str, np.ndarray]) -> None:
    from scipy.stats import kstest

    assert kstest(explored["pit"], "uniform").pvalue > 0.001


@pytest.fixture(scope="module")
def novel() -> dict[str, np.ndarray]:
    """3000 objects of the thesis' materials, weighed and squeezed three times; a tenth of them of no class.

    The novel ones are drawn from the broad Gaussian that the unknown class stands for, at its prior 0.1.
    """
    network = Network.from_file("thesis-3.1-erratum").with_unknown(0.1)
    rows: dict[str, list[float]] = {"p": [], "novel": [], "right": [], "best": []}
    for i in range(3000):
        rng = np.random.default_rng([31, i])
        thing, belief = VirtualObject(network, rng), Belief(network)
        for turn, name in enumerate(["weigh", "squeeze"] * 3):
            belief = thing.learn(belief, network.sensor(name), turn)
        found = belief.probabilities("material")
        best = max(found, key=lambda key: found[key])
        rows["best"].append(found[best])
        rows["right"].append(best == thing.material)
        rows["p"].append(best == "unknown")
        rows["novel"].append(thing.material == "unknown")
    return {key: np.array(values, dtype=float) for key, values in rows.items()}


def test_unknown_objects_are_recognised_as_such(novel: dict[str, np.ndarray]) -> None:
    is_novel = novel["novel"] == 1
    assert novel["p"][is_novel].mean() >= 0.75
    assert novel["p"][~is_novel].mean() <= 0.01
    assert _calibration_error(novel["best"], novel["right"]) < 0.02
