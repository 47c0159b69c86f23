"""The simulated study (thesis section 4.2): materials A and B in six contexts, and whole explorations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from estimation.network import Network
from selection.trials.bank import Bank, simulated_bank, values_of
from selection.trials.cells import Cell, cell_of
from selection.trials.explore import Trace
from selection.trials.objects import Objects, trial_rng
from selection.trials.protocol import CONTEXTS, STEPS, policies, prior_of, run_cell, with_errors
from selection.trials.replay import CONFIDENCE, POLICIES, PRICE, ReplayJob, traced
from selection.trials.replay import STEPS as MOST_STEPS
from selection.trials.replay import run_job as run_replay
from selection.trials.simulation_tables import verdict
from selection.trials.specimens import EDGE, REFERENCE, A, B, Specimen, listed, novel, on_disk, reference_ab
from selection.trials.sweep import Arrays, Machines, Progress, Store, sweep
from selection.trials.thesis_figures import printed
from selection.trials.thesis_learning import ThesisMode

ACTIONS = ("weigh", "squeeze")
MEASURES = {"weigh": "mass", "squeeze": "elasticity"}


def bank_for(
    turns_ab: int, turns: int, seed: int, store: Store | None, machines: Machines | None, progress: Progress | None
) -> Bank:
    """Return readings of materials A and B, of every listed soft object and of the novel ones."""
    ab = simulated_bank((A, B), ACTIONS, turns_ab, seed, store, machines, progress)
    return ab | simulated_bank((*listed(), *novel()), ACTIONS, turns, seed, store, machines, progress)


def protocol_cells(bank: Bank, repetitions: int, seed: int) -> tuple[Cell, ...]:
    """Run the thesis' protocol over the readings of A and B; the truth alternates.

    Args:
        bank: readings of A and B.
        repetitions: trials of every cell.
        seed: of the order of the readings, and of the modes that sample.
    """
    network = reference_ab()
    cells = []
    for policy in policies(network):
        for context in CONTEXTS:
            thesis = ("", "")
            if isinstance(policy, ThesisMode):
                own = printed("simulation", policy.mode, context.prior, context.measurement)
                thesis = (own.text, own.source)
            traces = []
            for truth in range(2):
                trials = range(truth, repetitions, 2)
                world = with_errors(network, context, truth)
                objects = replayed(world, bank, truth, trials, seed)
                prior = prior_of(network, context, truth)
                traces.append(run_cell(world, objects, prior, policy, trials, seed) if len(trials) else None)
            trace = Trace.of([part.arrays() for part in traces if part is not None])
            where = (context.prior, context.measurement)
            cells.append(cell_of("simulation", policy.name, where, trace, ACTIONS, thesis))
    return tuple(cells)


def replayed(world: Network, bank: Bank, truth: int, trials: Sequence[int], seed: int) -> Objects:
    """Return A or B as its simulated readings make it, in an order of its own in every trial."""
    name = (A, B)[truth].name
    readings, sds = {}, {}
    for place, action in enumerate(ACTIONS):
        values = values_of(bank, name, action, MEASURES[action])
        if action == "weigh":
            values = values / EDGE**3
        orders = [trial_rng(seed, 8 + place, trial).permutation(len(values)) for trial in trials]
        turns = np.arange(STEPS) % len(values)
        readings[action] = np.stack([values[order[turns]] for order in orders])
        sensor = world.sensor(action)
        sds[action] = np.full((len(trials), STEPS), sensor.sd)  # type: ignore[union-attr]
    return Objects(world, np.full(len(trials), truth), np.zeros(len(trials), dtype=int), readings, sds)


def replayed_explorations(
    bank: Bank,
    repetitions: int,
    seed: int,
    store: Store | None = None,
    machines: Machines | None = None,
    progress: Progress | None = None,
) -> dict[str, dict[str, Trace]]:
    """Explore every listed and every novel object with every policy, over the same readings.

    Returns:
        Traces by policy and by name of the object.
    """
    jobs = [
        ReplayJob(specimen, policy, 0, repetitions, seed, tuple((a, bank[specimen.name, a]) for a in ACTIONS))
        for policy in POLICIES
        for specimen in (*listed(), *novel())
    ]
    found: dict[str, dict[str, Trace]] = {}
    for job, arrays in zip(jobs, sweep("replays", run_replay, jobs, store, machines, progress), strict=True):
        found.setdefault(job.policy, {})[job.specimen.name] = Trace.of([arrays])
    return found


@dataclass(frozen=True)
class ExplorationJob:
    """One exploration with full physics from beginning to end, as `python -m selection.run` does it."""

    specimen: Specimen
    seed: int

    @property
    def name(self) -> str:
        """What tells it from every other one."""
        return f"exploration-{self.specimen.name}-{self.seed}"


def run_exploration(job: ExplorationJob) -> Arrays:
    """Explore an object in the simulation."""
    from dynamics.objects import read_declared
    from selection.display import Silent
    from selection.exploration import Exploration, Settings
    from selection.robots import RobotRequest, open_robot

    network = Network.from_file(REFERENCE)
    with on_disk(job.specimen) as path:
        robot = open_robot("sim", RobotRequest(path, seed=job.seed)).robot
        declared = read_declared(path)
    try:
        settings = Settings(price=PRICE, confidence=CONFIDENCE)
        exploration = Exploration(robot, declared, network, None, settings, Silent())
        beliefs, seconds, choices = [exploration.belief], [0.0], np.full(MOST_STEPS, -1)
        while not exploration.stopped_because and len(beliefs) <= MOST_STEPS:
            exploration.step()
            if len(exploration.steps) == len(beliefs):
                name = exploration.steps[-1].action
                choices[len(beliefs) - 1] = ACTIONS.index(name) if name in ACTIONS else len(ACTIONS)
                beliefs.append(exploration.belief)
                seconds.append(exploration.seconds)
        found = traced(job.specimen, network, beliefs, seconds, choices)
        return {key: np.asarray(value)[None] for key, value in found.items()}
    finally:
        robot.close()


def full_explorations(
    runs: int,
    seed: int,
    store: Store | None = None,
    machines: Machines | None = None,
    progress: Progress | None = None,
) -> dict[str, Trace]:
    """Explore every listed and every novel object from beginning to end; returns traces by name of the object."""
    jobs = [
        ExplorationJob(specimen, 1000 * seed + run + 1)
        for run in range(runs)
        for specimen in (*listed(), *novel())
    ]
    found: dict[str, list[Arrays]] = {}
    results = sweep("explorations", run_exploration, jobs, store, machines, progress)
    for job, arrays in zip(jobs, results, strict=True):
        found.setdefault(job.specimen.name, []).append(arrays)
    return {name: Trace.of(parts) for name, parts in found.items()}


def said_of(whole: Mapping[str, Trace]) -> str:
    """Say what whole explorations came to."""
    return verdict("whole explorations", Trace.of([trace.arrays() for trace in whole.values()]))
