"""Choosing and stopping: values, set-ups, caps, ties, budgets, and two steps ahead."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dynamics.errors import InvalidInput, UnknownName
from estimation.belief import Belief
from estimation.measurement import Measurement
from estimation.network import Network, Property
from estimation.sensor import ClassSensor, Sensor
from selection.baselines import fixed_choice, greedy_per_node, random_choice
from selection.information import information_gain
from selection.lookahead import decide, plan_ahead, worthwhile
from selection.planner import (
    ALL_FAILED,
    CONFIDENT,
    EXHAUSTED,
    NOTHING_WORTH,
    OUT_OF_BUDGET,
    ActionModel,
    PlanState,
    StopRules,
    plan,
)

NETWORK = Network.from_file("soft-cubes")
BELIEF = Belief(NETWORK).update(Measurement("volume", 0.056**3, 3.5e-6, "m^3"))
WEIGH = ActionModel("weigh", (NETWORK.sensor("weigh"),), 12.0, "grasp", 6.0)
SQUEEZE = ActionModel("squeeze", (NETWORK.sensor("squeeze"),), 15.0, "grasp", 6.0)
RUB = ActionModel("rub", (NETWORK.sensor("rub"),), 20.0)
ACTIONS = (WEIGH, SQUEEZE, RUB)


def two_coins(first: float, second: float) -> Network:
    """Return two classes that two properties tell apart, each so well."""
    return Network(
        name="coins",
        materials=("a", "b"),
        properties=(
            Property("x", "material", "1", "linear", (0.0, first), (0.1, 0.1)),
            Property("y", "material", "1", "linear", (0.0, second), (0.1, 0.1)),
        ),
        prior=(0.5, 0.5),
        unknown=None,
    )


def test_value_is_information_minus_price_of_time_and_set_up() -> None:
    decision = plan(BELIEF, ACTIONS, price=0.01)
    for action, score in zip(ACTIONS, decision.scores, strict=True):
        bits = information_gain(BELIEF, action.sensors)
        assert score.bits == bits
        assert score.seconds == action.seconds + action.setup_seconds
        assert score.value == pytest.approx(bits - 0.01 * score.seconds)
    assert decision.choice == max(decision.scores, key=lambda score: score.value).name
    assert decision.stop is None


def test_set_up_is_charged_once() -> None:
    state = PlanState().after(WEIGH)
    assert state.spent_seconds == 18.0
    assert plan(BELIEF, ACTIONS, state=state).score("squeeze").seconds == 15.0
    assert plan(BELIEF, ACTIONS, state=state).score("rub").seconds == 20.0


def test_grasping_alone_would_never_be_chosen() -> None:
    grasp = ActionModel("grasp", (), 6.0)
    assert plan(BELIEF, (grasp, RUB)).score("grasp").bits == 0
    assert plan(BELIEF, (grasp,)).stop == NOTHING_WORTH


def test_stopping() -> None:
    sure = BELIEF.update(Measurement("mass", 0.1, 0.001, "kg")).update(Measurement("elasticity", 5e4, 2e3, "Pa"))
    assert plan(sure, ACTIONS).stop == CONFIDENT
    assert plan(BELIEF, ACTIONS, price=1.0).stop == NOTHING_WORTH
    assert plan(BELIEF, ACTIONS, rules=StopRules(budget_seconds=10.0)).stop == OUT_OF_BUDGET
    failed = PlanState(failed=frozenset({"weigh", "squeeze", "rub"}))
    assert plan(BELIEF, ACTIONS, state=failed).stop == ALL_FAILED
    once = ActionModel("rub", RUB.sensors, 20.0, repeat_cap=1)
    assert plan(BELIEF, (once,), state=PlanState(done=("rub",))).stop == EXHAUSTED
    assert plan(BELIEF, ()).choice is None


def test_one_class_needs_no_action() -> None:
    network = Network.from_file("thesis-3.2").without_unknown()
    only = Belief(network, {"black-cube": 1.0})
    actions = (ActionModel("weigh", (network.sensor("weigh"),), 1.0),)
    assert plan(only, actions, rules=StopRules(confidence=1.0)).stop == CONFIDENT


def test_failed_and_capped_actions_are_passed_over() -> None:
    best = plan(BELIEF, ACTIONS).choice
    assert best is not None
    state = PlanState().failing(next(a for a in ACTIONS if a.name == best), seconds=7.0)
    decision = plan(BELIEF, ACTIONS, state=state)
    assert state.spent_seconds == 7.0
    assert decision.choice not in (best, None)
    assert not decision.score(best).feasible


def test_ties_go_to_the_cheaper_then_to_the_first() -> None:
    twin = ActionModel("twin", WEIGH.sensors, 12.0, "grasp", 6.0)
    slow = ActionModel("slow", WEIGH.sensors, 13.0, "grasp", 6.0)
    assert plan(BELIEF, (WEIGH, twin), price=0.0).choice == "weigh"
    assert plan(BELIEF, (twin, WEIGH), price=0.0).choice == "twin"
    assert plan(BELIEF, (slow, twin), price=0.0).choice == "twin"


def test_planning_is_a_pure_function() -> None:
    before = BELIEF.to_json()
    assert plan(BELIEF, ACTIONS) == plan(BELIEF, ACTIONS)
    assert plan_ahead(BELIEF, ACTIONS) == plan_ahead(BELIEF, ACTIONS)
    assert BELIEF.to_json() == before


@settings(max_examples=20, deadline=None)
@given(st.floats(0, 0.2), st.floats(1, 60))
def test_a_higher_price_never_lowers_the_bar(price: float, seconds: float) -> None:
    action = (ActionModel("rub", RUB.sensors, seconds),)
    cheap, dear = plan(BELIEF, action, price=price), plan(BELIEF, action, price=price + 0.01)
    assert dear.scores[0].value < cheap.scores[0].value
    assert not (cheap.choice is None and dear.choice is not None)


def test_the_sensor_follows_what_the_estimator_reports() -> None:
    worse = SQUEEZE.observed(Measurement("elasticity", 5e4, 3e4, "Pa"))
    assert worse.sensors[0].noise(5e4) == pytest.approx(3e4)  # type: ignore[union-attr]
    assert WEIGH.observed(Measurement("elasticity", 5e4, 3e4, "Pa")) == WEIGH
    assert information_gain(BELIEF, worse.sensors) < information_gain(BELIEF, SQUEEZE.sensors)


def test_bad_repertoires_are_refused() -> None:
    for call, expected in (
        (lambda: plan(BELIEF, ACTIONS, price=math.nan), "price"),
        (lambda: plan(BELIEF, ACTIONS, price=-1.0), "price"),
        (lambda: plan(BELIEF, (WEIGH, WEIGH)), "different names"),
        (lambda: ActionModel("x", (), -1.0), "seconds"),
        (lambda: ActionModel("x", (), 1.0, repeat_cap=0), "repeat_cap"),
        (lambda: Sensor("mass", 0.0), "sd"),
        (lambda: Sensor("mass", math.inf), "sd"),
        (lambda: StopRules(confidence=0.0), "confidence"),
        (lambda: ClassSensor("material", ("a",), ("a", "b"), ((1.0,),)), "confusion"),
    ):
        with pytest.raises(InvalidInput, match=expected):
            call()
    with pytest.raises(UnknownName, match="colour"):
        plan(BELIEF, ACTIONS, "colour")
    with pytest.raises(UnknownName, match="colour"):
        plan(BELIEF, (ActionModel("x", (Sensor("colour", 1.0),), 1.0),))


# two steps ahead


def test_lookahead_pays_for_a_set_up_that_two_actions_share() -> None:
    """Each action alone teaches less than grasping costs; both together teach more."""
    belief = Belief(two_coins(0.25, 0.25))
    actions = tuple(ActionModel(n, (Sensor(n, 0.05),), 1.0, "grasp", 60.0, repeat_cap=1) for n in ("x", "y"))
    assert all(score.bits < 0.61 < 2 * score.bits for score in plan(belief, actions).scores)
    assert plan(belief, actions, price=0.01).stop == NOTHING_WORTH
    assert worthwhile(actions)
    ahead = decide(belief, actions, price=0.01)
    assert ahead == plan_ahead(belief, actions, price=0.01)
    assert ahead.choice in ("x", "y")
    assert ahead.score("x").value > 0


def test_lookahead_spends_a_budget_on_two_cheap_actions() -> None:
    """Greedy takes the dear action that eats the budget; two cheaper ones teach more together."""
    belief = Belief(two_coins(0.33, 0.33))
    cheap = tuple(ActionModel(n, (Sensor(n, 0.05),), 10.0, repeat_cap=1) for n in ("x", "y"))
    dear = ActionModel("x long", (Sensor("x", 0.001),), 20.0, repeat_cap=1)
    rules = StopRules(confidence=1.0, budget_seconds=20.0)
    actions = (*cheap, dear)
    assert plan(belief, actions, price=1e-4, rules=rules).choice == "x long"
    assert worthwhile(actions, rules=rules)
    assert plan_ahead(belief, actions, price=1e-4, rules=rules).choice in ("x", "y")


def test_lookahead_sees_no_need_without_set_ups_and_budgets() -> None:
    assert not worthwhile((RUB,))
    assert decide(BELIEF, (RUB,)) == plan(BELIEF, (RUB,))
    assert not worthwhile(ACTIONS, PlanState(setups=frozenset({"grasp"})))


def test_lookahead_values_are_at_least_greedy_ones() -> None:
    for one, two in zip(plan(BELIEF, ACTIONS).scores, plan_ahead(BELIEF, ACTIONS, outcomes=3).scores, strict=True):
        assert two.value >= one.value
        assert two.bits == one.bits


# baselines


def test_baselines() -> None:
    rng = np.random.default_rng(0)
    names = {random_choice(ACTIONS, PlanState(failed=frozenset({"rub"})), rng) for _ in range(50)}
    assert names == {"weigh", "squeeze"}
    order = ("rub", "weigh")
    assert fixed_choice(ACTIONS, PlanState(), order) == "rub"
    assert fixed_choice(ACTIONS, PlanState(done=("rub",)), order) == "weigh"
    assert fixed_choice(ACTIONS, PlanState(done=("rub", "weigh")), order) is None
    with pytest.raises(UnknownName, match="look"):
        fixed_choice(ACTIONS, PlanState(), ("look",))
    assert greedy_per_node(BELIEF, ACTIONS, PlanState()) in ("weigh", "squeeze")
    assert random_choice((), PlanState(), rng) is None
