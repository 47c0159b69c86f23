"""The bank of Gaussian hypotheses and its conditioning on a reading of any property or relation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from estimation.conditioning import condition_exponential, condition_linear
from estimation.network import LOG, Network
from estimation.products import product_moments

Scalar = tuple[np.ndarray, np.ndarray, np.ndarray]


@dataclass(frozen=True, eq=False)
class Bank:
    """Gaussians over the properties' coordinates, one per hypothesis.

    Attributes:
        log_weight: normalised log probabilities, shape (K,).
        mean: shape (K, d).
        variance: shape (K, d).
        joint: covariance, shape (K, d, d), or None while all properties are independent given the class.
        origin: hypothesis of the network that every row comes from, shape (K,); None where it is its own.
    """

    log_weight: np.ndarray
    mean: np.ndarray
    variance: np.ndarray
    joint: np.ndarray | None = None
    origin: np.ndarray | None = None

    @property
    def covariance(self) -> np.ndarray:
        """Covariance of the coordinates, shape (K, d, d)."""
        if self.joint is not None:
            return self.joint
        return np.asarray(self.variance[:, :, None] * np.eye(self.variance.shape[1]))

    @property
    def weight(self) -> np.ndarray:
        """Probabilities of the hypotheses, shape (K,)."""
        weight = np.exp(self.log_weight)
        return np.asarray(weight / weight.sum())


@dataclass(frozen=True, eq=False)
class Predictive:
    """What a noiseless reading of a quantity would be under every hypothesis.

    Attributes:
        mean: mean of t, shape (K,).
        variance: variance of t, shape (K,).
        link: ``linear`` if the quantity is t, ``log`` if it is exp(t).
        exact: False where a product of linear properties was matched by its first two moments.
    """

    mean: np.ndarray
    variance: np.ndarray
    link: str
    exact: bool = True


def predictive(network: Network, bank: Bank, quantity: str) -> Predictive:
    """Return the distribution of a property or relation under every hypothesis.

    Raises:
        UnknownName: if the network has no such quantity.
    """
    relation = network.relation(quantity)
    if relation is None:
        i = network.index(quantity)
        return Predictive(bank.mean[:, i], bank.variance[:, i], network.properties[i].scale)
    index, power = direction(network, quantity)
    if all(network.properties[i].scale == LOG for i in index) or relation.kind == "sum":
        link = "linear" if relation.kind == "sum" else "log"
        covariance = bank.covariance[:, index[:, None], index]
        variance = np.einsum("kij,i,j->k", covariance, power, power)
        return Predictive(bank.mean[:, index] @ power, np.maximum(variance, 0.0), link)
    index = linear_first(network, index)
    log = network.properties[index[1]].scale == LOG
    mean, variance = product_moments(bank.mean[:, index], bank.covariance[:, index[:, None], index], log)
    return Predictive(mean, variance, "linear", exact=False)


def direction(network: Network, relation: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the coordinates that a relation joins and their exponents or coefficients."""
    found = network.relation(relation)
    assert found is not None
    index = np.array([network.index(name) for name, _ in found.terms])
    return index, np.array([value for _, value in found.terms])


def linear_first(network: Network, index: np.ndarray) -> np.ndarray:
    """Return two coordinates with one on the linear scale in front."""
    return index[::-1] if network.properties[index[0]].scale == LOG else index


def condition_property(
    network: Network, quantity: str, mean: np.ndarray, variance: np.ndarray, z: float, sd: float
) -> Scalar:
    """Condition one property's coordinate on a reading: log evidence, mean, variance, each (K,)."""
    rule: Callable[..., Scalar] = condition_linear
    if network.property(quantity).scale == LOG:
        rule = condition_exponential
    return rule(mean, variance, z, sd)
