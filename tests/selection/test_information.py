"""Exact expected information: published figures, laws, Monte Carlo."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dynamics.errors import UnknownName
from estimation.belief import Belief
from estimation.measurement import Measurement
from estimation.network import Network, Property
from estimation.sensor import ClassSensor, Sensor
from selection.information import information_gain, split, targets


def classes(means: list[float], sds: list[float], weights: list[float] | None = None) -> Network:
    count = len(means)
    return Network(
        name="classes",
        materials=tuple(f"m{i}" for i in range(count)),
        properties=(Property("x", "material", "1", "linear", tuple(means), tuple(sds)),),
        prior=tuple(weights or [1 / count] * count),
        unknown=None,
    )


@pytest.mark.parametrize(
    ("mean", "about_class", "about_all"), [(1.0, 0.48594415, 0.80787225), (2.0, 0.91282229, 1.23475038)]
)
def test_two_classes_are_binary_signalling_over_gaussian_noise(
    mean: float, about_class: float, about_all: float
) -> None:
    found = split(Belief(classes([-mean, mean], [0.6, 0.6])), Sensor("x", 0.8))
    assert found.classes == pytest.approx(about_class, abs=1e-7)
    assert found.total == pytest.approx(about_all, abs=1e-7)


def test_identical_classes_teach_nothing_about_the_class() -> None:
    found = split(Belief(classes([3.0, 3.0], [0.6, 0.6])), Sensor("x", 0.8))
    assert found.classes == pytest.approx(0, abs=1e-9)
    assert found.total == pytest.approx(0.5 * math.log2(1 + (0.6 / 0.8) ** 2), abs=1e-9)
    assert found.total == pytest.approx(0.32192809, abs=1e-8)


def test_thesis_example_prior() -> None:
    network = Network.from_file("thesis-3.1-erratum").without_unknown()
    prior = {"ceramic": 0.7, "aluminium": 0.15, "plastic": 0.1, "steel": 0.05}
    found = split(Belief(network, prior), Sensor("density", 300.0))
    assert found.classes == pytest.approx(0.56087723, abs=1e-7)
    assert found.total == pytest.approx(1.32234690, abs=1e-7)
    uniform = Belief(network)
    assert information_gain(uniform, Sensor("density", 300.0)) == pytest.approx(1.31544786, abs=1e-7)
    assert information_gain(uniform, Sensor("elasticity", 20e9)) == pytest.approx(1.23927033, abs=1e-7)


def test_thesis_real_objects() -> None:
    network = Network.from_file("thesis-3.2").without_unknown()
    weigh, squeeze = (split(Belief(network), network.sensor(name)) for name in ("weigh", "squeeze"))
    assert (weigh.classes, weigh.total) == pytest.approx((1.55176598, 2.05173220), abs=1e-7)
    assert (squeeze.classes, squeeze.total) == pytest.approx((0.23744016, 1.45106604), abs=1e-7)


@pytest.mark.parametrize(
    ("sensor", "target", "nats"),
    [
        ("mat-vision", "material", 0.160),
        ("mat-sound", "material", 0.740),
        ("density", "material", 1.256),
        ("elasticity", "material", 0.677),
        ("cat-vision", "category", 1.071),
        ("density", "elasticity", 0.560),
        ("density", "volume", 0.105),
        ("elasticity", "density", 0.545),
        ("mat-sound", "density", 0.525),
        ("cat-vision", "material", 0.253),
    ],
)
def test_published_network(sensor: str, target: str, nats: float) -> None:
    """Among them what one property tells about another, for which the thesis has zero bits."""
    network = Network.from_file("network-8x10").without_unknown()
    gain = information_gain(Belief(network), network.sensor(sensor), target)
    assert gain * math.log(2) == pytest.approx(nats, abs=1e-3)


@pytest.mark.parametrize(("own", "nats"), [("density", 1.640), ("elasticity", 1.494)])
def test_published_network_about_the_property_itself(own: str, nats: float) -> None:
    network = Network.from_file("network-8x10").without_unknown()
    belief = Belief(network, dict.fromkeys(network.materials, 1 / 8))
    for target in (own, "everything"):
        gain = information_gain(belief, network.sensor(own), target) * math.log(2)
        assert gain == pytest.approx(nats, abs=1e-3)


positive = st.floats(0.1, 3.0)


@st.composite
def problems(draw: st.DrawFn) -> tuple[Belief, Sensor]:
    count = draw(st.integers(1, 5))
    means = draw(st.lists(st.floats(-10, 10), min_size=count, max_size=count))
    sds = draw(st.lists(positive, min_size=count, max_size=count))
    raw = draw(st.lists(st.floats(0.01, 1), min_size=count, max_size=count))
    weights = [w / sum(raw) for w in raw]
    return Belief(classes(means, sds, weights)), Sensor("x", draw(positive))


@settings(max_examples=60, deadline=None)
@given(problems())
def test_laws_of_information(problem: tuple[Belief, Sensor]) -> None:
    belief, sensor = problem
    weight = np.array(list(belief.probabilities("material").values()))
    entropy = -float(np.sum(weight * np.log2(weight)))
    found = split(belief, sensor)
    assert 0 <= found.classes <= min(entropy, found.total) + 1e-9
    prop = belief.network.properties[0]
    inside = 0.5 * np.log2(1 + (np.array(prop.sds) / sensor.sd) ** 2) @ weight
    assert found.total == pytest.approx(found.classes + inside, abs=1e-9)
    assert information_gain(belief, sensor, "x") == pytest.approx(found.total, abs=1e-5)


@settings(max_examples=30, deadline=None)
@given(problems(), st.floats(1e-6, 1e6), st.floats(-100, 100))
def test_change_of_units_changes_nothing(problem: tuple[Belief, Sensor], factor: float, offset: float) -> None:
    belief, sensor = problem
    prop = belief.network.properties[0]
    means = [factor * (mean + offset) for mean in prop.means]
    other = Belief(classes(means, [factor * sd for sd in prop.sds], list(belief.network.prior)))
    scaled = Sensor("x", factor * sensor.sd)
    assert split(other, scaled).classes == pytest.approx(split(belief, sensor).classes, abs=1e-9)
    assert split(other, scaled).total == pytest.approx(split(belief, sensor).total, abs=1e-9)


def _log_densities(z: np.ndarray, means: np.ndarray, sds: np.ndarray) -> np.ndarray:
    return -0.5 * ((z[:, None] - means) / sds) ** 2 - np.log(sds)


@pytest.mark.parametrize("seed", range(3))
def test_a_million_samples_agree(seed: int) -> None:
    rng = np.random.default_rng(seed)
    means, sds, weights = rng.uniform(0, 10, 5), rng.uniform(0.2, 2, 5), rng.dirichlet(np.ones(5))
    noise = float(np.exp(rng.uniform(np.log(0.1), np.log(3))))
    belief = Belief(classes(means.tolist(), sds.tolist(), weights.tolist()))
    k = rng.choice(5, size=1_000_000, p=weights)
    x = rng.normal(means[k], sds[k])
    z = rng.normal(x, noise)
    own = _log_densities(z, means, np.hypot(sds, noise))
    joint = np.log(np.exp(own) @ weights)
    about_class = (own[np.arange(len(z)), k] - joint) / math.log(2)
    about_all = (-0.5 * ((z - x) / noise) ** 2 - math.log(noise) - joint) / math.log(2)
    found = split(belief, Sensor("x", noise))
    for exact, samples in ((found.classes, about_class), (found.total, about_all)):
        assert exact == pytest.approx(samples.mean(), abs=4 * samples.std() / 1e3)


def test_extremes_stay_finite() -> None:
    one = Belief(classes([1.0], [0.5]))
    assert information_gain(one, Sensor("x", 1.0)) == 0
    dull = Belief(classes([0.0, 10.0], [1.0, 1.0], [1.0, 0.0]))
    assert information_gain(dull, Sensor("x", 1.0)) == pytest.approx(0, abs=1e-9)
    sharp = Belief(classes([0.0, 10.0, 20.0], [1e-3, 1.0, 300.0]))
    for noise in (1e-12, 1e-3, 1e6):
        gain = information_gain(sharp, Sensor("x", noise))
        assert 0 <= gain <= math.log2(3) + 1e-9
    rng = np.random.default_rng(0)
    means, sds = rng.uniform(0, 1e4, 4096).tolist(), rng.uniform(1, 50, 4096).tolist()
    assert 0 < information_gain(Belief(classes(means, sds)), Sensor("x", 5.0)) < 12


def test_wide_and_narrow_classes_together() -> None:
    """Where the even grid would be too long, the panels give the same as closed forms and finer grids."""
    far = Belief(classes([0.0, 1e6], [1.0, 1.0]))
    assert information_gain(far, Sensor("x", 1.0)) == pytest.approx(1.0, abs=1e-9)
    nested = Belief(classes([0.0, 0.0], [1.0, 1e4]))
    z = np.linspace(-9e4, 9e4, 600_001)
    f = np.exp(_log_densities(z, np.zeros(2), np.hypot([1.0, 1e4], 0.5))) / math.sqrt(2 * math.pi)
    mix = f.mean(axis=1)
    kl = f * np.log2(np.maximum(f, 1e-300) / np.maximum(mix, 1e-300)[:, None])
    exact = 0.5 * float(kl.sum() * (z[1] - z[0]))
    assert information_gain(nested, Sensor("x", 0.5)) == pytest.approx(exact, abs=1e-7)


def test_unknown_target_is_refused() -> None:
    with pytest.raises(UnknownName, match="colour"):
        information_gain(Belief(classes([0.0], [1.0])), Sensor("x", 1.0), "colour")
    assert targets(classes([0.0], [1.0])) == ("material", "x", "everything")


def test_classifier_gain_is_that_of_its_table() -> None:
    network = classes([0.0, 1.0], [1.0, 1.0], [0.25, 0.75])
    table = ((0.9, 0.2), (0.1, 0.8))
    sensor = ClassSensor("material", network.materials, ("a", "b"), table)
    joint = np.array(table) * [0.25, 0.75]
    exact = float(np.sum(joint * np.log2(joint / joint.sum(axis=1, keepdims=True) / [0.25, 0.75])))
    assert information_gain(Belief(network), sensor) == pytest.approx(exact, abs=1e-12)


def test_repeating_a_reading_teaches_less() -> None:
    network = Network.from_file("thesis-3.2")
    belief, weigh = Belief(network), network.sensor("weigh")
    gains = []
    for _ in range(4):
        gains.append(information_gain(belief, weigh, "everything"))
        belief = belief.update(Measurement("density", 240.0, 29.64, "kg/m^3"))
    assert gains == sorted(gains, reverse=True)
