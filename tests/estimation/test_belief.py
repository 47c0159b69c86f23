"""The belief: the thesis' worked example, laws of conditioning, extremes, storage, refusals."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dynamics.errors import InvalidInput, UnknownName
from estimation.belief import OUTLIER, Belief
from estimation.measurement import Measurement
from estimation.network import Network, Property, Unknown
from estimation.novelty import with_class

PRIOR = {"ceramic": 0.7, "aluminium": 0.15, "plastic": 0.1, "steel": 0.05}
READING = Measurement("density", 3150.0, 300.0, "kg/m^3")


def simple(count: int, unknown: Unknown | None = None, sd: float = 1.0) -> Network:
    means = tuple(10.0 * i for i in range(count))
    return Network(
        name="simple",
        materials=tuple(f"m{i}" for i in range(count)),
        properties=(Property("x", "material", "1", "linear", means, (sd,) * count),),
        prior=(1 / count,) * count,
        unknown=unknown,
    )


def test_equation_3_23() -> None:
    network = Network.from_file("thesis-3.1-erratum").without_unknown()
    found = Belief(network, PRIOR).update(READING).probabilities("material")
    assert found["ceramic"] == pytest.approx(0.68482, abs=1e-5)
    assert found["aluminium"] == pytest.approx(0.31517, abs=1e-5)


def test_likelihoods_of_equation_3_22() -> None:
    network = Network.from_file("thesis-3.1-erratum").without_unknown()
    prop = network.property("density")
    for name, exact in (("ceramic", 2.36446e-4), ("aluminium", 5.07817e-4), ("plastic", 2.48763e-8)):
        i = network.materials.index(name)
        variance = prop.sds[i] ** 2 + 300.0**2
        direct = math.exp(-0.5 * (3150.0 - prop.means[i]) ** 2 / variance) / math.sqrt(2 * math.pi * variance)
        assert direct == pytest.approx(exact, rel=1e-5)
    # the belief's likelihood ratios are those: posterior odds over prior odds
    found = Belief(network, PRIOR).update(READING).probabilities("material")
    ratio = found["ceramic"] / found["aluminium"] * PRIOR["aluminium"] / PRIOR["ceramic"]
    assert ratio == pytest.approx(2.36446e-4 / 5.07817e-4, rel=1e-5)


def test_table_3_3_multiplies_one_likelihood() -> None:
    """The thesis' ten steps treat the same reading as ten new objects; the printed column is truncated."""
    network = Network.from_file("thesis-3.1-erratum").without_unknown()
    once = Belief(network, PRIOR).update(READING).probabilities("material")
    likelihood = {name: once[name] / PRIOR[name] for name in once}
    belief, column = Belief(network, PRIOR), []
    for _ in range(10):
        belief = belief.update_class("material", likelihood)
        column.append(belief.probabilities("material")["ceramic"])
    exact = {1: 0.68482, 2: 0.50291, 3: 0.32022, 4: 0.17988, 5: 0.09266, 10: 0.00223}
    printed = {1: 0.684, 2: 0.502, 3: 0.320, 4: 0.180, 5: 0.092, 10: 0.002}
    for step in exact:
        assert column[step - 1] == pytest.approx(exact[step], abs=1e-5)
        assert column[step - 1] == pytest.approx(printed[step], abs=1e-3)


def test_the_table_as_printed_does_not_give_the_example() -> None:
    network = Network.from_file("thesis-3.1").without_unknown()
    found = Belief(network, PRIOR).update(READING).probabilities("material")
    assert found["ceramic"] == pytest.approx(0.195, abs=1e-3)


def test_repeats_share_the_true_value() -> None:
    """After many readings the class probabilities settle at those of the true value known exactly."""
    network = simple(2, sd=4.0)
    belief = Belief(network)
    for _ in range(1000):
        belief = belief.update(Measurement("x", 4.0, 2.0, "1"))
    odds = math.exp(-0.5 * (4.0 / 4.0) ** 2 + 0.5 * (6.0 / 4.0) ** 2)
    assert belief.probabilities("material")["m0"] == pytest.approx(odds / (1 + odds), abs=1e-3)


readings = st.lists(
    st.tuples(st.sampled_from(["density", "elasticity", "friction", "volume", "mass"]), st.floats(0.5, 2.0)),
    min_size=2,
    max_size=6,
)
TYPICAL = {
    "density": (500.0, "kg/m^3"),
    "elasticity": (5e4, "Pa"),
    "friction": (0.7, "1"),
    "volume": (2e-4, "m^3"),
    "mass": (0.1, "kg"),
}
CUBES = Network.from_file("soft-cubes")


