"""The same network as a gtsam hybrid factor graph: an independent oracle to test the belief against."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from dynamics.errors import InvalidInput
from estimation.measurement import Measurement
from estimation.network import CATEGORY, LINEAR, MATERIAL, Network, Property


@dataclass(frozen=True, eq=False)
class HybridPosterior:
    """What the hybrid graph gives.

    Attributes:
        weight: probabilities of the hypotheses, in the order of `Network.hypotheses`, shape (K,).
        mean: posterior means per hypothesis of the measured properties, shape (K, m).
        covariance: shape (K, m, m).
        properties: names of those m properties.
    """

    weight: np.ndarray
    mean: np.ndarray
    covariance: np.ndarray
    properties: tuple[str, ...]


def hybrid_posterior(
    network: Network,
    measurements: Sequence[Measurement],
    likelihoods: Mapping[str, Mapping[str, float]] | None = None,
) -> HybridPosterior:
    """Eliminate the hybrid factor graph of a network and its readings.

    Factors: one table over material and category, one Gaussian per class of the parent and measured
    property, one linear Gaussian per reading; all repeated readings hang on the same property. Properties
    that no reading touches are left out: they do not change the rest.

    Args:
        network: the reference; all properties measured live on the linear scale, all relations are sums.
        measurements: readings in SI units.
        likelihoods: per variable, P(evidence | class) for all its classes.

    Raises:
        InvalidInput: if a reading is not linear in the properties.
        UnknownName: if there is no such quantity.
    """
    import gtsam

    rows = [_row(network, measurement) for measurement in measurements]
    used = tuple(sorted({name for row in rows for name in row}))
    keys = {name: gtsam.symbol("x", i) for i, name in enumerate(used)}
    sizes = {name: len(network.classes(name)) for name in network.variables}
    # a discrete variable of one value makes gtsam's discrete marginal uniform: it is left out
    classes = {n: (gtsam.symbol("c", i), sizes[n]) for i, n in enumerate(sizes) if sizes[n] > 1}
    if not classes:
        raise InvalidInput(f"hybrid graph: network {network.name}", sizes, "a variable of two classes or more")
    graph = gtsam.HybridGaussianFactorGraph()
    graph.push_back(gtsam.DecisionTreeFactor(list(classes.values()), _joint_prior(network).ravel().tolist()))
    for variable, values in (likelihoods or {}).items():
        if variable not in classes:
            continue
        table = np.array([values[name] for name in network.classes(variable)])
        graph.push_back(gtsam.DecisionTreeFactor([classes[variable]], table.tolist()))
    for name in used:
        prop = network.property(name)
        modes = [_gaussian(gtsam, keys[name], *moments) for moments in _moments(network, prop)]
        if prop.parent not in classes:
            graph.push_back(modes[0][0])
        else:
            graph.push_back(gtsam.HybridGaussianFactor(classes[prop.parent], modes))
    for row, measurement in zip(rows, measurements, strict=True):
        graph.push_back(_reading(gtsam, {keys[name]: c for name, c in row.items()}, measurement))
    return _read(gtsam, network, graph.eliminateSequential(), {n: c[0] for n, c in classes.items()}, keys)


def _joint_prior(network: Network) -> np.ndarray:
    """Return P(material, category), shape (materials[, categories]), unknown with unknown last."""
    known = np.array(network.prior, dtype=float)
    if network.categories:
        known = (known[:, None] * np.array(network.conditional)).T
    if network.unknown is None:
        return known
    table = np.zeros([size + 1 for size in known.shape])
    table[tuple(slice(size) for size in known.shape)] = known * (1 - network.unknown.weight)
    table[(-1,) * table.ndim] = network.unknown.weight
    return table


def _moments(network: Network, prop: Property) -> list[tuple[float, float]]:
    """Return mean and sd of a linear property per class of its parent, the unknown one by its definition."""
    rows = list(zip(prop.means, prop.sds, strict=True))
    if network.unknown is not None and prop.parent is not None:
        mean = float(np.mean(prop.means))
        mixture = float(np.sqrt(np.mean(np.square(prop.sds)) + np.var(prop.means)))
        rows.append((mean, max(network.unknown.width * mixture, 1.25 * max(prop.sds))))
    return rows


def _row(network: Network, measurement: Measurement) -> dict[str, float]:
    """Return the coefficients of a reading in the properties."""
    relation = network.relation(measurement.property)
    terms = {measurement.property: 1.0} if relation is None else dict(relation.terms)
    involved: list[Property] = [network.property(name) for name in terms]
    if any(prop.scale != LINEAR for prop in involved) or (relation is not None and relation.kind != "sum"):
        raise InvalidInput(f"hybrid graph: {measurement.property}", "not linear", "linear properties and sums")
    return terms


def _gaussian(gtsam: Any, key: int, mean: float, sd: float) -> tuple[Any, float]:
    """Return one mode of a property with the normaliser that modes of different widths need."""
    conditional = gtsam.GaussianConditional.FromMeanAndStddev(key, np.array([mean]), sd)
    return conditional, conditional.negLogConstant()


def _reading(gtsam: Any, terms: Mapping[int, float], measurement: Measurement) -> Any:
    """Return the linear Gaussian factor of one reading."""
    model = gtsam.noiseModel.Isotropic.Sigma(1, measurement.sd)
    blocks = [part for key, value in terms.items() for part in (key, np.array([[value]]))]
    return gtsam.JacobianFactor(*blocks, np.array([measurement.mean]), model)


def _read(
    gtsam: Any, network: Network, net: Any, classes: Mapping[str, int], keys: Mapping[str, int]
) -> HybridPosterior:
    """Return the posterior of every hypothesis from the eliminated net."""
    table, bank = net.discreteMarginal(), network.hypotheses
    weight, mean, covariance = np.empty(len(bank.material)), [], []
    ordering = gtsam.Ordering()
    for key in keys.values():
        ordering.push_back(key)
    for k, (material, category) in enumerate(zip(bank.material, bank.category, strict=True)):
        value = gtsam.DiscreteValues()
        for variable, index in ((MATERIAL, material), (CATEGORY, category)):
            if variable in classes:
                value[classes[variable]] = int(index)
        weight[k] = table.evaluate(value)
        if keys:
            chosen = net.choose(value)
            solution = chosen.optimize()
            mean.append([solution.at(key)[0] for key in keys.values()])
            covariance.append(np.linalg.inv(gtsam.GaussianFactorGraph(chosen).hessian(ordering)[0]))
    return HybridPosterior(weight / weight.sum(), np.array(mean), np.array(covariance), tuple(keys))
