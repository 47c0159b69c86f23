"""What a sensor may say before it is asked: the density of its reading under every hypothesis."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from estimation.bank import Bank, Predictive, direction, linear_first, predictive
from estimation.network import CATEGORY, LOG, MATERIAL, Network
from estimation.sensor import ClassSensor, Sensor
from selection.log_density import log_columns
from selection.quadrature import mixture_nodes

_HALF_LN_2PIE = 0.5 * math.log(2 * math.pi * math.e)
_SPLIT = np.linspace(-4.0, 4.0, 17)  # half a standard deviation apart: exact to 1e-8 when each keeps half


@dataclass(frozen=True, eq=False)
class Channel:
    """P(reading | hypothesis) on quadrature nodes; hypotheses with equal columns share a component.

    Attributes:
        values: the readings, shape (N,) [SI unit]; indices of the outcomes for a classifier.
        weights: quadrature weights, shape (N,); ones for a classifier.
        columns: density of the reading per component, shape (N, U).
        component: component of every hypothesis, shape (K,).
        column_entropy: entropy of every column [nats], shape (U,).
        noise_entropy: entropy that remains when the true value is known [nats], shape (U,).
    """

    values: np.ndarray
    weights: np.ndarray
    columns: np.ndarray
    component: np.ndarray
    column_entropy: np.ndarray
    noise_entropy: np.ndarray


def channel(network: Network, bank: Bank, sensor: Sensor | ClassSensor, per_sd: float = 4.0) -> Channel:
    """Return what a sensor may say under every hypothesis of a bank.

    Args:
        network: the reference.
        bank: the hypotheses.
        sensor: the sensor.
        per_sd: quadrature steps per smallest width.

    Raises:
        UnknownName: if the network has no such quantity or variable.
    """
    if isinstance(sensor, ClassSensor):
        return _class_channel(network, bank, sensor)
    found, component = _components(network, bank, sensor.property)
    if found.link == LOG:
        return _log_channel(found, component, sensor, per_sd)
    if not found.exact:
        return _summed_channel(_product_parts(network, bank, sensor), component, per_sd)
    if sensor.relative_sd > 0:
        return _summed_channel(_relative_parts(found, sensor), component, per_sd)
    return _gaussian_channel(found, component, sensor, per_sd)


def _components(network: Network, bank: Bank, quantity: str) -> tuple[Predictive, np.ndarray]:
    """Return the distinct predictives of a quantity and which one every hypothesis has."""
    found = predictive(network, bank, quantity)
    count = len(bank.mean)
    if bank.joint is not None or bank.origin is not None or quantity not in network.property_names:
        return found, np.arange(count)
    parent = network.property(quantity).parent
    rows = {MATERIAL: network.hypotheses.material, CATEGORY: network.hypotheses.category}
    group = rows.get(parent or "", np.zeros(count, dtype=int))
    first, component = np.unique(group, return_index=True, return_inverse=True)[1:]
    if parent is None and np.ptp(found.mean) + np.ptp(found.variance) > 0:
        return found, np.arange(count)
    return Predictive(found.mean[first], found.variance[first], found.link, found.exact), component


def _class_channel(network: Network, bank: Bank, sensor: ClassSensor) -> Channel:
    classes = network.classes(sensor.variable)
    rows = network.hypotheses.category if sensor.variable == CATEGORY else network.hypotheses.material
    rows = rows if bank.origin is None else rows[bank.origin]
    columns = sensor.matrix
    if len(classes) > columns.shape[1]:
        columns = np.column_stack([columns, columns.mean(axis=1)])
    own = -np.sum(columns * np.log(np.where(columns > 0, columns, 1.0)), axis=0)
    count = len(columns)
    return Channel(np.arange(count), np.ones(count), columns, rows, own, own)


def _gaussian_channel(found: Predictive, component: np.ndarray, sensor: Sensor, per_sd: float) -> Channel:
    noise = max(sensor.sd, 1e-9 * float(np.max(np.abs(found.mean)) + math.sqrt(np.max(found.variance))))
    total = np.sqrt(found.variance + noise**2)
    z, weights = mixture_nodes(found.mean, total, per_sd)
    columns = _normal(z[:, None], found.mean, total)
    flat = np.full(len(total), _HALF_LN_2PIE + math.log(noise))
    return Channel(z, weights, columns, component, _HALF_LN_2PIE + np.log(total), flat)


@dataclass(frozen=True, eq=False)
class _Parts:
    """Densities as sums of Gaussians: shares (J,), means, sds and noise sds (U, J)."""

    shares: np.ndarray
    means: np.ndarray
    sds: np.ndarray
    noise: np.ndarray


def _relative_parts(found: Predictive, sensor: Sensor) -> _Parts:
    """Return a property read with proportional noise."""
    sd = np.sqrt(found.variance)[:, None]
    centre = found.mean[:, None] + sd * math.sqrt(0.75) * _SPLIT
    noise = np.hypot(sensor.sd, sensor.relative_sd * centre)
    return _Parts(_split_weights(), centre, np.hypot(0.5 * sd, noise), noise)


def _product_parts(network: Network, bank: Bank, sensor: Sensor) -> _Parts:
    """Return the reading of a product of two properties."""
    index = linear_first(network, direction(network, sensor.property)[0])
    mean, block = bank.mean[:, index], bank.covariance[:, index[:, None], index]
    v_b = block[:, 1, 1]
    slope = (block[:, 0, 1] / v_b)[:, None]
    inner = np.maximum(block[:, 0, 0][:, None] - slope**2 * v_b[:, None], 0.0)
    shift = np.sqrt(0.75 * v_b)[:, None] * _SPLIT
    log = network.properties[index[1]].scale == LOG
    b = mean[:, 1:] + shift
    rest = 0.25 * v_b[:, None]
    g, tangent = (np.exp(b), np.exp(b)) if log else (b, np.ones_like(b))
    a = mean[:, :1] + slope * shift
    centre = g * a
    own = g**2 * inner + (tangent * a + g * slope) ** 2 * rest
    noise = np.hypot(sensor.sd, sensor.relative_sd * centre)
    return _Parts(_split_weights(), centre, np.sqrt(own + noise**2), noise)


def _split_weights() -> np.ndarray:
    weights = np.exp(-0.5 * _SPLIT**2)
    return np.asarray(weights / weights.sum())


def _summed_channel(parts: _Parts, component: np.ndarray, per_sd: float) -> Channel:
    z, weights = mixture_nodes(parts.means.ravel(), parts.sds.ravel(), per_sd)
    columns = np.empty((len(z), len(parts.means)))
    for u in range(len(parts.means)):
        columns[:, u] = _normal(z[:, None], parts.means[u], parts.sds[u]) @ parts.shares
    remaining = _HALF_LN_2PIE + np.log(np.maximum(parts.noise, 1e-300)) @ parts.shares
    return Channel(z, weights, columns, component, _column_entropy(columns, weights), remaining)


def _log_channel(found: Predictive, component: np.ndarray, sensor: Sensor, per_sd: float) -> Channel:
    """Return the channel of z = exp(t) + noise, on nodes that are even in asinh(z / c)."""
    mean, sd = found.mean, np.sqrt(found.variance)
    centre = np.exp(mean)
    noise = np.hypot(np.maximum(sensor.sd, 1e-9 * centre), sensor.relative_sd * centre)
    knee = float(np.min(noise))
    width = np.sqrt(centre**2 * found.variance + noise**2) / np.sqrt(centre**2 + knee**2)
    edges = np.stack([mean - 6.5 * sd, mean + 6.5 * sd])
    reach = 6.5 * np.hypot(sensor.sd, sensor.relative_sd * np.exp(edges))
    ends = np.arcsinh(np.array([np.min(np.exp(edges) - reach), np.max(np.exp(edges) + reach)]) / knee)
    y, step = mixture_nodes(np.arcsinh(centre / knee), np.minimum(width, 1.0), per_sd, ends=ends)
    z, weights = knee * np.sinh(y), step * knee * np.cosh(y)
    columns = log_columns(mean, found.variance, z, max(sensor.sd, 1e-9 * float(centre.min())), sensor.relative_sd)
    columns /= weights @ columns
    nodes = mean[:, None] + sd[:, None] * _SPLIT
    log_noise = np.log(np.hypot(max(sensor.sd, 1e-300), sensor.relative_sd * np.exp(nodes)))
    remaining = _HALF_LN_2PIE + log_noise @ _split_weights()
    return Channel(z, weights, columns, component, _column_entropy(columns, weights), remaining)


def _column_entropy(columns: np.ndarray, weights: np.ndarray) -> np.ndarray:
    return np.asarray(-(weights @ (columns * np.log(np.maximum(columns, 1e-300)))))


def _normal(z: np.ndarray, mean: np.ndarray, sd: np.ndarray) -> np.ndarray:
    inverse = math.sqrt(0.5) / sd
    scaled = z * inverse
    scaled -= mean * inverse
    scaled *= scaled
    np.negative(scaled, out=scaled)
    np.exp(scaled, out=scaled)
    scaled *= inverse / math.sqrt(math.pi)
    return scaled
