"""Nonlinear readings against brute-force quadrature on a dense grid of the true values."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from estimation.belief import Belief
from estimation.conditioning import condition_exponential
from estimation.measurement import Measurement
from estimation.network import Network, Property, Relation


def _coordinate_grid(prop: Property, row: int, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return true values and their prior masses on an even grid of the coordinate, +-9 sd."""
    u = prop.location[row] + prop.spread[row] * np.linspace(-9, 9, count)
    mass = np.exp(-0.5 * ((u - prop.location[row]) / prop.spread[row]) ** 2)
    return (np.exp(u) if prop.scale == "log" else u), mass / mass.sum()


def brute_force(
    network: Network, readings: dict[str, tuple[float, float]], count: int = 801
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return P(material | readings of density, volume, mass), and mean and sd of the density."""
    evidence, mean, second = [], [], []
    for k in range(len(network.materials)):
        d, p_d = _coordinate_grid(network.property("density"), k, count)
        v, p_v = _coordinate_grid(network.property("volume"), 0, count)
        log = np.log(p_d)[:, None] + np.log(p_v)[None, :]
        values = {"density": d[:, None], "volume": v[None, :], "mass": d[:, None] * v[None, :]}
        for name, (z, sd) in readings.items():
            log = log - 0.5 * ((z - values[name]) / sd) ** 2
        top = log.max()
        weight = np.exp(log - top)
        evidence.append(top + np.log(weight.sum()) + np.log(network.prior[k]))
        mean.append(float((weight * d[:, None]).sum() / weight.sum()))
        second.append(float((weight * d[:, None] ** 2).sum() / weight.sum()))
    evidence_array = np.array(evidence)
    posterior = np.exp(evidence_array - evidence_array.max())
    posterior /= posterior.sum()
    centre = float(posterior @ mean)
    return posterior, np.array(centre), np.array(np.sqrt(posterior @ second - centre**2))


def mass_network(density_scale: str, volume_scale: str, spread: float) -> Network:
    density = Property("density", "material", "kg/m^3", density_scale, (250.0, 450.0, 600.0), (40.0, 45.0, 80.0))
    volume = Property("volume", None, "m^3", volume_scale, (2e-4,), (2e-4 * spread,))
    return Network(
        name="mass",
        materials=("a", "b", "c"),
        properties=(density, volume),
        prior=(0.5, 0.3, 0.2),
        relations=(Relation("mass", "product", "kg", (("density", 1.0), ("volume", 1.0))),),
        unknown=None,
    )


UNITS = {"density": "kg/m^3", "volume": "m^3", "mass": "kg"}


@pytest.mark.parametrize("scales", [("log", "log"), ("linear", "linear"), ("linear", "log"), ("log", "linear")])
@pytest.mark.parametrize(
    ("spread", "readings"),
    [
        (0.15, {"mass": (0.1, 0.01)}),
        (0.3, {"volume": (1.8e-4, 2e-5), "mass": (0.1, 0.02)}),
        (0.3, {"volume": (1.8e-4, 2e-6), "mass": (0.1, 0.002)}),
        (0.25, {"density": (500.0, 80.0), "volume": (1.8e-4, 4e-5), "mass": (0.1, 0.03)}),
    ],
)
def test_mass_agrees_with_brute_force(
    scales: tuple[str, str], spread: float, readings: dict[str, tuple[float, float]]
) -> None:
    network = mass_network(*scales, spread)
    belief = Belief(network)
    for name, (z, sd) in readings.items():
        belief = belief.update(Measurement(name, z, sd, UNITS[name]))
    posterior, mean, sd = brute_force(network, readings)
    assert np.array(list(belief.probabilities("material").values())) == pytest.approx(posterior, abs=1e-3)
    marginal = belief.marginal("density")
    assert marginal.mean == pytest.approx(float(mean), rel=1e-3)
    assert marginal.sd == pytest.approx(float(sd), rel=1e-2)


@pytest.mark.parametrize("seed", range(16))
def test_random_weighings_agree_with_brute_force(seed: int) -> None:
    """Volumes read to a few per cent or to a third, masses likewise: posteriors to 1e-3."""
    rng = np.random.default_rng(seed)
    scales = [("log", "log"), ("linear", "linear"), ("linear", "log"), ("log", "linear")][seed % 4]
    network = mass_network(*scales, float(rng.uniform(0.1, 0.25)))
    readings = {"mass": (float(rng.uniform(0.04, 0.16)), float(rng.uniform(0.003, 0.05)))}
    if rng.random() < 0.7:
        readings["volume"] = (float(rng.uniform(1.4e-4, 2.6e-4)), float(rng.uniform(3e-6, 6e-5)))
    if rng.random() < 0.5:
        readings["density"] = (float(rng.uniform(200, 700)), float(rng.uniform(20, 150)))
    belief = Belief(network)
    for name, (z, sd) in readings.items():
        belief = belief.update(Measurement(name, z, sd, UNITS[name]))
    posterior, mean, _ = brute_force(network, readings, 401)
    assert np.array(list(belief.probabilities("material").values())) == pytest.approx(posterior, abs=1e-3)
    assert belief.marginal("density").mean == pytest.approx(float(mean), rel=1e-3)


@pytest.mark.parametrize(("z", "sd"), [(7.0, 6.0), (-2.0, 6.0), (7.0, 0.5), (30.0, 1e-3), (200.0, 4.0)])
def test_wide_readings_of_log_properties(z: float, sd: float) -> None:
    """E = 7 +- 6 kPa and worse: evidence and moments to 1e-6 of a dense grid."""
    mean, variance = np.log(np.array([7.0, 15.0, 50.0])), np.array([0.3, 0.2, 1.5])
    evidence, centre, spread = condition_exponential(mean, variance, z, sd)
    for k in range(3):
        t = mean[k] + np.sqrt(variance[k]) * np.linspace(-12, 12, 2_000_001)
        log = -0.5 * ((t - mean[k]) ** 2 / variance[k] + ((z - np.exp(t)) / sd) ** 2)
        weight = np.exp(log - log.max())
        step = t[1] - t[0]
        exact = log.max() + np.log(weight.sum() * step / (2 * np.pi * sd * np.sqrt(variance[k])))
        first = float(weight @ t / weight.sum())
        assert evidence[k] == pytest.approx(exact, abs=1e-6)
        assert centre[k] == pytest.approx(first, abs=1e-6)
        assert spread[k] == pytest.approx(float(weight @ (t - first) ** 2 / weight.sum()), rel=1e-4)


def test_repeated_wide_readings_share_the_true_value() -> None:
    """Ten readings 7 +- 6 are one reading 7 +- 6/sqrt(10), in any order with others."""
    network = replace(mass_network("log", "log", 0.2))
    once = Belief(network).update(Measurement("density", 300.0, 200.0 / np.sqrt(10), "kg/m^3"))
    often = Belief(network)
    for _ in range(10):
        often = often.update(Measurement("density", 300.0, 200.0, "kg/m^3"))
    assert often.bank.log_weight == pytest.approx(once.bank.log_weight, abs=1e-10)
    assert often.bank.mean == pytest.approx(once.bank.mean, rel=1e-10)
