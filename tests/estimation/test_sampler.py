"""The belief against NumPyro's No-U-Turn sampler: exact inference replaces a probabilistic programming framework.

The sampler is given the reference network as it stands in its file, not the bank that the belief works on: the
classes are summed over, the continuous properties are sampled.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from estimation.belief import Belief
from estimation.measurement import Measurement
from estimation.network import Network, Property, Relation
from estimation.sensor import ClassSensor

numpyro = pytest.importorskip("numpyro", reason="the extra crosscheck is not installed")
pytestmark = pytest.mark.slow

CHAINS, WARMUP, SAMPLES = 4, 1000, 4000
UNSEEN = 3 / (CHAINS * SAMPLES)
"""Probability of what so many samples may never have seen (rule of three)."""
NONLINEAR = 3e-3
"""What the belief may be off by where it matches the moments of a relation; the design asks for 1e-2."""


@dataclass(frozen=True)
class Case:
    network: Network
    readings: tuple[Measurement, ...]
    seen: str = ""
    allowed: float = 0.0


def random_network() -> Network:
    """Return six materials whose mass is density x volume, both on the linear scale."""
    rng = np.random.default_rng(4)
    names = tuple(f"m{i}" for i in range(6))
    density = Property(
        "density", "material", "kg/m^3", "linear", tuple(rng.uniform(400, 900, 6)), tuple(rng.uniform(60, 120, 6))
    )
    stiff = Property(
        "stiffness", "material", "N/m", "linear", tuple(rng.uniform(10, 30, 6)), tuple(rng.uniform(3, 8, 6))
    )
    volume = Property("volume", None, "m^3", "linear", (2e-4,), (3e-5,))
    mass = Relation("mass", "product", "kg", (("density", 1.0), ("volume", 1.0)))
    prior = tuple(rng.dirichlet(np.full(6, 5.0)))
    return Network("random", names, (density, stiff, volume), prior, relations=(mass,), unknown=None)


CASES = {
    "thesis": Case(
        Network.from_file("thesis-3.1-erratum").without_unknown(),
        (Measurement("density", 3150.0, 300.0, "kg/m^3"), Measurement("elasticity", 120e9, 60e9, "Pa")),
    ),
    "household": Case(
        Network.from_file("household").without_unknown(),
        (Measurement("mass", 0.035, 0.006, "kg"), Measurement("elasticity", 8e3, 3e3, "Pa")),
        seen="block",
        allowed=NONLINEAR,
    ),
    "random": Case(
        random_network(),
        (Measurement("mass", 0.13, 0.012, "kg"), Measurement("stiffness", 18.0, 4.0, "N/m")),
        allowed=NONLINEAR,
    ),
}


def joint_classes(network: Network) -> list[tuple[float, int, int]]:
    """Return weight, category and material of every combination that the file allows."""
    if not network.categories:
        return [(p, 0, m) for m, p in enumerate(network.prior)]
    rows = zip(network.prior, network.conditional, strict=True)
    return [(p * q, c, m) for c, (p, row) in enumerate(rows) for m, q in enumerate(row) if q > 0]


def table(
    network: Network, prop: Property, classes: list[tuple[float, int, int]]
) -> tuple[np.ndarray, np.ndarray]:
    """Return a property's mean and sd per joint class, of its logarithm on the log scale."""
    index = {"category": 1, "material": 2}.get(prop.parent or "")
    rows = [0 if index is None else one[index] for one in classes]
    mean, sd = np.array([prop.means[i] for i in rows]), np.array([prop.sds[i] for i in rows])
    if prop.scale == "linear":
        return mean, sd
    variance = np.log1p((sd / mean) ** 2)
    return np.log(mean) - variance / 2, np.sqrt(variance)


