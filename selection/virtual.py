"""Objects drawn from a network and read through its sensor models: explorations without a robot."""

from __future__ import annotations

import numpy as np

from estimation.belief import Belief
from estimation.measurement import Measurement
from estimation.network import CATEGORY, LOG, Network
from estimation.sensor import ClassSensor, Sensor


class VirtualObject:
    """One object with true classes and true property values, the same at every reading.

    Readings of a sensor are numbered: the n-th reading of a name gives the same value whatever was read
    before, so that policies can be compared on the same objects.

    Args:
        network: the reference it is drawn from.
        rng: source of randomness.
        row: hypothesis it is made of; drawn by prior probability if None.
    """

    def __init__(self, network: Network, rng: np.random.Generator, row: int | None = None) -> None:
        self.network = network
        bank = network.hypotheses
        self.row = int(rng.choice(len(bank.material), p=np.exp(bank.log_weight))) if row is None else row
        self.material = network.classes("material")[bank.material[self.row]]
        coordinates = rng.normal(bank.mean[self.row], np.sqrt(bank.variance[self.row]))
        logs = np.array([prop.scale == LOG for prop in network.properties])
        self.values = np.where(logs, np.exp(np.where(logs, coordinates, 0.0)), coordinates)
        self._seed = int(rng.integers(2**63))

    def value(self, quantity: str) -> float:
        """Return the true value of a property or relation [SI unit]."""
        relation = self.network.relation(quantity)
        if relation is None:
            return float(self.values[self.network.index(quantity)])
        parts = [(self.values[self.network.index(name)], number) for name, number in relation.terms]
        if relation.kind == "sum":
            return float(sum(number * value for value, number in parts))
        return float(np.prod([value**number for value, number in parts]))

    def read(self, sensor: Sensor | ClassSensor, turn: int = 0) -> Measurement | str:
        """Return the n-th reading of a sensor: a measurement, or the outcome of a classifier.

        Args:
            sensor: the sensor.
            turn: which of its readings, from 0.
        """
        name = sensor.variable if isinstance(sensor, ClassSensor) else sensor.property
        kind = "class" if isinstance(sensor, ClassSensor) else "value"
        entropy = [self._seed, turn, *(kind + name).encode()]
        rng = np.random.default_rng(entropy)
        if isinstance(sensor, ClassSensor):
            bank = self.network.hypotheses
            index = int((bank.category if sensor.variable == CATEGORY else bank.material)[self.row])
            known = index < len(sensor.classes)
            column = sensor.matrix[:, index] if known else sensor.matrix.mean(axis=1)
            return sensor.outcomes[int(rng.choice(len(column), p=column / column.sum()))]
        true = self.value(sensor.property)
        noise = sensor.noise(true)
        reading = true + noise * float(rng.standard_normal())
        return Measurement(sensor.property, reading, noise, self.network.unit(sensor.property))

    def learn(self, belief: Belief, sensor: Sensor | ClassSensor, turn: int = 0) -> Belief:
        """Return a belief after the n-th reading of a sensor."""
        reading = self.read(sensor, turn)
        if isinstance(reading, Measurement):
            return belief.update(reading)
        assert isinstance(sensor, ClassSensor)
        return belief.update_output(sensor, reading)