@settings(max_examples=25, deadline=None)
@given(readings, st.randoms(use_true_random=False))
def test_order_does_not_matter(chosen: list[tuple[str, float]], shuffler: object) -> None:
    measurements = [
        Measurement(name, TYPICAL[name][0] * factor, 0.15 * TYPICAL[name][0], TYPICAL[name][1])
        for name, factor in chosen
    ]
    other = list(measurements)
    shuffler.shuffle(other)  # type: ignore[attr-defined]
    found = []
    for order in (measurements, other):
        belief = Belief(CUBES)
        for measurement in order:
            belief = belief.update(measurement)
        found.append(belief)
    first, second = found
    assert first.bank.weight == pytest.approx(second.bank.weight, abs=1e-9)
    assert first.bank.mean == pytest.approx(second.bank.mean, abs=1e-8)
    assert sum(first.probabilities("material").values()) == pytest.approx(1, abs=1e-12)


def test_units_do_not_matter() -> None:
    pascals = Belief(CUBES).update(Measurement("elasticity", 5e4, 5e3, "Pa"))
    kilopascals = Belief(CUBES).update(Measurement("elasticity", 50.0, 5.0, "kPa"))
    assert kilopascals.bank.weight == pytest.approx(pascals.bank.weight, abs=1e-12)


def test_every_property_learns_from_every_measurement() -> None:
    belief = Belief(CUBES).update(Measurement("volume", 0.056**3, 2e-6, "m^3"))
    weighed = belief.update(Measurement("mass", 0.1, 0.005, "kg"))
    assert weighed.marginal("elasticity").sd < belief.marginal("elasticity").sd
    assert weighed.marginal("density").mean == pytest.approx(0.1 / 0.056**3, rel=0.05)
    assert weighed.marginal("mass").mean == pytest.approx(0.1, rel=0.05)


def test_the_default_soft_cube_is_clearly_one_class() -> None:
    """50 kPa, 100 g, 56 mm, read with the sensors that the reference itself assumes."""
    belief = Belief(CUBES)
    for measurement in (
        Measurement("volume", 0.056**3, 0.02 * 0.056**3, "m^3"),
        Measurement("mass", 0.1, 0.01, "kg"),
        Measurement("elasticity", 50.0, 6.0, "kPa"),
    ):
        belief = belief.update(measurement)
    assert belief.argmax("material") == "silicone-foam"
    assert belief.probabilities("material")["silicone-foam"] > 0.95
    assert belief.outcome("silicone-foam") == "C"
    assert belief.argmax("elasticity") == pytest.approx(5e4, rel=0.1)


def test_soft_outputs_are_mixtures_of_hard_ones() -> None:
    network = Network.from_file("network-8x10")
    sensor = network.sensor("mat-vision")
    outcomes = sensor.outcomes  # type: ignore[union-attr]
    hard = [sensor.likelihoods(name) for name in outcomes[:2]]  # type: ignore[union-attr]
    soft = sensor.likelihoods({outcomes[0]: 0.3, outcomes[1]: 0.7})  # type: ignore[union-attr]
    for name in network.materials:
        assert soft[name] == pytest.approx(0.3 * hard[0][name] + 0.7 * hard[1][name], abs=1e-15)


def test_outcomes() -> None:
    belief = Belief(simple(2, Unknown(0.1)))
    assert belief.update(Measurement("x", 0.0, 0.1, "1")).outcome("m0") == "C"
    assert belief.update(Measurement("x", 0.0, 0.1, "1")).outcome("m1") == "D"
    assert belief.update(Measurement("x", 500.0, 0.1, "1")).outcome("m1") == "D"
    assert belief.update(Measurement("x", 500.0, 0.1, "1")).outcome("unknown") == "C"
    torn = Belief(simple(3), {"m0": 0.4, "m1": 0.35, "m2": 0.25})
    assert (torn.outcome("m0"), torn.outcome("m1")) == ("W", "U")
    with pytest.raises(UnknownName):
        torn.outcome("m7")


# extremes: finite, normalised, no warning (warnings are errors)


def assert_sound(belief: Belief) -> None:
    found = belief.probabilities("material")
    assert all(math.isfinite(value) for value in found.values())
    assert sum(found.values()) == pytest.approx(1, abs=1e-12)
    assert np.all(np.isfinite(belief.bank.mean))
    assert np.all(belief.bank.variance > 0)


@pytest.mark.parametrize("z", [-1e9, -500.0, 60.0, 510.0, 1e12])
def test_fifty_sigma_off_is_unknown(z: float) -> None:
    belief = Belief(simple(2, Unknown(0.05)))
    reading = Measurement("x", z, 1.0, "1")
    assert belief.surprise(reading) > OUTLIER
    after = belief.update(reading)
    assert_sound(after)
    assert after.argmax("material") == "unknown"


@pytest.mark.parametrize("z", [-1e6, 0.0, 1e-3, 1e13])
def test_far_readings_of_log_properties(z: float) -> None:
    after = Belief(CUBES).update(Measurement("elasticity", z, 10.0, "Pa"))
    assert_sound(after)
    assert after.argmax("material") == "unknown"


@pytest.mark.parametrize("name", ["thesis-3.2", "soft-cubes", "household", "network-8x10"])
@pytest.mark.parametrize("sd", [1e-300, 1e-9, 1e9])
def test_tiny_and_huge_noise(name: str, sd: float) -> None:
    network = Network.from_file(name)
    belief = Belief(network)
    for quantity in network.quantities:
        belief = belief.update(Measurement(quantity, 0.1, sd, network.unit(quantity)))
    assert_sound(belief)