def sampled(case: Case) -> tuple[dict[str, tuple[float, float]], dict[str, tuple[float, float]]]:
    """Return P(material) and the means of the coordinates, each with its Monte-Carlo standard error."""
    import jax
    import jax.numpy as jnp
    from numpyro.diagnostics import effective_sample_size, split_gelman_rubin
    from numpyro.distributions import Categorical, MixtureSameFamily, Normal
    from numpyro.infer import MCMC, NUTS, init_to_value

    numpyro.enable_x64()
    network = case.network
    classes = joint_classes(network)
    weight = np.array([one[0] for one in classes])
    if case.seen:
        sensor = network.sensor("observe")
        assert isinstance(sensor, ClassSensor)
        weight = weight * np.array([sensor.likelihoods(case.seen)[network.categories[c]] for _, c, _ in classes])
    tables = [table(network, prop, classes) for prop in network.properties]
    mean, sd = (np.column_stack([t[i] for t in tables]) for i in (0, 1))
    centre, scale = mean.mean(axis=0), np.sqrt(mean.var(axis=0) + (sd**2).mean(axis=0))
    logits = jnp.log(weight / weight.sum())
    parts = Normal((mean - centre) / scale, sd / scale).to_event(1)

    def quantity(x: Any, name: str) -> Any:
        relation = network.relation(name)
        terms = relation.terms if relation is not None else ((name, 1.0),)
        product = 1.0
        for key, power in terms:
            i = network.index(key)
            value = jnp.exp(x[..., i]) if network.properties[i].scale == "log" else x[..., i]
            product = product * value**power
        return product

    def model() -> None:
        u = numpyro.sample("u", MixtureSameFamily(Categorical(logits=logits), parts))
        for reading in case.readings:
            known = quantity(centre + scale * u, reading.property)
            numpyro.sample(reading.property, Normal(known, reading.sd), obs=reading.mean)

    # From where the readings point to: a chain that begins in a far mode of no weight would stay there.
    start = np.zeros(len(network.properties))
    for reading in case.readings:
        if reading.property in network.property_names:
            i = network.index(reading.property)
            value = math.log(reading.mean) if network.properties[i].scale == "log" else reading.mean
            start[i] = (value - centre[i]) / scale[i]
    sampler = MCMC(
        NUTS(model, target_accept_prob=0.95, init_strategy=init_to_value(values={"u": jnp.asarray(start)})),
        num_warmup=WARMUP,
        num_samples=SAMPLES,
        num_chains=CHAINS,
        chain_method="vectorized",
        progress_bar=False,
    )
    sampler.run(jax.random.PRNGKey(1))
    u = sampler.get_samples(group_by_chain=True)["u"]
    share = np.asarray(jax.nn.softmax(logits + parts.log_prob(u[..., None, :]), axis=-1))
    members = np.array([one[2] for one in classes])
    traces = {name: share[..., members == m].sum(axis=-1) for m, name in enumerate(network.materials)} | {
        prop.name: np.asarray(centre[i] + scale[i] * u[..., i]) for i, prop in enumerate(network.properties)
    }
    found = {}
    for name, trace in traces.items():
        if trace.std() > 1e-6 * max(abs(trace.mean()), 1.0):
            assert split_gelman_rubin(trace) < 1.02, f"the chains disagree on {name}"
        size = max(float(effective_sample_size(trace)), 1.0) if trace.std() > 0 else 1.0
        found[name] = (float(trace.mean()), float(trace.std() / math.sqrt(size)))
    return (
        {name: found[name] for name in network.materials},
        {prop.name: found[prop.name] for prop in network.properties},
    )


@pytest.mark.parametrize("name", CASES)
def test_posteriors_agree_with_a_sampler(name: str) -> None:
    case = CASES[name]
    belief = Belief(case.network)
    for reading in case.readings:
        belief = belief.update(reading)
    if case.seen:
        sensor = case.network.sensor("observe")
        assert isinstance(sensor, ClassSensor)
        belief = belief.update_output(sensor, case.seen)
    materials, coordinates = sampled(case)
    exact = belief.probabilities("material")
    assert sorted(exact.values())[-2] > 0.02, "a case that leaves no doubt tests nothing"
    for material, (p, error) in materials.items():
        assert error < 0.01
        assert exact[material] == pytest.approx(p, abs=4 * error + UNSEEN + case.allowed), material
    bank = belief.bank
    for i, (prop, (mean, error)) in enumerate(coordinates.items()):
        spread = math.sqrt(
            float(bank.weight @ (bank.variance[:, i] + bank.mean[:, i] ** 2))
            - float(bank.weight @ bank.mean[:, i]) ** 2
        )
        assert float(bank.weight @ bank.mean[:, i]) == pytest.approx(
            mean, abs=4 * error + 10 * case.allowed * spread
        ), prop


def test_the_check_can_fail() -> None:
    """A belief that learned from another reading is told apart."""
    case = CASES["thesis"]
    materials, _ = sampled(case)
    shifted = replace(case.readings[0], mean=case.readings[0].mean + 500)
    other = Belief(case.network).update(shifted).update(case.readings[1]).probabilities("material")
    assert any(abs(other[name] - p) > 4 * error + UNSEEN for name, (p, error) in materials.items())
