"""The thesis' real-world protocol (section 4.3) with the cubes of its Table 3.2, through the Kortex emulator.

The arm is simulated; nothing here was measured on a real one.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from estimation.network import Network
from models import objects as object_files
from selection.trials.bank import Bank, simulated_bank, values_of
from selection.trials.cells import Cell, cell_of
from selection.trials.explore import Trace
from selection.trials.objects import Objects, trial_rng
from selection.trials.protocol import CONTEXTS, JOKER_WEIGHT, policies, prior_of, run_cell
from selection.trials.specimens import EDGE, Specimen
from selection.trials.sweep import Machines, Progress, Store
from selection.trials.thesis_figures import printed
from selection.trials.thesis_learning import ThesisMode

REFERENCE = "thesis-3.2"
STEPS, AVERAGED = 3, 3
"""Steps of the algorithm, and samples that the thesis averaged for each of its measurements."""
ACTIONS = {"weigh": "mass", "squeeze": "elasticity"}


def cubes() -> tuple[Specimen, ...]:
    """Return the cubes of Table 3.2, in the order of the reference's materials."""
    names = Network.from_file(REFERENCE).materials
    return tuple(Specimen(name, object_files.locate(name).read_text(encoding="utf-8")) for name in names)


def emulator_bank(
    turns: int, seed: int, store: Store | None, machines: Machines | None, progress: Progress | None
) -> Bank:
    """Weigh and squeeze every cube through the emulator, in real time."""
    return simulated_bank(cubes(), tuple(ACTIONS), turns, seed, store, machines, progress, "emulator")


def emulator_cells(bank: Bank, repetitions: int, seed: int) -> tuple[Cell, ...]:
    """Run the protocol over the readings: three priors, three steps, every measurement the mean of three samples.

    Args:
        bank: readings of the cubes; samples are drawn from them with replacement.
        repetitions: trials of every cell; the true cube goes round.
        seed: of the draws.
    """
    network = Network.from_file(REFERENCE).with_unknown(JOKER_WEIGHT)
    count = len(network.materials)
    cells = []
    for policy in policies(network):
        for context in CONTEXTS[: len(CONTEXTS) // 2]:
            thesis = ("", "")
            if isinstance(policy, ThesisMode):
                own = printed("real", policy.mode, context.prior)
                thesis = (own.text, own.source)
            traces = []
            for truth in range(min(count, repetitions)):
                trials = range(truth, repetitions, count)
                things = averaged(network, bank, truth, trials, seed)
                prior = prior_of(network, context, truth)
                traces.append(run_cell(network, things, prior, policy, trials, seed, STEPS))
            trace = Trace.of([part.arrays() for part in traces])
            cells.append(cell_of("emulator", policy.name, (context.prior, ""), trace, tuple(ACTIONS), thesis))
    return tuple(cells)


def averaged(network: Network, bank: Bank, truth: int, trials: Sequence[int], seed: int) -> Objects:
    """Return a cube as means of its samples make it."""
    name = network.materials[truth]
    readings, sds = {}, {}
    for place, (action, quantity) in enumerate(ACTIONS.items()):
        values = values_of(bank, name, action, quantity)
        if action == "weigh":
            values = values / EDGE**3
        picks = [
            trial_rng(seed, 10 + place, trial).integers(len(values), size=(STEPS, AVERAGED)) for trial in trials
        ]
        readings[action] = np.stack([values[pick].mean(axis=1) for pick in picks])
        sds[action] = np.full((len(trials), STEPS), network.sensor(action).sd)  # type: ignore[union-attr]
    return Objects(network, np.full(len(trials), truth), np.zeros(len(trials), dtype=int), readings, sds)
