"""Planning two steps ahead: where a set-up pays only over two actions, or a budget holds more than one."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from estimation.belief import Belief
from estimation.measurement import Measurement
from estimation.network import MATERIAL
from estimation.sensor import ClassSensor, Sensor
from selection.channel import channel
from selection.planner import (
    NOTHING_WORTH,
    ActionModel,
    ActionScore,
    Decision,
    PlanState,
    StopRules,
    best_of,
    plan,
)

_DEFAULT_STATE = PlanState()
_DEFAULT_RULES = StopRules()


def worthwhile(
    actions: Sequence[ActionModel],
    state: PlanState = _DEFAULT_STATE,
    rules: StopRules = _DEFAULT_RULES,
) -> bool:
    """Return whether looking ahead can change a choice for good reason.

    It can where a set-up that is not met serves more than one action, or where the budget does not hold all
    actions. Elsewhere greedy and two-step plans were found to end alike (benchmarks/planner.py, docs/belief.md).
    """
    setups = [action.setup for action in actions if action.setup and action.setup not in state.setups]
    shared = len(setups) > len(set(setups))
    left = rules.budget_seconds - state.spent_seconds
    tight = math.isfinite(left) and left < sum(action.seconds + action.setup_seconds for action in actions)
    return shared or tight


def decide(
    belief: Belief,
    actions: Sequence[ActionModel],
    target: str = MATERIAL,
    price: float = 0.01,
    state: PlanState = _DEFAULT_STATE,
    rules: StopRules = _DEFAULT_RULES,
) -> Decision:
    """Plan two steps ahead where that is worthwhile, greedily elsewhere; arguments and errors as `plan`."""
    chosen = plan_ahead if worthwhile(actions, state, rules) else plan
    return chosen(belief, actions, target, price, state, rules)


def plan_ahead(
    belief: Belief,
    actions: Sequence[ActionModel],
    target: str = MATERIAL,
    price: float = 0.01,
    state: PlanState = _DEFAULT_STATE,
    rules: StopRules = _DEFAULT_RULES,
    outcomes: int = 7,
) -> Decision:
    """Choose argmax V(a) = I(a) - c(a) + E max(0, max_b I(b | z_a) - c(b)), the value over two steps.

    The expectation is over representative readings of a, of equal probability; after each the belief is
    conditioned and the best second action scored by its exact gain. A pure function of its arguments.

    Args:
        belief: what is known so far.
        actions: the repertoire.
        target: what the information is about.
        price: price of time [bits/s].
        state: set-ups that hold, actions done and failed, time spent.
        rules: when to stop.
        outcomes: readings per sensor that represent what may come.

    Raises:
        InvalidInput: as `plan`.
        UnknownName: as `plan`.
    """
    greedy = plan(belief, actions, target, price, state, rules)
    if greedy.stop not in (None, NOTHING_WORTH):
        return replace(greedy, horizon=2)
    scores = tuple(
        _with_future(belief, action, score, actions, target, price, state, rules, outcomes)
        if score.feasible
        else score
        for action, score in zip(actions, greedy.scores, strict=True)
    )
    best = best_of(scores)
    if best is None or best.value <= 0:
        return Decision(scores, None, greedy.stop or NOTHING_WORTH, target, price, 2)
    return Decision(scores, best.name, None, target, price, 2)


def _with_future(
    belief: Belief,
    action: ActionModel,
    score: ActionScore,
    actions: Sequence[ActionModel],
    target: str,
    price: float,
    state: PlanState,
    rules: StopRules,
    outcomes: int,
) -> ActionScore:
    """Return a score with the expected value of the best second action added."""
    after = state.after(action)
    future = 0.0
    for probability, posterior in _futures(belief, action, outcomes):
        decision = plan(posterior, actions, target, price, after, rules)
        if decision.choice is not None:
            future += probability * decision.score(decision.choice).value
    return replace(score, value=score.value + future)


def _futures(belief: Belief, action: ActionModel, outcomes: int) -> list[tuple[float, Belief]]:
    """Return what may be believed after an action: probabilities and posteriors."""
    per_sensor = outcomes if len(action.sensors) == 1 else 3
    found = []
    choices = [_outcomes(belief, sensor, per_sensor) for sensor in action.sensors]
    for combination in itertools.product(*choices):
        posterior, probability = belief, 1.0
        for sensor, (share, reading) in zip(action.sensors, combination, strict=True):
            probability *= share
            if isinstance(sensor, ClassSensor):
                posterior = posterior.update_output(sensor, sensor.outcomes[int(reading)])
            else:
                noise = max(sensor.noise(reading), 1e-12)
                unit = belief.network.unit(sensor.property)
                posterior = posterior.update(Measurement(sensor.property, reading, noise, unit))
        found.append((probability, posterior))
    return found


def _outcomes(belief: Belief, sensor: Sensor | ClassSensor, count: int) -> list[tuple[float, float]]:
    """Return representative readings: all outcomes of a classifier, else medians of equally likely bins."""
    model = channel(belief.network, belief.bank, sensor, per_sd=2.0)
    weight = np.bincount(model.component, weights=belief.bank.weight, minlength=model.columns.shape[1])
    mass = model.weights * (model.columns @ weight)
    if isinstance(sensor, ClassSensor):
        return [(float(p), float(i)) for i, p in enumerate(mass) if p > 1e-9]
    total = np.cumsum(mass) - 0.5 * mass
    levels = (np.arange(count) + 0.5) / count * total[-1]
    return [(1.0 / count, float(z)) for z in np.interp(levels, total, model.values)]
