"""The virtual study (thesis section 4.1): every policy in every context, many times."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

from estimation.network import Network
from selection.trials.cells import Cell, cell_of
from selection.trials.explore import Trace
from selection.trials.protocol import CONTEXTS, policies, virtual_trials
from selection.trials.sweep import Arrays, Machines, Progress, Store, pieces, sweep
from selection.trials.thesis_figures import printed
from selection.trials.thesis_learning import ThesisMode

REFERENCE = "thesis-3.1-erratum"
CHUNK = 200


@dataclass(frozen=True)
class VirtualJob:
    """Some trials of one cell.

    Attributes:
        reference: name of the network.
        context: index of the context.
        policy: index of the policy.
        first, count: trials.
        seed: of the study.
    """

    reference: str
    context: int
    policy: int
    first: int
    count: int
    seed: int

    @property
    def name(self) -> str:
        """What tells it from every other chunk."""
        return f"virtual-{self.context}-{self.policy}-{self.first}-{self.count}"


def run_job(job: VirtualJob) -> Arrays:
    """Run a chunk."""
    network = Network.from_file(job.reference)
    policy = policies(network)[job.policy]
    trials = range(job.first, job.first + job.count)
    return virtual_trials(network, CONTEXTS[job.context], policy, trials, job.seed).arrays()


def virtual_study(
    repetitions: int,
    seed: int,
    store: Store | None = None,
    machines: Machines | None = None,
    progress: Progress | None = None,
) -> tuple[Cell, ...]:
    """Run the study; the same seed gives the same cells on any machines.

    Args:
        repetitions: trials of every cell.
        seed: of everything random.
        store, machines, progress: as for `sweep`.
    """
    network = Network.from_file(REFERENCE)
    jobs = [
        VirtualJob(REFERENCE, context, policy, first, count, seed)
        for policy in range(len(policies(network)))
        for context in range(len(CONTEXTS))
        for first, count in pieces(repetitions, CHUNK)
    ]
    parts: defaultdict[tuple[int, int], list[Arrays]] = defaultdict(list)
    for job, arrays in zip(jobs, sweep("virtual", run_job, jobs, store, machines, progress), strict=True):
        parts[job.policy, job.context].append(arrays)
    names = [name for name, _ in network.sensors]
    cells = []
    for (number, place), arrays_of_cell in parts.items():
        policy, context = policies(network)[number], CONTEXTS[place]
        thesis = ("", "")
        if isinstance(policy, ThesisMode):
            own = printed("virtual", policy.mode, context.prior, context.measurement)
            thesis = (own.text, own.source)
        trace = Trace.of(arrays_of_cell)
        cells.append(cell_of("virtual", policy.name, (context.prior, context.measurement), trace, names, thesis))
    return tuple(cells)
