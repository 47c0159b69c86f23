"""Many explorations at once: plan, read, learn, until nothing more may or need be done."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Protocol

import numpy as np

from estimation.network import MATERIAL, UNKNOWN
from estimation.sensor import ClassSensor, Sensor
from selection.planner import NEAR_TIE, ActionModel
from selection.trials.objects import Luck, Objects
from selection.trials.policies import Policy


class Learner(Protocol):
    """What `explore` needs of many beliefs."""

    def probabilities(self, variable: str) -> np.ndarray:
        """Return P(class), shape (N, classes)."""
        ...

    def update(self, rows: np.ndarray, quantity: str, z: np.ndarray, sd: np.ndarray | float) -> None:
        """Condition on readings of a property."""
        ...

    def update_output(self, rows: np.ndarray, sensor: ClassSensor, outcome: np.ndarray) -> None:
        """Condition on outcomes of a classifier."""
        ...


@dataclass(frozen=True, eq=False)
class Trace:
    """How N explorations of at most S steps went, as seen from one class variable.

    What stands at step s holds after s actions; after its end an exploration stays where it was.

    Attributes:
        choices: index of the action of every step, -1 for none, shape (N, S).
        seconds: time spent, shape (N, S + 1).
        true: P(true class), shape (N, S + 1).
        top: the largest P of a class, shape (N, S + 1).
        right: whether the most probable class is the true one, shape (N, S + 1).
        unknown: whether it is ``unknown``, shape (N, S + 1).
        novel: whether the object is of no listed class, shape (N,).
    """

    choices: np.ndarray
    seconds: np.ndarray
    true: np.ndarray
    top: np.ndarray
    right: np.ndarray
    unknown: np.ndarray
    novel: np.ndarray

    def arrays(self, prefix: str = "") -> dict[str, np.ndarray]:
        """Return the arrays by name, as they are kept on disk."""
        return {prefix + field.name: getattr(self, field.name) for field in fields(self)}

    @classmethod
    def of(cls, parts: Sequence[Mapping[str, np.ndarray]], prefix: str = "") -> Trace:
        """Return the trace of trials that were kept in several parts."""
        return cls(**{f.name: np.concatenate([part[prefix + f.name] for part in parts]) for f in fields(cls)})

    def ordered(self, order: np.ndarray) -> Trace:
        """Return the trials in another order, or some of them."""
        return Trace(**{name: array[order] for name, array in self.arrays().items()})


@dataclass(frozen=True)
class Limits:
    """What an exploration may use.

    Attributes:
        steps: actions at most.
        price: of time [bits/s], for policies that pay it.
        budget_seconds: robot time [s].
        confidence: P of the most probable class of the variable at which to stop; above one for never.
    """

    steps: int
    price: float = 0.0
    budget_seconds: float = np.inf
    confidence: float = 2.0


def explore(
    objects: Objects,
    learner: Learner,
    actions: Sequence[ActionModel],
    policy: Policy,
    luck: Luck,
    limits: Limits,
    variables: Sequence[str] = (MATERIAL,),
) -> tuple[Trace, ...]:
    """Explore many objects with one policy.

    Args:
        objects: what is explored.
        learner: what is believed of them beforehand; it is changed.
        actions: the repertoire, one sensor each, named as the reference's sensors.
        policy: chooses.
        luck: what it may draw from.
        limits: when to end.
        variables: the class variables to look at; the first is the one to be confident about.

    Returns:
        One trace a variable.
    """
    count, steps = len(objects), limits.steps
    choices = np.full((count, steps), -1)
    seconds = np.zeros((count, steps + 1))
    state = _State.fresh(count, actions)
    seen = [_Seen(objects, variable, steps) for variable in variables]
    for part in seen:
        part.look(learner, 0)
    active = np.arange(count)
    for step in range(steps):
        active = active[seen[0].top[active, step] < limits.confidence]
        if len(active):
            chosen = _choose(policy, learner, active, actions, state, luck, limits)
            active, chosen = active[chosen >= 0], chosen[chosen >= 0]
            for i in np.unique(chosen):
                rows = active[chosen == i]
                _read(objects, learner, actions[i], rows, state.done[rows, i])
                state.do(rows, i)
            choices[active, step] = chosen
        seconds[:, step + 1] = state.spent
        for part in seen:
            part.look(learner, step + 1)
    return tuple(
        Trace(choices, seconds, part.true, part.top, part.right, part.unknown, part.novel) for part in seen
    )


class _State:
    """Where every exploration stands: as `PlanState`, for many."""

    def __init__(
        self, actions: Sequence[ActionModel], done: np.ndarray, held: np.ndarray, spent: np.ndarray
    ) -> None:
        self.actions, self.done, self.held, self.spent = actions, done, held, spent
        names = sorted({action.setup for action in actions if action.setup})
        self.setup = np.array([names.index(action.setup) if action.setup else len(names) for action in actions])
        self.own = np.array([action.seconds for action in actions])
        self.extra = np.array([action.setup_seconds if action.setup else 0.0 for action in actions])
        self.caps = np.array([action.repeat_cap or np.inf for action in actions])

    @classmethod
    def fresh(cls, count: int, actions: Sequence[ActionModel]) -> _State:
        """Return the state before anything was done."""
        return cls(
            actions,
            np.zeros((count, len(actions)), dtype=int),
            np.zeros((count, len(actions) + 1), dtype=bool),
            np.zeros(count),
        )

    def prices(self, rows: np.ndarray) -> np.ndarray:
        """Return the time that every action takes now, unmet set-up included [s], shape (n, A)."""
        return np.asarray(self.own + np.where(self.held[np.ix_(rows, self.setup)], 0.0, self.extra))

    def do(self, rows: np.ndarray, action: int) -> None:
        """Note that an action was done."""
        self.spent[rows] += self.prices(rows)[:, action]
        self.done[rows, action] += 1
        if self.actions[action].setup:
            self.held[rows, self.setup[action]] = True


class _Seen:
    """The trace of one variable, while it is made."""

    def __init__(self, objects: Objects, variable: str, steps: int) -> None:
        self.variable, self.truth = variable, objects.truth(variable)
        classes = objects.network.classes(variable)
        self.count = len(classes)
        self.last_is_unknown = classes[-1] == UNKNOWN
        listed = len(objects.network.materials if variable == MATERIAL else objects.network.categories)
        self.novel = self.truth >= listed
        shape = (len(objects), steps + 1)
        self.true, self.top = np.zeros(shape), np.zeros(shape)
        self.right, self.unknown = np.zeros(shape, dtype=bool), np.zeros(shape, dtype=bool)

    def look(self, learner: Learner, step: int) -> None:
        """Note what is believed after a number of actions."""
        found = learner.probabilities(self.variable)
        best = found.argmax(axis=1)
        inside = np.minimum(self.truth, found.shape[1] - 1)
        self.true[:, step] = np.where(
            self.truth < found.shape[1], np.take_along_axis(found, inside[:, None], 1)[:, 0], 0.0
        )
        self.top[:, step] = found.max(axis=1)
        self.right[:, step] = best == self.truth
        self.unknown[:, step] = self.last_is_unknown & (best == self.count - 1)


def _choose(
    policy: Policy,
    learner: Learner,
    rows: np.ndarray,
    actions: Sequence[ActionModel],
    state: _State,
    luck: Luck,
    limits: Limits,
) -> np.ndarray:
    """Return the index of every exploration's next action, or -1: near-ties to the cheaper, then the first."""
    prices = state.prices(rows)
    value = policy.scores(learner, rows, actions, state.done[rows], luck)  # type: ignore[arg-type]
    if policy.priced:
        value = value - limits.price * prices
    feasible = (state.done[rows] < state.caps) & (state.spent[rows, None] + prices <= limits.budget_seconds)
    value = np.where(feasible, value, -np.inf)
    top = value.max(axis=1, keepdims=True)
    with np.errstate(invalid="ignore"):
        chosen = np.where(feasible & (value >= top - NEAR_TIE), prices, np.inf).argmin(axis=1)
    least = 0.0 if policy.stops else -np.inf
    return np.where(top[:, 0] > least, chosen, -1)


def _read(objects: Objects, learner: Learner, action: ActionModel, rows: np.ndarray, turn: np.ndarray) -> None:
    sensor = action.sensors[0]
    reading = objects.readings[action.name][rows, turn]
    if isinstance(sensor, Sensor):
        learner.update(rows, sensor.property, reading, objects.sds[action.name][rows, turn])
    else:
        learner.update_output(rows, sensor, reading)
