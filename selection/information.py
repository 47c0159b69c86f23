"""How much a reading is expected to teach: exact mutual information in bits."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dynamics.errors import InvalidInput, UnknownName
from estimation.belief import Belief
from estimation.network import CATEGORY, MATERIAL, Network
from estimation.sensor import ClassSensor, Sensor
from selection.channel import Channel, channel
from selection.quadrature import entropy

BOTH, EVERYTHING = "both", "everything"
AnySensor = Sensor | ClassSensor
_LARGEST = 2_000_000


@dataclass(frozen=True)
class Split:
    """Where the information of a reading goes: I(all; z) = I(class; z) + I(properties; z | class).

    Attributes:
        classes: I(material and category; z) [bits].
        properties: I(properties; z | material and category) [bits].
    """

    classes: float
    properties: float

    @property
    def total(self) -> float:
        """I(everything; z) [bits]."""
        return self.classes + self.properties


def targets(network: Network) -> tuple[str, ...]:
    """List what a plan can be about: the variables, both of them, a property, or everything."""
    both = (BOTH,) if network.categories else ()
    return (*network.variables, *both, *network.property_names, EVERYTHING)


def information_gain(
    belief: Belief, sensors: AnySensor | Sequence[AnySensor], target: str = MATERIAL
) -> float:
    """Return I(target; z) = [h(z) - E h(z | target)] / ln 2, the expected information of a reading in bits.

    Several sensors are read together: the gain is that of their joint reading.

    Args:
        belief: what is known so far.
        sensors: the sensor, or the sensors of one action.
        target: ``material``, ``category``, ``both``, the name of a property, or ``everything``.

    Raises:
        UnknownName: if the target, a quantity or a variable is not known.
    """
    group = (sensors,) if isinstance(sensors, (Sensor, ClassSensor)) else tuple(sensors)
    if target not in targets(belief.network):
        raise UnknownName("target", target, targets(belief.network))
    if not group:
        return 0.0
    weight = belief.bank.weight
    channels = _channels(belief, group)
    whole = _entropy(channels, weight)
    if target == EVERYTHING:
        remaining = sum(float(weight @ c.noise_entropy[c.component]) for c in channels)
    elif target in belief.network.property_names:
        remaining = _given_property(belief, group, target)
    else:
        remaining = _given_class(belief, channels, weight, target)
    return max(whole - remaining, 0.0) / math.log(2)


def split(belief: Belief, sensors: AnySensor | Sequence[AnySensor]) -> Split:
    """Return how the information of a reading divides into classes and properties.

    Raises:
        UnknownName: if a quantity or a variable is not known.
    """
    target = BOTH if belief.network.categories else MATERIAL
    classes = information_gain(belief, sensors, target)
    return Split(classes, max(information_gain(belief, sensors, EVERYTHING) - classes, 0.0))


def _channels(belief: Belief, sensors: Sequence[AnySensor]) -> tuple[Channel, ...]:
    per_sd = {1: 4.0, 2: 2.0}.get(len(sensors), 1.0)
    return tuple(channel(belief.network, belief.bank, sensor, per_sd) for sensor in sensors)


def _entropy(channels: Sequence[Channel], weight: np.ndarray) -> float:
    """Return the entropy of the joint reading for these weights of the hypotheses [nats]."""
    if len(channels) == 1:
        only = channels[0]
        mixed = np.bincount(only.component, weights=weight, minlength=only.columns.shape[1])
        return entropy(only.columns @ mixed, only.weights)
    used = weight > 0
    size = math.prod(len(c.values) for c in channels)
    if size > _LARGEST:
        raise InvalidInput("joint reading", size, f"sensors with at most {_LARGEST} joint nodes")
    left = weight[used][None, :]
    nodes = np.ones(1)
    for part in channels[:-1]:
        column = part.columns[:, part.component[used]]
        left = (left[:, None, :] * column[None, :, :]).reshape(-1, left.shape[1])
        nodes = (nodes[:, None] * part.weights[None, :]).ravel()
    last = channels[-1]
    density = left @ last.columns[:, last.component[used]].T
    return entropy(density, nodes[:, None] * last.weights)


def _given_class(belief: Belief, channels: Sequence[Channel], weight: np.ndarray, target: str) -> float:
    """Return the entropy of the joint reading that remains when the class is known [nats]."""
    bank = belief.network.hypotheses
    rows = {MATERIAL: bank.material, CATEGORY: bank.category, BOTH: np.arange(len(weight))}[target]
    pure = _pure(rows, channels)
    alone = sum(c.column_entropy[c.component] for c in channels)
    remaining = float(np.sum((weight * alone)[pure[rows]]))
    for row in np.flatnonzero(~pure):
        own = np.where(rows == row, weight, 0.0)
        share = float(own.sum())
        if share > 0:
            remaining += share * _entropy(channels, own / share)
    return remaining


def _pure(rows: np.ndarray, channels: Sequence[Channel]) -> np.ndarray:
    """Return which classes have one and the same component in every channel, shape (classes,)."""
    count = int(rows.max()) + 1
    pure = np.ones(count, dtype=bool)
    for part in channels:
        lowest, highest = np.full(count, np.iinfo(np.int64).max), np.full(count, -1)
        np.minimum.at(lowest, rows, part.component)
        np.maximum.at(highest, rows, part.component)
        pure &= (lowest == highest) | (highest < 0)
    return pure


def _given_property(belief: Belief, sensors: Sequence[AnySensor], target: str) -> float:
    """Return the entropy of the joint reading that remains when a property is known [nats]."""
    raise NotImplementedError
