"""Exact mutual information for many beliefs at once: `information_gain`, an array axis longer."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from dynamics.errors import InvalidInput, UnknownName
from estimation.network import BOTH, CATEGORY, EVERYTHING, MATERIAL
from estimation.sensor import ClassSensor, Sensor
from selection.information import AnySensor, targets
from selection.quadrature import REACH
from selection.trials.beliefs import Beliefs, check_linear

_HALF_LN_2PIE = 0.5 * math.log(2 * math.pi * math.e)
_PER_SD = 4.0  # nodes per smallest width: an error of about 1e-13
_HELD_PER_SD, _HELD_REACH = 1.25, 5.5  # the same for a property that is held, as `given_property` has them
_SMALLEST = 1e-12  # mass that no longer counts there
_AT_ONCE = 200_000  # numbers in the largest array of a block: about what a core's cache holds
_MOST_NODES = 1 << 16


@dataclass(frozen=True, eq=False)
class _Channels:
    """P(reading | class of the sensor's parent) on nodes, n = 1 where all beliefs share them.

    Attributes:
        weights: quadrature weights, shape (n, V).
        columns: densities, shape (n, V, U).
        parent: class index of every hypothesis, shape (K,).
        column_entropy, noise_entropy: [nats], shape (n, U).
    """

    weights: np.ndarray
    columns: np.ndarray
    parent: np.ndarray
    column_entropy: np.ndarray
    noise_entropy: np.ndarray


def information_gains(
    beliefs: Beliefs, sensor: AnySensor, target: str = MATERIAL, rows: np.ndarray | None = None
) -> np.ndarray:
    """Return I(target; z) of a sensor's reading for many beliefs, in bits.

    Args:
        beliefs: what is known so far.
        sensor: of a property on the linear scale with constant noise, or a classifier.
        target: as for `information_gain`.
        rows: which beliefs; all if None.

    Returns:
        Gains, shape (n,).

    Raises:
        InvalidInput: if the sensor's noise or quantity has no closed form here.
        UnknownName: if the target or the quantity is not known.
    """
    network = beliefs.network
    if target not in targets(network):
        raise UnknownName("target", target, targets(network))
    rows = np.arange(len(beliefs)) if rows is None else rows
    found = np.zeros(len(rows))
    if isinstance(sensor, Sensor):
        check_linear(network, sensor.property)
        if sensor.relative_sd > 0:
            raise InvalidInput(f"many beliefs: noise of {sensor.property}", sensor.relative_sd, "no relative part")
        fresh = ~beliefs.is_read(sensor.property, rows)
    else:
        fresh = np.ones(len(rows), dtype=bool)
    for shared, group in ((True, np.flatnonzero(fresh)), (False, np.flatnonzero(~fresh))):
        if len(group):
            found[group] = _group_gains(beliefs, sensor, target, rows[group], shared)
    return np.maximum(found, 0.0) / math.log(2)


def _group_gains(beliefs: Beliefs, sensor: AnySensor, target: str, rows: np.ndarray, shared: bool) -> np.ndarray:
    """Return gains in nats, of beliefs that share a channel (none has read the property) or that do not."""
    network = beliefs.network
    own = isinstance(sensor, Sensor) and target == sensor.property
    held = target if target in network.property_names and not own else None
    if shared and (held is None or not beliefs.is_read(held, rows).any()):
        # the first step of a trial: all that is known is the prior, one result serves all
        first, same = np.unique(beliefs.weights(rows), axis=0, return_index=True, return_inverse=True)[1:]
        if len(first) < len(rows):
            return np.asarray(_group_gains(beliefs, sensor, target, rows[first], shared)[same.ravel()])
    found = np.empty(len(rows))
    common = _channels(beliefs, sensor, rows[:1]) if shared else None
    for part in _blocks(beliefs, sensor, target, held, rows):
        channels = common or _channels(beliefs, sensor, rows[part])
        found[part] = _gains(beliefs, channels, EVERYTHING if own else target, held, rows[part])
    return found


def _gains(beliefs: Beliefs, channels: _Channels, target: str, held: str | None, rows: np.ndarray) -> np.ndarray:
    weight = beliefs.weights(rows)
    count = channels.columns.shape[2]
    own = weight @ np.eye(count)[channels.parent]
    whole = _entropies(channels, own[:, :, None])
    if target == EVERYTHING:
        return np.asarray(whole - np.sum(own * channels.noise_entropy, axis=1))
    if held is not None:
        mass, joint = _held(beliefs, held, channels, weight, rows)
        return np.asarray(whole - _entropies(channels, joint.transpose(0, 2, 1)) - _of_shares(mass))
    group = _target_rows(beliefs, target)
    pairs = group * count + channels.parent
    used = np.unique(pairs)
    if len(used) == group.max() + 1:  # each class of the target has a single column
        return np.asarray(whole - np.sum(own * channels.column_entropy, axis=1))
    joint = weight @ np.eye((group.max() + 1) * count)[pairs]
    joint = joint.reshape(len(rows), -1, count)
    return np.asarray(whole - _entropies(channels, joint.transpose(0, 2, 1)) - _of_shares(joint.sum(axis=2)))


def _target_rows(beliefs: Beliefs, target: str) -> np.ndarray:
    if target == BOTH:
        return np.arange(len(beliefs.network.hypotheses.material))
    return beliefs.rows_of({MATERIAL: MATERIAL, CATEGORY: CATEGORY}[target])


def _held(
    beliefs: Beliefs, held: str, channels: _Channels, weight: np.ndarray, rows: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the masses of a held property's nodes (n, J), and with the sensor's classes (n, J, U)."""
    parent = beliefs.rows_of(beliefs.network.property(held).parent)
    mean, variance = beliefs.moments(held, rows)
    sd = np.sqrt(variance)
    used = (weight > _SMALLEST) @ np.eye(mean.shape[1])[parent] > 0
    nodes, step = _nodes(mean, sd, _HELD_PER_SD, _HELD_REACH, used)
    scaled = (nodes[:, :, None] - mean[:, None, :]) / sd[:, None, :]
    density = step[:, :, None] * np.exp(-0.5 * scaled**2) / (sd[:, None, :] * math.sqrt(2 * math.pi))
    groups, count = mean.shape[1], channels.columns.shape[2]
    pairs = weight @ np.eye(groups * count)[parent * count + channels.parent]
    pairs = pairs.reshape(len(rows), groups, count)
    mass = density * pairs.sum(axis=2)[:, None, :]
    density[mass <= _SMALLEST] = 0.0
    joint = density @ pairs
    total = joint.sum(axis=(1, 2), keepdims=True)
    joint /= total
    return joint.sum(axis=2), joint


def _entropies(channels: _Channels, shares: np.ndarray) -> np.ndarray:
    """Return -sum_t integral f_t ln f_t, f_t = sum_u shares_ut column_u, of shares (n, U, T): shape (n,)."""
    density = channels.columns @ shares
    terms = np.log(np.maximum(density, 1e-300))
    terms *= density
    return np.asarray(-np.einsum("nvt,nv->n", terms, np.broadcast_to(channels.weights, density.shape[:2])))


def _of_shares(shares: np.ndarray) -> np.ndarray:
    """Return sum_t p_t ln p_t, shape (n, T) -> (n,)."""
    return np.asarray(np.sum(shares * np.log(np.maximum(shares, 1e-300)), axis=1))


def _channels(beliefs: Beliefs, sensor: AnySensor, rows: np.ndarray) -> _Channels:
    if isinstance(sensor, ClassSensor):
        columns = beliefs.likelihoods(sensor)
        own = -np.sum(columns * np.log(np.where(columns > 0, columns, 1.0)), axis=0)[None]
        parent = beliefs.rows_of(sensor.variable)
        return _Channels(np.ones((1, len(columns))), columns[None], parent, own, own)
    mean, variance = beliefs.moments(sensor.property, rows)
    noise = max(sensor.sd, 1e-9 * float(np.max(np.abs(mean)) + math.sqrt(np.max(variance))))
    total = np.sqrt(variance + noise**2)
    z, weights = _nodes(mean, total, _PER_SD, REACH)
    inverse = math.sqrt(0.5) / total
    scaled = z[:, :, None] * inverse[:, None, :]
    scaled -= (mean * inverse)[:, None, :]
    scaled *= scaled
    np.negative(scaled, out=scaled)
    np.exp(scaled, out=scaled)
    scaled *= (inverse / math.sqrt(math.pi))[:, None, :]
    parent = beliefs.rows_of(beliefs.network.property(sensor.property).parent)
    flat = np.full_like(total, _HALF_LN_2PIE + math.log(noise))
    return _Channels(weights, scaled, parent, _HALF_LN_2PIE + np.log(total), flat)


def _nodes(
    mean: np.ndarray, sd: np.ndarray, per_sd: float, reach: float, used: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes and weights of a trapezoid rule per row, each (n, V).

    Args:
        mean, sd: of the components, shape (n, U).
        per_sd: nodes per smallest width, at least.
        reach: widths covered on both sides.
        used: components that count, shape (n, U), each row then with as many nodes as it needs itself, the
            others of weight zero; all rows with as many as the widest needs if None.

    Raises:
        InvalidInput: if the widths differ so much that the rule would take too many nodes.
    """
    taken = np.ones(mean.shape, dtype=bool) if used is None else used
    low = np.min(mean - reach * sd, axis=1, where=taken, initial=np.inf)
    high = np.max(mean + reach * sd, axis=1, where=taken, initial=-np.inf)
    finest = np.min(sd, axis=1, where=taken, initial=np.inf) / per_sd
    number = np.ceil((high - low) / finest).astype(np.int64) + 1
    most = int(number.max())
    if most > _MOST_NODES:
        raise InvalidInput("many beliefs: quadrature nodes", most, f"widths that take at most {_MOST_NODES}")
    steps = (high - low) / ((most if used is None else number) - 1)
    index = np.arange(most)
    inside = (index < number[:, None]) | (used is None)
    return low[:, None] + steps[:, None] * index, np.where(inside, steps[:, None], 0.0)


def _blocks(
    beliefs: Beliefs, sensor: AnySensor, target: str, held: str | None, rows: np.ndarray
) -> Iterator[slice]:
    """Yield parts of the rows whose arrays fit into memory, and better into the cache."""
    width = 1
    if isinstance(sensor, Sensor):
        mean, variance = beliefs.moments(sensor.property, rows)
        sd = np.sqrt(variance + sensor.sd**2)
        reach = np.max(mean + REACH * sd, axis=1) - np.min(mean - REACH * sd, axis=1)
        width = int(np.max(_PER_SD * reach / sd.min(axis=1))) + 1
    if held is not None:
        mean, variance = beliefs.moments(held, rows)
        sd = np.sqrt(variance)
        reach = np.max(mean, axis=1) - np.min(mean, axis=1) + 2 * _HELD_REACH * sd.max(axis=1)
        width *= int(np.max(_HELD_PER_SD * reach / sd.min(axis=1))) + 2
    else:
        width *= len(beliefs.network.classes(target)) if target in beliefs.network.variables else 16
    size = max(1, _AT_ONCE // max(width, 1))
    for start in range(0, len(rows), size):
        yield slice(start, start + size)
