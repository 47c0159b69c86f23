"""Ways to choose the next action, for many beliefs at once: each scores every action, the best is done."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from estimation.network import BOTH, MATERIAL
from estimation.sensor import ClassSensor, Sensor
from selection.information import AnySensor
from selection.lookahead import plan_ahead
from selection.planner import ActionModel, PlanState, StopRules
from selection.trials.beliefs import Beliefs
from selection.trials.gains import information_gains
from selection.trials.objects import Luck

SAMPLES = 100
"""Emulated readings per action in the thesis' Mode 1."""


class Policy(Protocol):
    """Scores actions, so that the best one is done."""

    @property
    def name(self) -> str:
        """What it is called in tables."""
        ...

    @property
    def stops(self) -> bool:
        """Whether it does nothing when no action is worth more than zero."""
        ...

    @property
    def priced(self) -> bool:
        """Whether an action is worth its score less the price of its time."""
        ...

    def scores(
        self, beliefs: Beliefs, rows: np.ndarray, actions: Sequence[ActionModel], done: np.ndarray, luck: Luck
    ) -> np.ndarray:
        """Return a score for every action, shape (n, A).

        Args:
            beliefs: of all trials.
            rows: which of them are asked about, shape (n,).
            actions: the repertoire.
            done: how often each was done, shape (n, A).
            luck: what a policy with randomness draws from.
        """
        ...


@dataclass(frozen=True)
class Exact:
    """The exact criterion: I(target; reading)."""

    target: str = MATERIAL
    stops: bool = True
    priced: bool = True

    @property
    def name(self) -> str:
        """What it is called in tables."""
        return f"exact, {self.target}"

    def scores(
        self, beliefs: Beliefs, rows: np.ndarray, actions: Sequence[ActionModel], done: np.ndarray, luck: Luck
    ) -> np.ndarray:
        """Return the exact gains [bits]."""
        return _by_sensor(actions, lambda sensor: information_gains(beliefs, sensor, self.target, rows))


@dataclass(frozen=True)
class Random:
    """Any feasible action, all equally likely."""

    name: str = "random"
    stops: bool = False
    priced: bool = False

    def scores(
        self, beliefs: Beliefs, rows: np.ndarray, actions: Sequence[ActionModel], done: np.ndarray, luck: Luck
    ) -> np.ndarray:
        """Return independent uniform numbers."""
        return luck.uniform(rows, len(actions))


@dataclass(frozen=True)
class Fixed:
    """The actions in their declared order, over and over."""

    name: str = "fixed order"
    stops: bool = False
    priced: bool = False

    def scores(
        self, beliefs: Beliefs, rows: np.ndarray, actions: Sequence[ActionModel], done: np.ndarray, luck: Luck
    ) -> np.ndarray:
        """Return the order, backwards; what was done less often comes first."""
        return np.asarray(-(done * len(actions) + np.arange(len(actions))), dtype=float)


@dataclass(frozen=True)
class PerNode:
    """The greedy rule per node: what a reading teaches about the one node that it reads."""

    name: str = "per node"
    stops: bool = True
    priced: bool = False

    def scores(
        self, beliefs: Beliefs, rows: np.ndarray, actions: Sequence[ActionModel], done: np.ndarray, luck: Luck
    ) -> np.ndarray:
        """Return the gains about the sensors' own nodes [bits]."""

        def own(sensor: AnySensor) -> np.ndarray:
            node = sensor.variable if isinstance(sensor, ClassSensor) else sensor.property
            return information_gains(beliefs, sensor, node, rows)

        return _by_sensor(actions, own)


