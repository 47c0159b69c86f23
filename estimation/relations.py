"""Conditioning of the bank on a reading of a relation, such as mass = density volume."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from estimation.bank import Bank, Scalar, direction, linear_first
from estimation.conditioning import condition_exponential, condition_linear
from estimation.network import LOG, Network
from estimation.products import condition_product

_NODES = np.linspace(-5.0, 5.0, 17)
_REST = 1e-12


def condition_bank(
    network: Network,
    quantity: str,
    bank: Bank,
    reading: tuple[float, float],
    skewed: Mapping[int, tuple[float, float]],
) -> Bank:
    """Return the bank after a reading of a relation; log weights are not normalised.

    A log-scale property that has a wide reading of its own is far from Gaussian: it is held at quadrature
    nodes of its exact posterior, conditioned at each, and put together again by its first two moments.

    Args:
        network: the reference.
        quantity: the relation read.
        bank: K hypotheses.
        reading: the value and its standard deviation.
        skewed: such properties' coordinates with their own reading.
    """
    split = bank
    for coordinate, own in skewed.items():
        split = _at_nodes(network, split, coordinate, *own)
    evidence, mean, joint = condition_relation(network, quantity, split, *reading)
    log_weight = split.log_weight + evidence
    if skewed:
        log_weight, mean, joint = _together(log_weight, mean, joint, len(bank.mean))
    diagonal = np.maximum(np.einsum("kii->ki", joint), np.finfo(float).tiny)
    return Bank(log_weight, mean, diagonal, joint)


def _at_nodes(network: Network, bank: Bank, coordinate: int, z: float, sd: float) -> Bank:
    """Return every hypothesis with a coordinate held at nodes of its posterior given its own reading."""
    prior = network.hypotheses
    repeats = len(bank.mean) // len(prior.mean)
    centre, spread = bank.mean[:, coordinate], np.sqrt(bank.variance[:, coordinate])
    u = centre[:, None] + spread[:, None] * _NODES
    mean = np.repeat(prior.mean[:, coordinate], repeats)[:, None]
    variance = np.repeat(prior.variance[:, coordinate], repeats)[:, None]
    log = -0.5 * ((u - mean) ** 2 / variance + ((z - np.exp(np.minimum(u, 300.0))) / sd) ** 2)
    log -= log.max(axis=1, keepdims=True)
    log -= np.log(np.exp(log).sum(axis=1, keepdims=True))
    means = np.repeat(bank.mean, len(_NODES), axis=0)
    variances = np.repeat(bank.variance, len(_NODES), axis=0)
    means[:, coordinate] = u.ravel()
    variances[:, coordinate] *= _REST
    return Bank((bank.log_weight[:, None] + log).ravel(), means, variances)


def _together(log_weight: np.ndarray, mean: np.ndarray, joint: np.ndarray, count: int) -> Scalar:
    """Return log weights, means and covariances of the mixtures that equal runs of rows make."""
    log = log_weight.reshape(count, -1)
    top = np.maximum(log.max(axis=1, keepdims=True), -1e300)
    share = np.exp(log - top)
    total = share.sum(axis=1, keepdims=True)
    share = np.where(total > 0, share, 1.0) / np.where(total > 0, total, share.shape[1])
    means = mean.reshape(count, -1, mean.shape[1])
    centre = np.einsum("kj,kji->ki", share, means)
    deviation = means - centre[:, None]
    within = np.einsum("kj,kjab->kab", share, joint.reshape(count, -1, *joint.shape[1:]))
    between = np.einsum("kj,kja,kjb->kab", share, deviation, deviation)
    with np.errstate(divide="ignore"):
        return (top + np.log(total))[:, 0], centre, within + between


def condition_relation(
    network: Network, quantity: str, bank: Bank, z: float, sd: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Condition all coordinates on a reading of a relation.

    The reading informs one or two directions of the coordinates; the others follow by regression, exactly.

    Returns:
        Log evidence (K,), posterior mean (K, d), posterior covariance (K, d, d).
    """
    index, power = direction(network, quantity)
    covariance = bank.covariance
    scales = [network.properties[i].scale for i in index]
    relation = network.relation(quantity)
    assert relation is not None
    if relation.kind == "product" and any(scale != LOG for scale in scales):
        return _condition_two(network, index, bank, z, sd)
    cross = covariance[:, :, index] @ power
    mean = bank.mean[:, index] @ power
    variance = np.maximum(cross[:, index] @ power, np.finfo(float).tiny)
    rule = condition_linear if relation.kind == "sum" else condition_exponential
    evidence, new_mean, new_variance = rule(mean, variance, z, sd)
    gain = cross / variance[:, None]
    shrink = (variance - new_variance)[:, None, None]
    return (
        evidence,
        bank.mean + gain * (new_mean - mean)[:, None],
        covariance - shrink * gain[:, :, None] * gain[:, None, :],
    )


def _condition_two(network: Network, index: np.ndarray, bank: Bank, z: float, sd: float) -> Scalar:
    index = linear_first(network, index)
    covariance = bank.covariance
    block = covariance[:, index[:, None], index]
    log = network.properties[index[1]].scale == LOG
    evidence, mean, spread = condition_product(bank.mean[:, index], block, log, z, sd)
    gain = covariance[:, :, index] @ np.linalg.inv(block)
    shift = np.einsum("kij,kj->ki", gain, mean - bank.mean[:, index])
    change = gain @ (spread - block) @ gain.transpose(0, 2, 1)
    return evidence, bank.mean + shift, covariance + change
