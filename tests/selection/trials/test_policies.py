"""Policies choose what the planner and the baselines choose, one exploration at a time."""

from __future__ import annotations

import numpy as np
import pytest

from estimation.network import MATERIAL
from selection.baselines import greedy_per_node
from selection.lookahead import plan_ahead
from selection.planner import PlanState, StopRules, plan
from selection.trials.beliefs import Beliefs
from selection.trials.explore import Limits, Trace, explore
from selection.trials.harder import WORLDS, Entry, World, entries, without_messages
from selection.trials.objects import Luck, Objects, drawn
from selection.trials.policies import Emulating, Exact, Fixed, Lookahead, PerNode, Policy, Random

COSTS = next(world for world in WORLDS if world.name == "costs")


def ran(policy: Policy, world: World, count: int) -> tuple[Objects, Trace]:
    network = world.network
    objects = drawn(network, 3, range(count))
    luck = Luck(3, 1, range(count))
    return objects, explore(objects, Beliefs(network, count), world.actions, policy, luck, world.limits)[0]


@pytest.mark.parametrize("policy", [Exact(), Exact("both"), PerNode(), Lookahead(MATERIAL, 0.01, 60.0)])
def test_every_choice_is_the_one_of_the_planner(policy: Policy) -> None:
    """Along whole explorations, with prices, a shared set-up and a budget; and stops where the planner stops."""
    count = 2 if isinstance(policy, Lookahead) else 5
    objects, trace = ran(policy, COSTS, count)
    network, actions = COSTS.network, COSTS.actions
    rules = StopRules(confidence=1.0, budget_seconds=COSTS.budget_seconds)
    for i in range(count):
        together, state = Beliefs(network, 1), PlanState()
        for step in range(COSTS.limits.steps):
            belief = together.one(0)
            if isinstance(policy, Exact):
                choice = plan(belief, actions, policy.target, COSTS.price, state, rules).choice
            elif isinstance(policy, Lookahead):
                choice = plan_ahead(belief, actions, MATERIAL, COSTS.price, state, rules).choice
            else:
                choice = greedy_per_node(belief, actions, state, rules)
            index = next((k for k, action in enumerate(actions) if action.name == choice), -1)
            assert trace.choices[i, step] == index
            if index < 0:
                break
            state = state.after(actions[index])
            assert trace.seconds[i, step + 1] == pytest.approx(state.spent_seconds)
            sensor, row = actions[index].sensors[0], np.array([0])
            reading = objects.readings[actions[index].name][i : i + 1, 0]
            if actions[index].name in objects.sds:
                together.update(row, sensor.property, reading, sensor.sd)  # type: ignore[union-attr]
            else:
                together.update_output(row, sensor, reading)  # type: ignore[arg-type]


def test_fixed_goes_through_the_order_and_random_through_all() -> None:
    world = WORLDS[0]
    _, trace = ran(Fixed(), world, 2)
    assert trace.choices.tolist() == [list(range(7))] * 2
    _, trace = ran(Random(), world, 700)
    assert np.all(np.sort(trace.choices, axis=1) == np.arange(7))
    counts = np.bincount(trace.choices[:, 0], minlength=7)
    assert np.all(np.abs(counts - 100) < 4 * np.sqrt(100 * 6 / 7))


def test_mode_1_on_exact_beliefs_estimates_the_exact_gain() -> None:
    """Its sampling error at 100 samples is a few hundredths of a bit; the mean of many is the exact value."""
    world, count = WORLDS[0], 400
    beliefs, luck = Beliefs(world.network, count), Luck(0, 1, range(count))
    rows, done = np.arange(count), np.zeros((count, 7), dtype=int)
    sampled = Emulating(1).scores(beliefs, rows, world.actions, done, luck)
    exact = Exact().scores(beliefs, rows[:1], world.actions, done[:1], luck)[0]
    error = sampled.std(axis=0) / np.sqrt(count)
    assert np.all(np.abs(sampled.mean(axis=0) - exact) < 4 * error + 1e-9)
    assert sampled.std(axis=0).max() < 0.15


def test_a_budget_and_a_set_up_are_kept() -> None:
    for entry in (Entry(Random()), Entry(Fixed())):
        _, trace = ran(entry.policy, COSTS, 50)
        assert trace.seconds.max() <= COSTS.budget_seconds
        grasped = (trace.choices >= 0) & np.isin(trace.choices, [3, 4, 6])
        taken = np.array([*(a.seconds for a in COSTS.actions), 0.0])[trace.choices].sum(axis=1)
        assert np.allclose(trace.seconds[:, -1], taken + 10.0 * grasped.any(axis=1))


def test_results_do_not_depend_on_who_computes_them_together() -> None:
    world = WORLDS[1]
    network = world.network
    whole = ran(Random(), world, 20)[1]
    objects = drawn(network, 3, range(7, 12))
    part = explore(
        objects, Beliefs(network, 5), world.actions, Random(), Luck(3, 1, range(7, 12)), Limits(7), (MATERIAL,)
    )[0]
    assert np.array_equal(part.choices, whole.choices[7:12])
    assert np.array_equal(part.true, whole.true[7:12])


def test_without_messages_a_category_tells_nothing_of_the_material() -> None:
    network = WORLDS[0].network
    apart, row = Beliefs(without_messages(network), 1), np.array([0])
    together = Beliefs(network, 1)
    before = apart.probabilities("material")
    assert before == pytest.approx(together.probabilities("material"))
    for beliefs in (apart, together):
        beliefs.update_output(row, network.sensor("cat-vision"), np.array([6]))  # type: ignore[arg-type]
    assert apart.probabilities("material") == pytest.approx(before)
    assert np.abs(together.probabilities("material") - before).max() > 0.05


def test_entries_have_names_of_their_own() -> None:
    for world in WORLDS:
        names = [entry.name for entry in entries(world)]
        assert len(set(names)) == len(names)
