"""Readings of several properties at once, of relations, and of log-scale properties, against simulation."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest

from estimation.belief import Belief
from estimation.measurement import Measurement
from estimation.network import Network
from estimation.sensor import Sensor
from selection.information import information_gain

SAMPLES = 2000


@dataclass(frozen=True)
class Case:
    network: Network
    readings: tuple[Measurement, ...]
    sensors: tuple[Sensor, ...]


def linear(network: Network) -> Network:
    return replace(network, properties=tuple(replace(p, scale="linear") for p in network.properties))


def narrow_volume(network: Network, share: float = 0.25) -> Network:
    properties = tuple(
        replace(p, sds=(share * p.means[0],)) if p.name == "volume" else p for p in network.properties
    )
    return replace(network, properties=properties)


CUBES = narrow_volume(Network.from_file("soft-cubes"))
DENSE = replace(
    linear(CUBES),
    properties=tuple(replace(p, sds=tuple(0.12 * m for m in p.means)) for p in linear(CUBES).properties),
)
MASS, VOLUME = Sensor("mass", 0.01, 0.02), Sensor("volume", 5e-6, 0.03)
E = Sensor("elasticity", 1e3, 0.12)
WEIGHED = (Measurement("mass", 0.1, 0.01, "kg"),)

CASES = {
    "mass": Case(CUBES, (), (MASS,)),
    "elasticity": Case(CUBES, (), (E,)),
    "elasticity and volume": Case(CUBES, (), (E, VOLUME)),
    "mass and volume": Case(CUBES, (), (MASS, VOLUME)),
    "density and volume after weighing": Case(CUBES, WEIGHED, (Sensor("density", 30.0, 0.1), VOLUME)),
    "volume after weighing": Case(CUBES, WEIGHED, (VOLUME,)),
    "three at once": Case(CUBES, (), (E, VOLUME, Sensor("friction", 0.08))),
    "linear mass": Case(DENSE, (), (MASS,)),
    "linear mass and volume": Case(DENSE, (), (MASS, VOLUME)),
    "linear volume after weighing": Case(DENSE, WEIGHED, (VOLUME,)),
}


def simulated(case: Case, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Return log2 posterior / prior of the true material, and of everything, for simulated readings.

    True values are drawn from the belief; p(reading | material) is averaged over 2000 draws of its own,
    which uses nothing of the quadrature under test.
    """
    belief = Belief(case.network)
    for reading in case.readings:
        belief = belief.update(reading)
    bank = belief.bank
    weight = bank.weight
    network = case.network
    logs = np.array([p.scale == "log" for p in network.properties])

    def draw(k: np.ndarray) -> np.ndarray:
        root = np.linalg.cholesky(bank.covariance)[k]
        u = bank.mean[k] + np.einsum("nij,nj->ni", root, rng.standard_normal((len(k), len(logs))))
        return np.where(logs, np.exp(np.where(logs, u, 0)), u)

    def value(x: np.ndarray, quantity: str) -> np.ndarray:
        relation = network.relation(quantity)
        if relation is None:
            return x[:, network.index(quantity)]
        return np.prod([x[:, network.index(name)] ** power for name, power in relation.terms], axis=0)

    def log_likelihood(z: np.ndarray, x: np.ndarray) -> np.ndarray:
        total = np.zeros((len(z), len(x)))
        for i, sensor in enumerate(case.sensors):
            true = value(x, sensor.property)
            noise = np.hypot(sensor.sd, sensor.relative_sd * true)
            total += -0.5 * ((z[:, i : i + 1] - true) / noise) ** 2 - np.log(noise)
        return total

    k = rng.choice(len(weight), size=SAMPLES, p=weight)
    x = draw(k)
    z = np.column_stack(
        [
            value(x, s.property)
            + rng.standard_normal(SAMPLES) * np.hypot(s.sd, s.relative_sd * value(x, s.property))
            for s in case.sensors
        ]
    )
    evidence = np.zeros((SAMPLES, len(weight)))
    for row in range(len(weight)):
        if weight[row] < 1e-9:
            continue
        other = draw(np.full(2000, row))
        evidence[:, row] = np.exp(log_likelihood(z, other)).mean(axis=1)
    mixed = evidence @ weight
    own = evidence[np.arange(SAMPLES), k]
    exact = np.array([log_likelihood(z[i : i + 1], x[i : i + 1])[0, 0] for i in range(SAMPLES)])
    return np.log2(own / mixed), (exact - np.log(mixed)) / math.log(2)


@pytest.mark.parametrize("name", CASES)
def test_gain_agrees_with_simulation(name: str) -> None:
    case = CASES[name]
    belief = Belief(case.network)
    for reading in case.readings:
        belief = belief.update(reading)
    about_class, about_all = simulated(case, np.random.default_rng(7))
    for target, samples in (("material", about_class), ("everything", about_all)):
        gain = information_gain(belief, case.sensors, target)
        assert gain == pytest.approx(samples.mean(), abs=4 * samples.std() / math.sqrt(SAMPLES) + 0.01)
