"""Sweeps: taken up where they were interrupted, the same on any number of workers."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from dynamics.errors import InvalidInput
from selection.trials.explore import Trace
from selection.trials.sweep import Arrays, Machines, Quiet, Store, pieces, sweep
from selection.trials.virtual_study import REFERENCE, VirtualJob, run_job, virtual_study

JOBS = [VirtualJob(REFERENCE, context, 0, first, 3, 5) for context in (0, 4) for first in (0, 3)]


@dataclass
class Counter(Quiet):
    """Counts chunks."""

    done: int = 0

    def advances(self) -> None:
        self.done += 1


class Interrupted(Exception):
    """As by a person."""


class Impatient(Counter):
    """Interrupts after two chunks."""

    def advances(self) -> None:
        super().advances()
        if self.done == 2:
            raise Interrupted


def same(first: list[Arrays], second: list[Arrays]) -> bool:
    return all(np.array_equal(a[key], b[key]) for a, b in zip(first, second, strict=True) for key in a)


def test_what_is_on_disk_is_not_computed_again(tmp_path: Path) -> None:
    store = Store(tmp_path, "seed 5")
    with pytest.raises(Interrupted):
        sweep("", run_job, JOBS, store, Machines(1), Impatient())
    assert len(list(tmp_path.glob("*.npz"))) == 2
    rest = Counter()
    found = sweep("", run_job, JOBS, Store(tmp_path, "seed 5"), Machines(1), rest)
    assert rest.done == 2
    assert same(found, sweep("", run_job, JOBS, machines=Machines(1)))


def test_workers_do_not_change_the_numbers() -> None:
    assert same(sweep("", run_job, JOBS, machines=Machines(2)), sweep("", run_job, JOBS, machines=Machines(1)))


def test_chunks_do_not_change_the_numbers() -> None:
    whole = run_job(VirtualJob(REFERENCE, 4, 0, 0, 6, 5))
    halves = Trace.of([run_job(VirtualJob(REFERENCE, 4, 0, first, 3, 5)) for first in (0, 3)])
    for key, array in halves.arrays().items():
        assert np.allclose(whole[key], array, rtol=0, atol=1e-13), key


def test_a_torn_chunk_is_computed_again(tmp_path: Path) -> None:
    store = Store(tmp_path, "seed 5")
    expected = sweep("", run_job, JOBS[:1], store, Machines(1))
    path = next(tmp_path.glob("*.npz"))
    path.write_bytes(path.read_bytes()[:100])
    again = Counter()
    assert same(sweep("", run_job, JOBS[:1], store, Machines(1), again), expected)
    assert again.done == 1


def test_other_settings_are_not_mixed_in(tmp_path: Path) -> None:
    Store(tmp_path, "seed 5")
    with pytest.raises(InvalidInput, match="seed 5"):
        Store(tmp_path, "seed 6")


def test_pieces_cover_everything_once() -> None:
    for count in (1, 199, 200, 201, 1000):
        covered = [trial for first, size in pieces(count, 200) for trial in range(first, first + size)]
        assert covered == list(range(count))


def test_more_repetitions_keep_the_ones_before() -> None:
    """The first trials of a larger study are those of a smaller one."""
    few, many = run_job(VirtualJob(REFERENCE, 1, 0, 0, 4, 5)), run_job(VirtualJob(REFERENCE, 1, 0, 0, 8, 5))
    assert np.array_equal(few["choices"], many["choices"][:4])
    cells = virtual_study(2, 0, machines=Machines(1))
    assert {cell.trials for cell in cells} == {2}
    assert all(cell.correct + cell.weak + cell.diverged + cell.undecided == 2 for cell in cells)


def test_a_cluster_does_not_change_the_numbers() -> None:
    distributed = pytest.importorskip("distributed")
    options = {"n_workers": 1, "threads_per_worker": 1, "processes": False, "dashboard_address": None}
    with distributed.LocalCluster(**options) as cluster:
        there = sweep("", run_job, JOBS, machines=Machines(scheduler=cluster.scheduler_address))
    assert same(there, sweep("", run_job, JOBS, machines=Machines(1)))
