"""The belief against the same network as a gtsam hybrid factor graph, on random networks."""

from __future__ import annotations

import numpy as np
import pytest

from dynamics.errors import InvalidInput
from estimation.belief import Belief
from estimation.hybrid import hybrid_posterior
from estimation.measurement import Measurement
from estimation.network import Network, Property, Relation, Unknown


def random_network(rng: np.random.Generator, materials: int, categories: int, unknown: bool) -> Network:
    """Return a network with properties of the material, of the category, and of neither, and a sum."""
    parents = ["material", "category" if categories else "material", None]
    properties = []
    for i, parent in enumerate(parents):
        count = {"material": materials, "category": categories, None: 1}[parent]
        means, sds = rng.uniform(1.0, 10.0, count), rng.uniform(0.2, 2.0, count)
        properties.append(Property(f"p{i}", parent, "1", "linear", tuple(means), tuple(sds)))
    conditional = tuple(tuple(row) for row in rng.dirichlet(np.ones(materials), categories).tolist())
    prior = rng.dirichlet(np.ones(categories or materials)).tolist()
    return Network(
        name="random",
        materials=tuple(f"m{i}" for i in range(materials)),
        properties=tuple(properties),
        prior=tuple(prior),
        categories=tuple(f"c{i}" for i in range(categories)),
        conditional=conditional if categories else (),
        relations=(Relation("r", "sum", "1", (("p0", 1.0), ("p1", -2.0))),),
        unknown=Unknown(0.07) if unknown else None,
    )


@pytest.mark.parametrize("seed", range(12))
def test_posteriors_agree(seed: int) -> None:
    rng = np.random.default_rng(seed)
    network = random_network(rng, int(rng.integers(2, 7)), int(rng.integers(0, 5)), bool(seed % 2))
    names = [*network.quantities, *rng.choice(network.quantities, 3)]
    readings = [
        Measurement(str(name), float(rng.normal(4, 4)), float(rng.uniform(0.3, 3)), "1")
        for name in rng.permutation(names)
    ]
    known = {name: float(rng.uniform(0.1, 1)) for name in network.classes("material")}
    oracle = hybrid_posterior(network, readings, {"material": known})
    belief = Belief(network).update_class("material", known)
    for reading in readings:
        belief = belief.update(reading)
    index = [network.index(name) for name in oracle.properties]
    assert belief.bank.weight == pytest.approx(oracle.weight, abs=1e-9)
    assert belief.bank.mean[:, index] == pytest.approx(oracle.mean, abs=1e-9)
    covariance = belief.bank.covariance[:, index][:, :, index]
    assert covariance == pytest.approx(oracle.covariance, abs=1e-9)


def test_the_published_network_agrees() -> None:
    network = Network.from_file("network-8x10")
    readings = [
        Measurement("density", 900.0, 223.0, "kg/m^3"),
        Measurement("density", 700.0, 223.0, "kg/m^3"),
        Measurement("volume", 9e-5, 1e-5, "m^3"),
        Measurement("friction", 0.4, 0.06, "1"),
    ]
    belief = Belief(network)
    for reading in readings:
        belief = belief.update(reading)
    assert belief.bank.weight == pytest.approx(hybrid_posterior(network, readings).weight, abs=1e-9)


def test_nonlinear_readings_are_refused() -> None:
    with pytest.raises(InvalidInput, match="mass"):
        hybrid_posterior(Network.from_file("soft-cubes"), [Measurement("mass", 0.1, 0.01, "kg")])
