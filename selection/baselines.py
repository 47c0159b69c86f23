"""What the planner is compared with: random order, a fixed order, and a greedy rule per node."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dynamics.errors import UnknownName
from estimation.belief import Belief
from estimation.sensor import ClassSensor
from selection.information import information_gain
from selection.planner import ActionModel, PlanState, StopRules, why_not


def feasible(
    actions: Sequence[ActionModel], state: PlanState, rules: StopRules | None = None
) -> tuple[ActionModel, ...]:
    """Return the actions that may still be done."""
    rules = StopRules() if rules is None else rules
    return tuple(action for action in actions if not why_not(action, state, rules))


def random_choice(
    actions: Sequence[ActionModel], state: PlanState, rng: np.random.Generator, rules: StopRules | None = None
) -> str | None:
    """Return any feasible action, all equally likely, or None."""
    open_actions = feasible(actions, state, rules)
    return open_actions[int(rng.integers(len(open_actions)))].name if open_actions else None


def fixed_choice(
    actions: Sequence[ActionModel], state: PlanState, order: Sequence[str], rules: StopRules | None = None
) -> str | None:
    """Return the next action of a fixed order that is feasible, or None at its end.

    Args:
        actions: the repertoire.
        state: where the exploration stands; as many entries of the order are over as actions were done.
        order: names of actions, repeats allowed.
        rules: the budget.

    Raises:
        UnknownName: if the order names an action that there is not.
    """
    names = [action.name for action in actions]
    for name in order:
        if name not in names:
            raise UnknownName("fixed order", name, names)
    open_names = {action.name for action in feasible(actions, state, rules)}
    return next((name for name in order[len(state.done) :] if name in open_names), None)


def greedy_per_node(
    belief: Belief, actions: Sequence[ActionModel], state: PlanState, rules: StopRules | None = None
) -> str | None:
    """Return the feasible action that teaches its own node most: I(node; z), no price, no message passing on.

    The node of a gauge is the property it reads, that of a classifier its variable; what the reading teaches
    about any other node does not count. This is the rule of planners that score every node for itself.
    """
    best, choice = 0.0, None
    for action in feasible(actions, state, rules):
        for sensor in action.sensors:
            node = sensor.variable if isinstance(sensor, ClassSensor) else sensor.property
            if node not in (*belief.network.variables, *belief.network.property_names):
                node = "everything"
            gain = information_gain(belief, sensor, node)
            if gain > best:
                best, choice = gain, action.name
    return choice
