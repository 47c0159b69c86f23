"""Hypotheses with a property held at fixed values: what makes correlated readings independent."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from estimation.bank import Bank, direction
from estimation.network import LOG, Network
from estimation.sensor import ClassSensor, Sensor
from selection.quadrature import mixture_nodes

_REST = 1e-12  # variance that a fixed property keeps, relative to its own
_SMALLEST = 1e-12  # weight below which a hypothesis no longer counts
_REACH = 5.5
_CORRELATED = 1e-6


def hold(bank: Bank, rows: np.ndarray, coordinate: int, values: np.ndarray, log_weight: np.ndarray) -> Bank:
    """Return hypotheses with one coordinate held at a value, the others following by regression.

    Args:
        bank: K hypotheses.
        rows: which of them, shape (P,).
        coordinate: index of the property held.
        values: the coordinate's values, shape (P,).
        log_weight: log weights of the new hypotheses, shape (P,).
    """
    origin = rows if bank.origin is None else bank.origin[rows]
    mean, variance = bank.mean[rows], bank.variance[rows]
    own = variance[:, coordinate]
    if bank.joint is None:
        mean[:, coordinate] = values
        variance[:, coordinate] = own * _REST
        return Bank(log_weight, mean, variance, None, origin)
    joint = bank.joint[rows]
    gain = joint[:, :, coordinate] / own[:, None]
    mean = mean + gain * (values - mean[:, coordinate])[:, None]
    joint = joint - own[:, None, None] * gain[:, :, None] * gain[:, None, :]
    joint[:, coordinate, :] = joint[:, :, coordinate] = 0.0
    joint[:, coordinate, coordinate] = own * _REST
    diagonal = np.maximum(np.einsum("kii->ki", joint), np.finfo(float).tiny)
    return Bank(log_weight, mean, diagonal, joint, origin)


def given_property(bank: Bank, coordinate: int) -> tuple[Bank, np.ndarray]:
    """Return the hypotheses at every value of a property, on a grid of values common to all.

    Returns:
        The bank of pairs (hypothesis, value), weights summing to one, and the index of every pair's value.
    """
    weight = bank.weight
    used = np.flatnonzero(weight > _SMALLEST)
    mean, sd = bank.mean[used, coordinate], np.sqrt(bank.variance[used, coordinate])
    nodes, step = mixture_nodes(mean, sd, per_sd=1.25, reach=_REACH)
    scaled = (nodes[:, None] - mean) / sd
    mass = weight[used] * step[:, None] * np.exp(-0.5 * scaled**2) / (sd * np.sqrt(2 * np.pi))
    group, column = np.nonzero(mass > _SMALLEST)
    mass = mass[group, column] / mass[group, column].sum()
    return hold(bank, used[column], coordinate, nodes[group], np.log(mass)), group


def independent(network: Network, bank: Bank, sensors: Sequence[Sensor | ClassSensor]) -> tuple[Bank, np.ndarray]:
    """Return hypotheses under each of which the sensors' readings are independent.

    Where two sensors share a property, or properties that earlier readings have tied together, that property
    is held at the nodes of a trapezoid rule.

    Returns:
        The bank, and the row of the given one that every new row comes from.
    """
    parents = np.arange(len(bank.mean))
    gauges = [sensor for sensor in sensors if isinstance(sensor, Sensor)]
    held: set[int] = set()
    while (coordinate := _conflict(network, bank, gauges, held)) is not None:
        held.add(coordinate)
        used = np.flatnonzero(bank.weight > _SMALLEST)
        sd = np.sqrt(bank.variance[used, coordinate])
        fine = min(_resolution(network, bank, sensor, coordinate) for sensor in gauges)
        count = int(np.clip(np.ceil(2 * _REACH * sd.max() / (0.8 * fine)), 16, 240)) + 1
        steps = np.linspace(-_REACH, _REACH, count)
        share = np.exp(-0.5 * steps**2)
        rows = np.repeat(used, count)
        values = (bank.mean[used, coordinate][:, None] + sd[:, None] * steps).ravel()
        log_weight = (bank.log_weight[used][:, None] + np.log(share / share.sum())).ravel()
        bank = hold(bank, rows, coordinate, values, log_weight)
        parents = parents[rows]
    return bank, parents


def _coordinates(network: Network, quantity: str) -> set[int]:
    if network.relation(quantity) is None:
        return {network.index(quantity)}
    return set(direction(network, quantity)[0].tolist())


def _conflict(network: Network, bank: Bank, sensors: Sequence[Sensor], held: set[int]) -> int | None:
    """Return a property that ties two sensors together, or None."""
    for i, first in enumerate(sensors):
        for second in sensors[i + 1 :]:
            own = _coordinates(network, first.property) - held
            other = _coordinates(network, second.property) - held
            if own & other:
                return min(own & other)
            if bank.joint is not None:
                for a in own:
                    for b in other:
                        scale = np.sqrt(bank.variance[:, a] * bank.variance[:, b])
                        if np.any(np.abs(bank.joint[:, a, b]) > _CORRELATED * scale):
                            return min(a, b) if len(own) == len(other) else (a if len(own) < len(other) else b)
    return None


def _resolution(network: Network, bank: Bank, sensor: Sensor, coordinate: int) -> float:
    """Return how finely a sensor sees a coordinate: its noise in that coordinate, at the best."""
    if coordinate not in _coordinates(network, sensor.property):
        return float("inf")
    weight = bank.weight
    centre = bank.mean.copy()
    logs = [prop.scale == LOG for prop in network.properties]
    values = np.where(logs, np.exp(np.minimum(centre, 300.0)), centre)
    relation = network.relation(sensor.property)
    if relation is None:
        reading = values[:, coordinate]
        slope = reading if logs[coordinate] else np.ones_like(reading)
    elif relation.kind == "sum":
        slope = np.full(len(values), dict(relation.terms)[network.property_names[coordinate]])
        reading = np.sum([value * values[:, network.index(n)] for n, value in relation.terms], axis=0)
    else:
        reading = np.prod([values[:, network.index(n)] ** power for n, power in relation.terms], axis=0)
        power = dict(relation.terms)[network.property_names[coordinate]]
        slope = power * reading / (1.0 if logs[coordinate] else values[:, coordinate])
    noise = np.hypot(sensor.sd, sensor.relative_sd * reading)
    ratio = noise / np.maximum(np.abs(slope), 1e-300)
    return float(ratio[weight > 1e-6].min())
