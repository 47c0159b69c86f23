"""Many virtual objects, each with randomness of its own, so that nobody else's trials change its readings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from dynamics.errors import InvalidInput
from estimation.network import LINEAR, MATERIAL, Network
from estimation.sensor import ClassSensor, Sensor


def trial_rng(seed: int, stream: int, trial: int) -> np.random.Generator:
    """Return the randomness of one trial: the same whatever else is computed, in whatever order.

    Args:
        seed: of the experiment.
        stream: what it is for, so that objects and policies never share numbers.
        trial: number of the trial.
    """
    return np.random.default_rng([seed, stream, trial])


class Luck:
    """The random numbers that a policy uses, a stream a trial.

    Args:
        seed, stream: as for `trial_rng`.
        trials: numbers of the trials.
    """

    def __init__(self, seed: int, stream: int, trials: Sequence[int]) -> None:
        self._key, self._trials = (seed, stream), trials

    @cached_property
    def _rngs(self) -> list[np.random.Generator]:
        return [trial_rng(*self._key, trial) for trial in self._trials]

    def uniform(self, rows: np.ndarray, *shape: int) -> np.ndarray:
        """Return uniform numbers, shape (n, *shape)."""
        return np.stack([self._rngs[row].random(shape) for row in rows])

    def normal(self, rows: np.ndarray, *shape: int) -> np.ndarray:
        """Return standard normal numbers, shape (n, *shape)."""
        return np.stack([self._rngs[row].standard_normal(shape) for row in rows])


@dataclass(frozen=True, eq=False)
class Objects:
    """N objects and what every sensor will read of them, turn by turn.

    Attributes:
        network: the reference whose sensors read them.
        material, category: true class indices, shape (N,); the last one of an unknown class.
        readings: by sensor, values or outcome indices, shape (N, turns).
        sds: by sensor, what the reading claims as its sd [SI unit], shape (N, turns); none for a classifier.
    """

    network: Network
    material: np.ndarray
    category: np.ndarray
    readings: dict[str, np.ndarray]
    sds: dict[str, np.ndarray]

    def __len__(self) -> int:
        return len(self.material)

    def truth(self, variable: str) -> np.ndarray:
        """Return the true class of a variable, shape (N,)."""
        return self.material if variable == MATERIAL else self.category


def drawn(network: Network, seed: int, trials: Sequence[int], turns: int = 1, stream: int = 0) -> Objects:
    """Return objects drawn from a network and read through its sensor models, as `VirtualObject` does.

    Args:
        network: the reference; its sensors read properties.
        seed, stream: as for `trial_rng`.
        trials: numbers of the trials, one object each.
        turns: readings per sensor.

    Raises:
        InvalidInput: if a property lives on the log scale.
    """
    bank, sensors = network.hypotheses, network.sensors
    for prop in network.properties:
        if prop.scale != LINEAR:
            raise InvalidInput(f"virtual objects: {prop.name}", prop.scale, "a property on the linear scale")
    count, size = len(trials), len(network.properties)
    picks, normal = np.empty(count), np.empty((count, size))
    errors, luck = np.empty((2, count, len(sensors), turns))
    for i, trial in enumerate(trials):
        rng = trial_rng(seed, stream, trial)
        picks[i], normal[i] = rng.random(), rng.standard_normal(size)
        errors[i], luck[i] = rng.standard_normal((len(sensors), turns)), rng.random((len(sensors), turns))
    ends = np.cumsum(np.exp(bank.log_weight))
    row = np.minimum(np.searchsorted(ends / ends[-1], picks, side="right"), len(ends) - 1)
    values = bank.mean[row] + normal * np.sqrt(bank.variance[row])
    readings, sds = {}, {}
    for i, (name, sensor) in enumerate(sensors):
        if isinstance(sensor, Sensor):
            true = values[:, network.index(sensor.property)][:, None]
            noise = np.hypot(sensor.sd, sensor.relative_sd * true)
            readings[name], sds[name] = true + noise * errors[:, i], np.broadcast_to(noise, (count, turns))
        else:
            truth = (bank.material if sensor.variable == MATERIAL else bank.category)[row]
            readings[name] = _outcomes(sensor, truth, luck[:, i])
    return Objects(network, bank.material[row], bank.category[row], readings, sds)


def _outcomes(sensor: ClassSensor, truth: np.ndarray, luck: np.ndarray) -> np.ndarray:
    """Return what a classifier says, shape (N, turns); about an unknown class, as about any."""
    columns = np.column_stack([sensor.matrix, sensor.matrix.mean(axis=1)])
    ends = np.cumsum(columns, axis=0)[:, np.minimum(truth, columns.shape[1] - 1)].T
    return np.asarray((luck[:, :, None] >= ends[:, None, :-1]).sum(axis=2))
