"""Whole explorations over a bank of simulated readings: every policy decides anew, nothing is simulated again."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from dynamics.objects import read_declared
from estimation.belief import Belief
from estimation.conclude import conclude
from estimation.measurement import Measurement
from estimation.network import MATERIAL, UNKNOWN, Network
from estimation.size import SizeEstimate
from selection.baselines import fixed_choice, greedy_per_node, random_choice
from selection.lookahead import plan_ahead
from selection.planner import ActionModel, PlanState, StopRules, plan
from selection.trials.bank import Reading
from selection.trials.objects import trial_rng
from selection.trials.specimens import REFERENCE, Specimen, on_disk
from selection.trials.sweep import Arrays

POLICIES = ("exact, material", "exact, everything", "two steps ahead", "per node", "fixed order", "random")
PRICE, CONFIDENCE = 0.005, 0.99
"""As `python -m selection.run` has them."""
STEPS = 6


@dataclass(frozen=True)
class ReplayJob:
    """Explorations of one object by one policy.

    Attributes:
        specimen: the object.
        policy: one of `POLICIES`.
        first, count: trials.
        seed: of the study.
        bank: readings of every action.
    """

    specimen: Specimen
    policy: str
    first: int
    count: int
    seed: int
    bank: tuple[tuple[str, tuple[Reading, ...]], ...]

    @property
    def name(self) -> str:
        """What tells it from every other chunk."""
        return f"replay-{self.specimen.name}-{self.policy}-{self.first}-{self.count}"


def run_job(job: ReplayJob) -> Arrays:
    """Explore an object again and again, each time with its readings in another order."""
    network = Network.from_file(REFERENCE)
    bank = dict(job.bank)
    found = []
    for trial in range(job.first, job.first + job.count):
        orders = {
            name: trial_rng(job.seed, 6, trial).permutation(len(readings)).tolist()
            for name, readings in bank.items()
        }
        readings = {name: tuple(bank[name][i] for i in order) for name, order in orders.items()}
        rng = trial_rng(job.seed, 7, trial)
        found.append(explore_readings(network, job.specimen, readings, job.policy, rng))
    return {key: np.stack([one[key] for one in found]) for key in found[0]}


def explore_readings(
    network: Network,
    specimen: Specimen,
    readings: Mapping[str, Sequence[Reading]],
    policy: str,
    rng: np.random.Generator,
) -> Arrays:
    """Explore an object by its readings; returns one row of every array of a `Trace`.

    Args:
        network: the reference.
        specimen: the object.
        readings: by action, in the order in which they come; the first again after the last.
        policy: one of `POLICIES`.
        rng: for the policy.
    """
    from selection.actions import ACTIONS

    with on_disk(specimen) as path:
        blank, size = Belief(network), SizeEstimate.declared(read_declared(path))
    found = ((action.name, action.model(network)) for action in ACTIONS if action.name in readings)
    models = {name: model for name, model in found if model is not None}
    names = list(models)
    measured: list[Measurement] = []
    state = PlanState()
    choices = np.full(STEPS, -1)
    beliefs, seconds = [conclude(blank, size, ())], [0.0]
    for step in range(STEPS):
        choice = _choice(policy, beliefs[-1], tuple(models.values()), state, rng)
        if choice is None:
            break
        choices[step] = names.index(choice)
        turn = state.done.count(choice)
        reading = readings[choice][turn % len(readings[choice])]
        if reading.failure:
            state = state.failing(models[choice], reading.seconds)
        else:
            for measurement in reading.measurements:
                if measurement.property == "width":
                    size = size.with_edge(reading.edge, measurement)
                else:
                    measured.append(measurement)
                    models[choice] = models[choice].observed(measurement)
            timed = max(reading.seconds - models[choice].setup_seconds, 0.0)
            models[choice] = replace(models[choice], seconds=timed)
            state = replace(state.after(models[choice], reading.seconds), setups=frozenset())
        beliefs.append(conclude(blank, size, measured))
        seconds.append(state.spent_seconds)
    return traced(specimen, network, beliefs, seconds, choices)


def traced(
    specimen: Specimen, network: Network, beliefs: Sequence[Belief], seconds: Sequence[float], choices: np.ndarray
) -> Arrays:
    """Return beliefs after 0, 1, ... actions as one row of every array of a `Trace`; the last one stays."""
    truth = material_of(specimen, network)
    rows = [belief.probabilities(MATERIAL) for belief in beliefs]
    rows += [rows[-1]] * (len(choices) + 1 - len(rows))
    best = [max(row, key=row.__getitem__) for row in rows]
    spent = [*seconds, *[seconds[-1]] * (len(choices) + 1 - len(seconds))]
    return {
        "choices": choices,
        "seconds": np.array(spent),
        "true": np.array([row[truth] for row in rows]),
        "top": np.array([max(row.values()) for row in rows]),
        "right": np.array([name == truth for name in best]),
        "unknown": np.array([name == UNKNOWN for name in best]),
        "novel": np.array(specimen.novel),
    }


def material_of(specimen: Specimen, network: Network) -> str:
    """Return the class that an object truly has in a reference."""
    name = tomllib.loads(specimen.text)["truth"].get("material", UNKNOWN)
    return name if name in network.materials else UNKNOWN


def _choice(
    policy: str, belief: Belief, actions: tuple[ActionModel, ...], state: PlanState, rng: np.random.Generator
) -> str | None:
    rules = StopRules(CONFIDENCE)
    if policy.startswith("exact"):
        return plan(belief, actions, policy.removeprefix("exact, "), PRICE, state, rules).choice
    if policy == "two steps ahead":
        return plan_ahead(belief, actions, MATERIAL, PRICE, state, rules).choice
    if max(belief.probabilities(MATERIAL).values()) >= CONFIDENCE:
        return None
    if policy == "per node":
        return greedy_per_node(belief, actions, state, rules)
    if policy == "fixed order":
        return fixed_choice(actions, state, [action.name for action in actions] * STEPS, rules)
    return random_choice(actions, state, rng, rules)
