"""The studies that the command line runs, one after the other, each with its chunks on disk."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from estimation.network import Network
from selection.trials.cells import Cell
from selection.trials.first_actions import FirstAction, first_actions, real_first_actions
from selection.trials.policies import Exact
from selection.trials.result_tables import LearningCurve, ResultTable
from selection.trials.specimens import reference_ab
from selection.trials.sweep import Machines, Progress, Store
from selection.trials.tables import accuracy_table, cell_tables, first_action_tables
from selection.trials.thesis_learning import ThesisMode

REPETITIONS = {"virtual": 400, "simulation": 20, "emulator": 20}
EXPLORATIONS = 1
"""Whole explorations of every simulated object."""
_DRAWS = 50


@dataclass(frozen=True)
class Request:
    """What is asked for.

    Attributes:
        directory: where chunks and tables go.
        repetitions: trials of a cell; None for each study's own number.
        objects: virtual objects of the harder worlds.
        readings: simulated readings of every action on every object.
        seed: of everything random.
        machines: where it is computed.
    """

    directory: Path
    repetitions: int | None = None
    objects: int = 1000
    readings: int = 6
    seed: int = 0
    machines: Machines = field(default_factory=Machines)

    def trials(self, study: str) -> int:
        """Return the trials of a cell."""
        return self.repetitions or REPETITIONS[study]

    def store(self, study: str, settings: str = "") -> Store:
        """Return where a study's chunks are kept."""
        return Store(self.directory / "chunks" / study, f"{study}, seed {self.seed}{settings}")


@dataclass(frozen=True)
class Outcome:
    """What the studies came to.

    Attributes:
        cells: every cell of the thesis' protocol.
        tables: everything as tables.
        curves: learning curves.
        found: what they found, a sentence or two each.
        settings: pairs of what was asked for and how much of it.
    """

    cells: tuple[Cell, ...] = ()
    tables: tuple[ResultTable, ...] = ()
    curves: tuple[LearningCurve, ...] = ()
    found: tuple[str, ...] = ()
    settings: tuple[tuple[str, str], ...] = ()

    def __add__(self, other: Outcome) -> Outcome:
        """Return both."""
        pairs = zip(vars(self).values(), vars(other).values(), strict=True)
        return Outcome(*(own + others for own, others in pairs))


def run_studies(names: Sequence[str], request: Request, progress: Progress) -> Outcome:
    """Run studies by name; what is on disk already is not computed again.

    Raises:
        InvalidInput: if the directory holds chunks of another seed, or there is no such cluster.
        CannotRecord: if nothing can be written there.
    """
    outcome = Outcome(settings=(("seed", str(request.seed)),))
    for name in names:
        outcome += _STUDIES[name](request, progress)
        outcome += Outcome(settings=((f"{name}: trials of a cell", str(request.trials(name))),))
    letters = first_action_tables(_simulated_letters(request.seed), _real_letters(request.seed))
    return replace(outcome, tables=(*outcome.tables, *letters, accuracy_table(outcome.cells)))


def _virtual(request: Request, progress: Progress) -> Outcome:
    from selection.trials.harder import harder_study
    from selection.trials.harder_tables import harder_curves, harder_tables, verdict
    from selection.trials.virtual_study import virtual_study

    store = request.store("virtual")
    cells = virtual_study(request.trials("virtual"), request.seed, store, request.machines, progress)
    results = harder_study(request.objects, request.seed, store, request.machines, progress)
    tables = (*cell_tables(cells, "virtual"), *harder_tables(results))
    first = [result for result in results if result.world == results[0].world]
    settings = (("objects of the harder worlds", str(request.objects)),)
    return Outcome(cells, tables, harder_curves(results), (verdict(first),), settings)


def _simulation(request: Request, progress: Progress) -> Outcome:
    from selection.trials import simulation_study as study
    from selection.trials.simulation_tables import object_table, policy_table

    machines, repetitions = request.machines, request.trials("simulation")
    bank_store = request.store("simulation")
    bank = study.bank_for(
        max(request.readings, 2), max(request.readings // 2, 1), request.seed, bank_store, machines, progress
    )
    cells = study.protocol_cells(bank, repetitions, request.seed)
    size = f", {request.readings} readings"
    replays = study.replayed_explorations(
        bank, repetitions, request.seed, request.store(f"replays-{request.readings}", size), machines, progress
    )
    whole = study.full_explorations(EXPLORATIONS, request.seed, bank_store, machines, progress)
    common = (
        "Readings were simulated once, with full physics and default noise "
        f"({max(request.readings // 2, 1)} of every action on every object), and are replayed in an order drawn "
        "for every repetition: all policies meet the same ones, and repetitions are not independent of each other."
    )
    tables = (
        *cell_tables(cells, "simulation"),
        policy_table("simulation-policies", "Explorations of simulated objects, by policy", replays, common),
        object_table(
            "simulation-objects",
            "The exact criterion about the material, by object",
            replays["exact, material"],
            common,
        ),
        object_table(
            "simulation-whole",
            "Whole explorations with full physics, by object",
            whole,
            study.said_of(whole),
        ),
    )
    settings = (("simulated readings of A and B, of each action", str(max(request.readings, 2))),)
    return Outcome(cells, tables, found=(study.said_of(whole),), settings=settings)


def _emulator(request: Request, progress: Progress) -> Outcome:
    from selection.trials.emulator_study import emulator_bank, emulator_cells

    store, turns = request.store("emulator"), max(request.readings // 2, 1)
    bank = emulator_bank(turns, request.seed, store, request.machines, progress)
    cells = emulator_cells(bank, request.trials("emulator"), request.seed)
    return Outcome(cells, cell_tables(cells, "emulator"))


_STUDIES = {"virtual": _virtual, "simulation": _simulation, "emulator": _emulator}


def _compared() -> tuple[ThesisMode | Exact, ...]:
    return (*(ThesisMode(mode) for mode in (1, 2, 3)), Exact("material"), Exact("everything"))


def _simulated_letters(seed: int) -> list[tuple[FirstAction, ...]]:
    return [first_actions(reference_ab(), policy, _DRAWS, seed) for policy in _compared()]


def _real_letters(seed: int) -> list[tuple[FirstAction, ...]]:
    network = Network.from_file("thesis-3.2")
    return [real_first_actions(network, policy, _DRAWS, seed) for policy in _compared()]
