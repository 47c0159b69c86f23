"""What a sensor may say before it is asked: the density of its reading under every hypothesis."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from estimation.bank import Bank, Predictive, direction, linear_first, predictive
from estimation.network import CATEGORY, LOG, MATERIAL, Network
from estimation.sensor import ClassSensor, Sensor
from selection.quadrature import PANEL, graded_nodes, mixture_nodes
from selection.reading_density import REACH, reading_columns

_REMEMBERED = 1024  # hypotheses up to which channels are remembered: 64 of them take 100 MB then
_HALF_LN_2PIE = 0.5 * math.log(2 * math.pi * math.e)
_LEAST_NODES, _MOST_NODES = 33, 257
_LEAST_REACH = 5.0
_HELD = 1e5  # widths of a reading that a property's own range is narrower by when it is as good as fixed


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
    if not found.exact:
        return _product_channel(network, bank, sensor, component, per_sd)
    if len(found.mean) > _REMEMBERED:
        return _reading_of(found, component, sensor, per_sd)
    known = _known(found.mean.tobytes(), found.variance.tobytes(), found.link, sensor, per_sd)
    return replace(known, component=component)


@lru_cache(maxsize=64)
def _known(mean: bytes, variance: bytes, link: str, sensor: Sensor, per_sd: float) -> Channel:
    """Return a channel that plans ask for again and again: a reading changes few of them."""
    found = Predictive(np.frombuffer(mean), np.frombuffer(variance), link)
    made = _reading_of(found, np.arange(len(found.mean)), sensor, per_sd)
    for array in (made.values, made.weights, made.columns, made.column_entropy, made.noise_entropy):
        array.setflags(write=False)
    return made


forget = _known.cache_clear
"""Drop the channels that are remembered; for measuring times."""


def _reading_of(found: Predictive, component: np.ndarray, sensor: Sensor, per_sd: float) -> Channel:
    if found.link == LOG or sensor.relative_sd > 0:
        return _value_channel(found, component, sensor, per_sd)
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


def _product_channel(
    network: Network, bank: Bank, sensor: Sensor, component: np.ndarray, per_sd: float
) -> Channel:
    """Return the reading of a product of two properties of which one is on the linear scale.

    With the other one held at nodes the product is on the linear scale too.
    """
    index = linear_first(network, direction(network, sensor.property)[0])
    mean, block = bank.mean[:, index], bank.covariance[:, index[:, None], index]
    v_b = block[:, 1, 1]
    slope = (block[:, 0, 1] / v_b)[:, None]
    inner = np.maximum(block[:, 0, 0][:, None] - slope**2 * v_b[:, None], 0.0)
    log = network.properties[index[1]].scale == LOG

    def given(steps: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return means and variances of the product, and the widths of its reading for a change of b by its sd."""
        b = mean[:, 1:] + np.sqrt(v_b)[:, None] * steps
        g, tangent = (np.exp(b), np.exp(b)) if log else (b, np.ones_like(b))
        a = mean[:, :1] + slope * (b - mean[:, 1:])
        centre, variance = g * a, g**2 * inner
        wide = np.sqrt(variance + sensor.sd**2 + (sensor.relative_sd * centre) ** 2)
        change = np.abs(tangent * a + g * slope) * np.sqrt(v_b)[:, None]
        return centre, np.maximum(variance, 1e-18 * wide**2), wide / np.maximum(change, 1e-300)

    # Nodes may lie no further apart than their readings are wide.
    ratio = float(np.min(given(np.linspace(-_LEAST_REACH, _LEAST_REACH, _LEAST_NODES))[2]))
    count = int(np.clip(2 * REACH / (0.8 * ratio), _LEAST_NODES, _MOST_NODES)) | 1
    steps, shares = _nodes(1 if ratio > _HELD else count)
    centre, variance, _ = given(steps)
    every = _value_channel(Predictive(centre.ravel(), variance.ravel(), "linear"), component, sensor, per_sd)
    columns = every.columns.reshape(len(every.values), -1, len(shares)) @ shares
    remaining = every.noise_entropy.reshape(-1, len(shares)) @ shares
    return Channel(
        every.values, every.weights, columns, component, _column_entropy(columns, every.weights), remaining
    )


def _nodes(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes of the standard normal distribution and their weights."""
    steps = np.linspace(-REACH, REACH, count) if count > 1 else np.zeros(1)
    weights = np.exp(-0.5 * steps**2)
    return steps, weights / weights.sum()


def _value_channel(found: Predictive, component: np.ndarray, sensor: Sensor, per_sd: float) -> Channel:
    """Return the channel of a reading whose noise, or whose scale, depends on the value."""
    log = found.link == LOG
    mean, sd = found.mean, np.sqrt(found.variance)
    reached = np.stack([mean - REACH * sd, mean + REACH * sd])
    edges = np.exp(np.clip(reached, -300, 300)) if log else reached
    size = np.exp(np.clip(mean, -300, 300)) if log else np.abs(mean) + sd
    constant = max(sensor.sd, 1e-9 * float(size.min()))
    reach = REACH * np.hypot(constant, sensor.relative_sd * edges)
    # Noise that is proportional to large values reaches below small ones.
    low, high = (edges - reach).min(axis=0), (edges + reach).max(axis=0)
    panel = PANEL * 4 / per_sd
    if log:
        knee = 2 * max(constant, sensor.relative_sd * float(edges[0].min()))

        def scale(y: np.ndarray, width: np.ndarray) -> np.ndarray:
            value = knee * np.abs(np.sinh(y))
            noise = np.hypot(constant, sensor.relative_sd * value)
            return np.asarray(np.hypot(value * np.minimum(width, 1.0), noise) / np.hypot(value, knee))

        y, step = graded_nodes(np.arcsinh(low / knee), np.arcsinh(high / knee), sd, scale, panel=panel)
        z, weights = knee * np.sinh(y), step * knee * np.cosh(y)
    else:

        def scale(y: np.ndarray, width: np.ndarray) -> np.ndarray:
            return np.asarray(np.hypot(width, np.hypot(constant, sensor.relative_sd * y)))

        turn = constant / sensor.relative_sd if sensor.relative_sd else 0.0
        z, weights = graded_nodes(low, high, sd, scale, turn, 0.7 * panel)
    columns = reading_columns(mean, found.variance, z, constant, sensor.relative_sd, found.link)
    columns /= weights @ columns
    steps, shares = _nodes(29)
    nodes = mean[:, None] + sd[:, None] * steps
    value = np.exp(np.minimum(nodes, 300.0)) if log else nodes
    remaining = _HALF_LN_2PIE + np.log(np.hypot(constant, sensor.relative_sd * value)) @ shares
    return Channel(z, weights, columns, component, _column_entropy(columns, weights), remaining)


def _column_entropy(columns: np.ndarray, weights: np.ndarray) -> np.ndarray:
    terms = np.maximum(columns, 1e-300)
    np.log(terms, out=terms)
    terms *= columns
    return np.asarray(-(weights @ terms))


def _normal(z: np.ndarray, mean: np.ndarray, sd: np.ndarray) -> np.ndarray:
    inverse = math.sqrt(0.5) / sd
    scaled = z * inverse
    scaled -= mean * inverse
    scaled *= scaled
    np.negative(scaled, out=scaled)
    np.exp(scaled, out=scaled)
    scaled *= inverse / math.sqrt(math.pi)
    return scaled