@dataclass(frozen=True)
class Emulating:
    """A thesis mode on exact beliefs: only the criterion is the thesis', with its sampling and its product.

    For a classifier, of which the thesis knows none, all three take the exact gain. Time has no price there.

    Attributes:
        mode: 1, 2 or 3.
        target: the classes of Mode 1, ``material`` or ``both``.
    """

    mode: int
    target: str = MATERIAL
    stops: bool = True
    priced: bool = False

    @property
    def name(self) -> str:
        """What it is called in tables."""
        suffix = ", all classes" if self.target == BOTH and self.mode != 2 else ""
        return f"mode {self.mode}{suffix}"

    def scores(
        self, beliefs: Beliefs, rows: np.ndarray, actions: Sequence[ActionModel], done: np.ndarray, luck: Luck
    ) -> np.ndarray:
        """Return the mode's gains."""

        def gain(sensor: AnySensor) -> np.ndarray:
            if isinstance(sensor, ClassSensor):
                return information_gains(beliefs, sensor, self.target, rows)
            found = np.zeros(len(rows))
            if self.mode != 2:
                found = found + self._sampled(beliefs, sensor, rows, luck)
            return found + _product_gain(beliefs, sensor, rows) if self.mode != 1 else found

        return _by_sensor(actions, gain)

    def _sampled(self, beliefs: Beliefs, sensor: Sensor, rows: np.ndarray, luck: Luck) -> np.ndarray:
        """Return H(T) - mean over sampled readings of H(T | z) [bits]."""
        mean, variance = beliefs.moments(sensor.property, rows)
        parent = beliefs.rows_of(beliefs.network.property(sensor.property).parent)
        count, total = mean.shape[1], np.sqrt(variance + sensor.sd**2)
        group = np.arange(len(parent)) if self.target == BOTH else beliefs.rows_of(MATERIAL)
        weight = beliefs.weights(rows)
        joint = weight @ np.eye((group.max() + 1) * count)[group * count + parent]
        joint = joint.reshape(len(rows), -1, count)
        own = joint.sum(axis=1)
        picks, errors = luck.uniform(rows, SAMPLES), luck.normal(rows, SAMPLES)
        ends = np.cumsum(own, axis=1)
        component = (picks[:, :, None] >= (ends / ends[:, -1:])[:, None, :-1]).sum(axis=2)
        z = np.take_along_axis(mean, component, 1) + np.take_along_axis(total, component, 1) * errors
        scaled = (z[:, :, None] - mean[:, None, :]) / total[:, None, :]
        likelihood = np.exp(-0.5 * scaled**2) / total[:, None, :]
        posterior = likelihood @ joint.transpose(0, 2, 1)
        posterior /= posterior.sum(axis=2, keepdims=True)
        return np.asarray(_bits(joint.sum(axis=2)) - _bits(posterior).mean(axis=1))


@dataclass(frozen=True)
class Lookahead:
    """Two steps ahead by `plan_ahead`, one belief after the other.

    Attributes:
        target: what the information is about.
        price: of time [bits/s], as in the limits of the exploration.
        budget_seconds: robot time [s], as there.
    """

    target: str = MATERIAL
    price: float = 0.0
    budget_seconds: float = math.inf
    stops: bool = True
    priced: bool = True

    @property
    def name(self) -> str:
        """What it is called in tables."""
        return f"two steps ahead, {self.target}"

    def scores(
        self, beliefs: Beliefs, rows: np.ndarray, actions: Sequence[ActionModel], done: np.ndarray, luck: Luck
    ) -> np.ndarray:
        """Return the values over two steps, the price of the action itself not yet paid [bits]."""
        rules = StopRules(confidence=1.0, budget_seconds=self.budget_seconds)
        found = np.full((len(rows), len(actions)), -np.inf)
        for i, row in enumerate(rows.tolist()):
            state = PlanState()
            for action, times in zip(actions, done[i].tolist(), strict=True):
                for _ in range(times):
                    state = state.after(action)
            decision = plan_ahead(beliefs.one(row), actions, self.target, self.price, state, rules)
            found[i] = [score.value + self.price * score.seconds for score in decision.scores]
        return found


def _product_gain(beliefs: Beliefs, sensor: Sensor, rows: np.ndarray) -> np.ndarray:
    """Return H(f) - H(f o (f * g)) [bits] of the exact belief f about the property (Mode 2)."""
    mean, variance = beliefs.moments(sensor.property, rows)
    parent = beliefs.rows_of(beliefs.network.property(sensor.property).parent)
    weight = beliefs.weights(rows) @ np.eye(mean.shape[1])[parent]
    sd, total = np.sqrt(variance), np.sqrt(variance + sensor.sd**2)
    low, high = np.min(mean - 6 * sd, axis=1), np.max(mean + 6 * sd, axis=1)
    number = int(np.ceil(np.max(2 * (high - low) / sd.min(axis=1)))) + 1
    found = np.empty(len(rows))
    size = max(1, 1_500_000 // (number * mean.shape[1]))
    for start in range(0, len(rows), size):
        part = slice(start, start + size)
        step = (high - low)[part] / (number - 1)
        x = low[part, None, None] + step[:, None, None] * np.arange(number)[:, None]
        belief, emulation = (
            (np.exp(-0.5 * ((x - mean[part, None]) / s[part, None]) ** 2) / s[part, None]) @ weight[part, :, None]
            for s in (sd, total)
        )
        prior, product = belief[..., 0], belief[..., 0] * emulation[..., 0]
        prior, product = (f / (f.sum(axis=1) * step)[:, None] for f in (prior, product))
        found[part] = step * (np.sum(product * _log2(product), axis=1) - np.sum(prior * _log2(prior), axis=1))
    return found


def _by_sensor(actions: Sequence[ActionModel], gain: object) -> np.ndarray:
    return np.column_stack([gain(action.sensors[0]) for action in actions])  # type: ignore[operator]


def _bits(p: np.ndarray) -> np.ndarray:
    return np.asarray(-np.sum(p * _log2(p), axis=-1))


def _log2(p: np.ndarray) -> np.ndarray:
    return np.asarray(np.log(np.maximum(p, 1e-300)) / math.log(2))
