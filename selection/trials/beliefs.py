"""Beliefs about many objects at once, over one network: the arithmetic of `Belief`, an array axis longer."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from dynamics.errors import InvalidInput
from estimation.belief import Belief
from estimation.conditioning import condition_linear
from estimation.measurement import Measurement
from estimation.network import CATEGORY, LINEAR, MATERIAL, Network
from estimation.sensor import ClassSensor


class Beliefs:
    """N beliefs that are conditioned together, each on readings of its own object.

    What stands in a row is what `Belief` would hold after the same readings: readings of one property share
    its true value and are fused before they meet the prior.

    Args:
        network: the reference; what is read of it lives on the linear scale.
        count: number of beliefs N.
        prior: as for `Belief`, the same for all.
    """

    def __init__(self, network: Network, count: int, prior: Mapping[str, float] | None = None) -> None:
        self.network = network
        bank = network.hypotheses
        self._base = np.tile(Belief(network, prior).bank.log_weight, (count, 1))
        self._log_weight = self._base.copy()
        self._z = np.zeros((count, len(network.properties)))
        self._sd = np.full_like(self._z, np.inf)
        parents = {prop.name: self.rows_of(prop.parent) for prop in network.properties}
        self._outcomes: dict[int, list[tuple[ClassSensor, int]]] = {}
        self._prior = prior
        self._first = {name: np.unique(rows, return_index=True)[1] for name, rows in parents.items()}
        self._parents = parents
        self._evidence = {name: np.zeros((count, len(first))) for name, first in self._first.items()}
        self._mean = {n: np.tile(bank.mean[f, network.index(n)], (count, 1)) for n, f in self._first.items()}
        self._variance = {
            n: np.tile(bank.variance[f, network.index(n)], (count, 1)) for n, f in self._first.items()
        }

    def __len__(self) -> int:
        return len(self._base)

    def rows_of(self, variable: str | None) -> np.ndarray:
        """Return the class index of every hypothesis, shape (K,); zeros for no variable."""
        bank = self.network.hypotheses
        if variable == MATERIAL:
            return bank.material
        return bank.category if variable == CATEGORY else np.zeros_like(bank.material)

    def weights(self, rows: np.ndarray) -> np.ndarray:
        """Return the probabilities of the hypotheses, shape (n, K)."""
        log = self._log_weight[rows]
        found = np.exp(log - log.max(axis=1, keepdims=True))
        return np.asarray(found / found.sum(axis=1, keepdims=True))

    def probabilities(self, variable: str) -> np.ndarray:
        """Return P(class) of a variable, ``unknown`` last where the network has it, shape (N, classes)."""
        count = len(self.network.classes(variable))
        return np.asarray(self.weights(np.arange(len(self))) @ np.eye(count)[self.rows_of(variable)])

    def is_read(self, quantity: str, rows: np.ndarray) -> np.ndarray:
        """Return whether a property was read already, shape (n,)."""
        return np.asarray(np.isfinite(self._sd[rows, self.network.index(quantity)]))

    def moments(self, quantity: str, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return mean and variance of a property under every class of its parent, each (n, U)."""
        return self._mean[quantity][rows], self._variance[quantity][rows]

    def update(self, rows: np.ndarray, quantity: str, z: np.ndarray, sd: np.ndarray | float) -> None:
        """Condition some beliefs on readings of a property.

        Args:
            rows: which beliefs, shape (n,), each at most once.
            quantity: the property.
            z: their readings [SI unit], shape (n,).
            sd: the readings' standard deviations [SI unit], shape (n,) or one for all.

        Raises:
            InvalidInput: if the property does not live on the linear scale.
            UnknownName: if there is no such property.
        """
        i, network = self.network.index(quantity), self.network
        check_linear(network, quantity)
        floor = network.noise_floor(quantity)
        noise = np.maximum(np.broadcast_to(sd, z.shape), floor)
        before, known = self._sd[rows, i], self._z[rows, i]
        smaller = np.minimum(before, noise)
        a, b = (smaller / before) ** 2, (smaller / noise) ** 2
        fused = (a * known + b * z) / (a + b)
        spread = np.maximum(smaller / np.sqrt(a + b), floor)
        self._z[rows, i], self._sd[rows, i] = fused, spread
        bank, first = network.hypotheses, self._first[quantity]
        found = condition_linear(bank.mean[first, i], bank.variance[first, i], fused[:, None], spread[:, None])
        self._evidence[quantity][rows], self._mean[quantity][rows], self._variance[quantity][rows] = found
        self._weigh(rows)

    def update_output(self, rows: np.ndarray, sensor: ClassSensor, outcome: np.ndarray) -> None:
        """Condition some beliefs on outcomes of a classifier.

        Args:
            rows: which beliefs, shape (n,), each at most once.
            sensor: the classifier.
            outcome: indices of its outcomes, shape (n,).
        """
        for row, index in zip(rows.tolist(), outcome.tolist(), strict=True):
            self._outcomes.setdefault(row, []).append((sensor, index))
        likelihood = self.likelihoods(sensor)[outcome]
        with np.errstate(divide="ignore"):
            self._base[rows] += np.log(likelihood)[:, self.rows_of(sensor.variable)]
        self._weigh(rows)

    def likelihoods(self, sensor: ClassSensor) -> np.ndarray:
        """Return P(outcome | class), the mean of all classes for ``unknown``, shape (outcomes, classes)."""
        columns = sensor.matrix
        if len(self.network.classes(sensor.variable)) > columns.shape[1]:
            columns = np.column_stack([columns, columns.mean(axis=1)])
        return columns

    def one(self, row: int) -> Belief:
        """Return one of the beliefs by itself."""
        belief = Belief(self.network, self._prior)
        for prop, z, sd in zip(
            self.network.properties, self._z[row].tolist(), self._sd[row].tolist(), strict=True
        ):
            if math.isfinite(sd):
                belief = belief.update(Measurement(prop.name, z, sd, prop.unit))
        for sensor, index in self._outcomes.get(row, ()):
            belief = belief.update_output(sensor, sensor.outcomes[index])
        return belief

    def _weigh(self, rows: np.ndarray) -> None:
        total = self._base[rows].copy()
        for name in sorted(self._evidence):
            total += self._evidence[name][rows][:, self._parents[name]]
        self._log_weight[rows] = total


def check_linear(network: Network, quantity: str) -> None:
    """Refuse a quantity that the batched arithmetic has no closed form for.

    Raises:
        InvalidInput: if it is a relation, or lives on the log scale.
    """
    if network.relation(quantity) is not None:
        raise InvalidInput(f"many beliefs: {quantity}", "a relation", "a property")
    scale = network.property(quantity).scale
    if scale != LINEAR:
        raise InvalidInput(f"many beliefs: {quantity}", scale, "a property on the linear scale")
