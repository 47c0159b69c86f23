"""Which action next: expected information against its price, and when to stop."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from dynamics.errors import InvalidInput, UnknownName
from estimation.belief import Belief
from estimation.measurement import Measurement
from estimation.network import BOTH, MATERIAL
from estimation.sensor import ClassSensor, Sensor
from selection.information import AnySensor, information_gain

NEAR_TIE = 1e-9

CONFIDENT = "confident"
NOTHING_WORTH = "nothing worth its price"
OUT_OF_BUDGET = "budget spent"
FAILED = "failed before"
ALL_FAILED = "all actions failed"
EXHAUSTED = "all actions used up"


@dataclass(frozen=True)
class ActionModel:
    """What an action informs and what it costs.

    Attributes:
        name: such as ``weigh``.
        sensors: what it reads, all at once.
        seconds: its duration [s], >= 0.
        setup: what must hold before, such as ``grasp``; None if nothing.
        setup_seconds: time to bring that about once [s], >= 0.
        repeat_cap: how often it may be done; None without limit. For a classifier, whose error is common to
            all looks at one object, one.

    Raises:
        InvalidInput: if a duration is negative or not finite, or the cap is below one.
    """

    name: str
    sensors: tuple[AnySensor, ...]
    seconds: float
    setup: str | None = None
    setup_seconds: float = 0.0
    repeat_cap: int | None = None

    def __post_init__(self) -> None:
        where = f"action {self.name}"
        for key, value in (("seconds", self.seconds), ("setup_seconds", self.setup_seconds)):
            if not (math.isfinite(value) and value >= 0):
                raise InvalidInput(f"{where}: {key}", value, "a finite number >= 0")
        if self.repeat_cap is not None and self.repeat_cap < 1:
            raise InvalidInput(f"{where}: repeat_cap", self.repeat_cap, "a whole number >= 1, or none")

    def observed(self, measurement: Measurement) -> ActionModel:
        """Return the action with the noise that an estimator just reported for one of its quantities.

        Args:
            measurement: what the estimator gave, in SI units.
        """
        sensors = tuple(
            sensor.observed(measurement.sd, measurement.mean)
            if isinstance(sensor, Sensor) and sensor.property == measurement.property
            else sensor
            for sensor in self.sensors
        )
        return replace(self, sensors=sensors)


@dataclass(frozen=True)
class PlanState:
    """Where an exploration stands.

    Attributes:
        setups: set-ups that hold now, such as ``grasp``.
        done: names of the actions done so far, one entry each time.
        failed: names of the actions that failed and are not tried again.
        spent_seconds: time used so far [s].
    """

    setups: frozenset[str] = frozenset()
    done: tuple[str, ...] = ()
    failed: frozenset[str] = frozenset()
    spent_seconds: float = 0.0

    def after(self, action: ActionModel, seconds: float | None = None) -> PlanState:
        """Return the state after an action that succeeded.

        Args:
            action: the action.
            seconds: the time it took [s]; its modelled time if None.
        """
        setups = self.setups if action.setup is None else self.setups | {action.setup}
        took = price_seconds(action, self) if seconds is None else seconds
        return replace(
            self, setups=setups, done=(*self.done, action.name), spent_seconds=self.spent_seconds + took
        )

    def failing(self, action: ActionModel, seconds: float = 0.0) -> PlanState:
        """Return the state after an action that failed for good."""
        return replace(self, failed=self.failed | {action.name}, spent_seconds=self.spent_seconds + seconds)


@dataclass(frozen=True)
class StopRules:
    """When an exploration ends.

    Attributes:
        confidence: stop when the most probable class of the target variable reaches this probability.
        budget_seconds: stop when no action fits into this time [s].
    """

    confidence: float = 0.95
    budget_seconds: float = math.inf

    def __post_init__(self) -> None:
        if not 0 < self.confidence <= 1:
            raise InvalidInput("stop rules: confidence", self.confidence, "a number in (0, 1]")
        if not self.budget_seconds >= 0:
            raise InvalidInput("stop rules: budget_seconds", self.budget_seconds, "seconds >= 0")


@dataclass(frozen=True)
class ActionScore:
    """What the planner thinks of one action.

    Attributes:
        name: the action's name.
        bits: expected information about the target [bits].
        seconds: its time, unmet set-up included [s].
        value: what choosing it is worth: bits - price seconds, plus the value of what may follow when the
            planner looked ahead [bits].
        feasible: whether it may be chosen.
        reason: why not, or an empty text.
    """

    name: str
    bits: float
    seconds: float
    value: float
    feasible: bool = True
    reason: str = ""


@dataclass(frozen=True)
class Decision:
    """What to do next.

    Attributes:
        scores: one per action, in the order given.
        choice: name of the chosen action, or None.
        stop: why to stop, or None when an action is chosen.
        target: what the information is about.
        price: price of time [bits/s].
        horizon: how many steps were looked ahead.
    """

    scores: tuple[ActionScore, ...]
    choice: str | None
    stop: str | None
    target: str
    price: float
    horizon: int = 1

    def score(self, name: str) -> ActionScore:
        """Return the score of an action.

        Raises:
            UnknownName: if there is no such action.
        """
        for score in self.scores:
            if score.name == name:
                return score
        raise UnknownName("action", name, [score.name for score in self.scores])


_DEFAULT_STATE = PlanState()
_DEFAULT_RULES = StopRules()


def plan(
    belief: Belief,
    actions: Sequence[ActionModel],
    target: str = MATERIAL,
    price: float = 0.01,
    state: PlanState = _DEFAULT_STATE,
    rules: StopRules = _DEFAULT_RULES,
) -> Decision:
    """Choose argmax over feasible actions of I(target; reading) - price x (time + unmet set-up time).

    A pure function of its arguments. Near-ties (1e-9 bit) go to the cheaper action, then to the one named
    first.

    Args:
        belief: what is known so far.
        actions: the repertoire.
        target: ``material``, ``category``, ``both``, a property, or ``everything``.
        price: price of time [bits/s], >= 0.
        state: set-ups that hold, actions done and failed, time spent.
        rules: when to stop.

    Raises:
        InvalidInput: if the price is negative or not finite, or two actions share a name.
        UnknownName: if the target or a quantity is not known.
    """
    check(actions, price)
    scores = tuple(_score(belief, action, target, price, state, rules) for action in actions)
    stop = _reason_to_stop(belief, scores, target, rules)
    best = None if stop else best_of(scores)
    if best is not None and best.value <= 0:
        best, stop = None, NOTHING_WORTH
    return Decision(scores, best.name if best else None, stop, target, price)


def check(actions: Sequence[ActionModel], price: float) -> None:
    """Refuse a price or a repertoire that makes no sense.

    Raises:
        InvalidInput: if the price is negative or not finite, or two actions share a name.
    """
    if not (math.isfinite(price) and price >= 0):
        raise InvalidInput("plan: price", price, "bits per second, a finite number >= 0")
    names = [action.name for action in actions]
    if len(set(names)) != len(names):
        raise InvalidInput("plan: actions", names, "different names")


def price_seconds(action: ActionModel, state: PlanState) -> float:
    """Return the time of an action, its set-up included unless it already holds [s]."""
    if action.setup is None or action.setup in state.setups:
        return action.seconds
    return action.seconds + action.setup_seconds


def best_of(scores: Sequence[ActionScore]) -> ActionScore | None:
    """Return the feasible score of highest value, near-ties to the cheaper, then to the first."""
    feasible = [score for score in scores if score.feasible]
    if not feasible:
        return None
    top = max(score.value for score in feasible)
    return min((score for score in feasible if score.value >= top - NEAR_TIE), key=lambda score: score.seconds)


def confidence(belief: Belief, target: str) -> float:
    """Return the probability of the most probable class that the target asks for; 0 for properties."""
    if target in belief.network.variables:
        return max(belief.probabilities(target).values())
    return float(belief.bank.weight.max()) if target == BOTH else 0.0


def _score(
    belief: Belief, action: ActionModel, target: str, price: float, state: PlanState, rules: StopRules
) -> ActionScore:
    seconds = price_seconds(action, state)
    reason = why_not(action, state, rules)
    bits = 0.0 if reason == FAILED else information_gain(belief, action.sensors, target)
    return ActionScore(action.name, bits, seconds, bits - price * seconds, not reason, reason)


def why_not(action: ActionModel, state: PlanState, rules: StopRules) -> str:
    """Return why an action may not be chosen now, or an empty text."""
    if action.name in state.failed:
        return FAILED
    if action.repeat_cap is not None and state.done.count(action.name) >= action.repeat_cap:
        return EXHAUSTED
    if state.spent_seconds + price_seconds(action, state) > rules.budget_seconds:
        return OUT_OF_BUDGET
    return ""


def _reason_to_stop(belief: Belief, scores: Sequence[ActionScore], target: str, rules: StopRules) -> str | None:
    if confidence(belief, target) >= rules.confidence:
        return CONFIDENT
    if any(score.feasible for score in scores):
        return None
    reasons = {score.reason for score in scores}
    if OUT_OF_BUDGET in reasons:
        return OUT_OF_BUDGET
    return ALL_FAILED if reasons == {FAILED} else EXHAUSTED


__all__ = [
    "ActionModel",
    "ActionScore",
    "ClassSensor",
    "Decision",
    "PlanState",
    "Sensor",
    "StopRules",
    "plan",
]
