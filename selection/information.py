"""How much a reading is expected to teach: exact mutual information in bits."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dynamics.errors import InvalidInput, UnknownName
from estimation.bank import Bank
from estimation.belief import Belief
from estimation.network import BOTH, CATEGORY, EVERYTHING, MATERIAL, Network
from estimation.sensor import ClassSensor, Sensor
from selection.channel import Channel, channel
from selection.expansion import given_property, independent
from selection.quadrature import entropy

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


def information_gain(belief: Belief, sensors: AnySensor | Sequence[AnySensor], target: str = MATERIAL) -> float:
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
    network = belief.network
    readings = _readings(network, belief.bank, group)
    whole = readings.entropy()
    if target == EVERYTHING:
        remaining = readings.noise_entropy()
    elif target in network.property_names:
        held, value = given_property(belief.bank, network.index(target))
        readings = _readings(network, held, group)
        remaining = readings.entropy_given(value[readings.parent])
    else:
        bank = network.hypotheses
        rows = {MATERIAL: bank.material, CATEGORY: bank.category}.get(target, np.arange(len(bank.material)))
        remaining = readings.entropy_given(rows[readings.parent])
    return max(whole - remaining, 0.0) / math.log(2)


def split(belief: Belief, sensors: AnySensor | Sequence[AnySensor]) -> Split:
    """Return how the information of a reading divides into classes and properties.

    Raises:
        UnknownName: if a quantity or a variable is not known.
    """
    target = BOTH if belief.network.categories else MATERIAL
    classes = information_gain(belief, sensors, target)
    return Split(classes, max(information_gain(belief, sensors, EVERYTHING) - classes, 0.0))


@dataclass(frozen=True, eq=False)
class _Readings:
    """The joint reading of some sensors, independent of each other under every row.

    Attributes:
        channels: one per sensor.
        weight: probabilities of the rows, shape (R,).
        parent: the row of the bank that every row comes from, shape (R,).
    """

    channels: tuple[Channel, ...]
    weight: np.ndarray
    parent: np.ndarray

    def entropy(self) -> float:
        """Return the entropy of the joint reading [nats]."""
        return self._of(np.arange(len(self.weight)), self.weight)

    def noise_entropy(self) -> float:
        """Return the entropy of the joint reading when every true value is known [nats]."""
        return sum(float(self.weight @ c.noise_entropy[c.component]) for c in self.channels)

    def entropy_given(self, group: np.ndarray) -> float:
        """Return the mean entropy of the joint reading when a row's group is known [nats].

        Args:
            group: index of every row's group, shape (R,).
        """
        pure = self._pure(group)
        alone = sum(c.column_entropy[c.component] for c in self.channels)
        remaining = float(np.sum((self.weight * alone)[pure[group]]))
        mixed = np.flatnonzero(~pure[group] & (self.weight > 0))
        if len(mixed) == 0:
            return remaining
        mixed = mixed[np.argsort(group[mixed], kind="stable")]
        starts = np.flatnonzero(np.append(True, np.diff(group[mixed]) > 0))
        share = np.add.reduceat(self.weight[mixed], starts)
        if len(self.channels) == 1:
            return remaining + self._groups_of_one(mixed, starts, share)
        for rows, part in zip(np.split(mixed, starts[1:]), share.tolist(), strict=True):
            remaining += part * self._of(rows, self.weight[rows] / part)
        return remaining

    def _groups_of_one(self, rows: np.ndarray, starts: np.ndarray, share: np.ndarray) -> float:
        """Return the summed entropies of the groups' readings, times their shares, of a single sensor."""
        only = self.channels[0]
        density = np.add.reduceat(only.columns[:, only.component[rows]] * self.weight[rows], starts, axis=1)
        density /= share
        return entropy(density * share, only.weights[:, None]) + float(
            np.sum((only.weights @ density) * share * np.log(share))
        )

    def _pure(self, group: np.ndarray) -> np.ndarray:
        """Return which groups have one and the same component in every channel, shape (groups,)."""
        count = int(group.max()) + 1
        pure = np.ones(count, dtype=bool)
        for part in self.channels:
            lowest, highest = np.full(count, np.iinfo(np.int64).max), np.full(count, -1)
            np.minimum.at(lowest, group, part.component)
            np.maximum.at(highest, group, part.component)
            pure &= (lowest == highest) | (highest < 0)
        return pure

    def _of(self, rows: np.ndarray, weight: np.ndarray) -> float:
        """Return the entropy of the joint reading over some rows with these weights [nats]."""
        if len(self.channels) == 1:
            only = self.channels[0]
            mixed = np.bincount(only.component[rows], weights=weight, minlength=only.columns.shape[1])
            return entropy(only.columns @ mixed, only.weights)
        left, nodes = weight[None, :], np.ones(1)
        for part in self.channels[:-1]:
            column = part.columns[:, part.component[rows]]
            left = (left[:, None, :] * column[None, :, :]).reshape(-1, len(rows))
            nodes = (nodes[:, None] * part.weights[None, :]).ravel()
        last = self.channels[-1]
        return entropy(left @ last.columns[:, last.component[rows]].T, nodes[:, None] * last.weights)


def _readings(network: Network, bank: Bank, sensors: Sequence[AnySensor]) -> _Readings:
    expanded, parent = (bank, np.arange(len(bank.mean)))
    if len(sensors) > 1:
        expanded, parent = independent(network, bank, sensors)
    per_sd = {1: 4.0, 2: 2.0}.get(len(sensors), 1.0)
    channels = tuple(channel(network, expanded, sensor, per_sd) for sensor in sensors)
    size = math.prod(len(c.values) for c in channels)
    if len(channels) > 1 and size > _LARGEST:
        raise InvalidInput("joint reading", size, f"sensors with at most {_LARGEST} joint nodes")
    return _Readings(channels, expanded.weight, parent)