def test_zero_prior_stays_zero() -> None:
    belief = Belief(simple(2), {"m0": 1.0, "m1": 0.0}).update(Measurement("x", 10.0, 1.0, "1"))
    assert_sound(belief)
    assert belief.probabilities("material") == {"m0": 1.0, "m1": 0.0}


def test_one_class() -> None:
    belief = Belief(simple(1)).update(Measurement("x", 50.0, 1.0, "1"))
    assert_sound(belief)
    assert belief.probabilities("material") == {"m0": 1.0}


def test_many_classes() -> None:
    belief = Belief(simple(4096, Unknown(0.05))).update(Measurement("x", 20470.0, 1.0, "1"))
    assert_sound(belief)
    assert belief.argmax("material") == "m2047"


def test_many_repeats() -> None:
    network = CUBES
    belief = Belief(network)
    rng = np.random.default_rng(0)
    for noise in rng.standard_normal(2000):
        belief = belief.update(Measurement("elasticity", 5e4 + 5e3 * noise, 5e3, "Pa"))
    assert_sound(belief)
    assert belief.marginal("elasticity").sd == pytest.approx(5e3 / math.sqrt(2000), rel=0.01)
    linear = Belief(simple(2, Unknown(0.05)))
    for _ in range(100_000):
        linear = linear.update(Measurement("x", 0.1, 1.0, "1"))
    assert_sound(linear)
    assert linear.counts == {"x": 100_000}
    assert linear.marginal("x").sd == pytest.approx(1 / math.sqrt(100_000), rel=1e-3)


# storage


def test_saving_loses_nothing(tmp_path: Path) -> None:
    network = Network.from_file("household")
    belief = Belief(network, dict.fromkeys(network.categories, 1 / 10))
    belief = belief.update_output(network.sensor("observe"), "mug")  # type: ignore[arg-type]
    for quantity, z, sd in (("volume", 4e-4, 3e-5), ("mass", 0.35, 0.01), ("friction", 0.4, 0.08)):
        belief = belief.update(Measurement(quantity, z, sd, network.unit(quantity)))
    belief.save(tmp_path / "belief.json")
    loaded = Belief.load(tmp_path / "belief.json")
    assert np.array_equal(loaded.bank.log_weight, belief.bank.log_weight)
    assert np.array_equal(loaded.bank.mean, belief.bank.mean)
    assert np.array_equal(loaded.bank.covariance, belief.bank.covariance)
    assert loaded.to_json() == belief.to_json()
    assert loaded.counts == belief.counts


def test_a_broken_belief_is_refused() -> None:
    for text in ("{", "[]", "{}", '{"format": "other"}'):
        with pytest.raises(InvalidInput, match="belief"):
            Belief.from_json(text)


def test_a_new_class_is_recognised_next_time(tmp_path: Path) -> None:
    network = Network.from_file("soft-cubes")
    belief = Belief(network)
    for quantity, z, sd in (("density", 2200.0, 40.0), ("elasticity", 6e3, 5e2), ("friction", 0.3, 0.03)):
        belief = belief.update(Measurement(quantity, z, sd, network.unit(quantity)))
    assert belief.argmax("material") == "unknown"
    with_class(belief, "putty").save(tmp_path / "mine.json")
    again = Belief(Network.from_file(tmp_path / "mine.json"))
    for quantity, z, sd in (("density", 2250.0, 40.0), ("elasticity", 6.4e3, 5e2)):
        again = again.update(Measurement(quantity, z, sd, network.unit(quantity)))
    assert again.argmax("material") == "putty"
    assert again.probabilities("material")["putty"] > 0.9
    with pytest.raises(InvalidInput, match="gel"):
        with_class(belief, "gel")


# refusals


def test_bad_input_is_refused_at_the_door() -> None:
    belief = Belief(CUBES)
    with pytest.raises(UnknownName, match="colour"):
        belief.update(Measurement("colour", 1.0, 1.0, "1"))
    with pytest.raises(InvalidInput, match="unit"):
        belief.update(Measurement("mass", 1.0, 1.0, "Pa"))
    with pytest.raises(InvalidInput, match="sd"):
        Measurement("mass", 1.0, 0.0, "kg")
    with pytest.raises(InvalidInput, match="sum to 1"):
        Belief(CUBES, {"gel": 0.5, "sponge": 0.6})
    with pytest.raises(InvalidInput, match=">= 0"):
        Belief(CUBES, {"gel": 1.5, "sponge": -0.5})
    with pytest.raises(UnknownName, match="cheese"):
        Belief(CUBES, {"cheese": 1.0})
    with pytest.raises(InvalidInput, match="likelihood for"):
        belief.update_class("material", {"gel": 1.0})
    with pytest.raises(InvalidInput, match="positive likelihood"):
        belief.update_class("material", dict.fromkeys((*CUBES.materials, "unknown"), 0.0))
    with pytest.raises(UnknownName, match="category"):
        belief.probabilities("category")
