"""Sweeps: many independent chunks of trials, on all cores or a cluster, that can be interrupted and taken up."""

from __future__ import annotations

import io
import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, TypeVar
from zipfile import BadZipFile

import numpy as np

from dynamics.errors import InvalidInput
from estimation.parallel import in_parallel

Arrays = Mapping[str, np.ndarray]
_UNFIT = re.compile(r"[^A-Za-z0-9._-]+")


class Job(Protocol):
    """One chunk of trials, complete in itself and fit to be sent elsewhere."""

    @property
    def name(self) -> str:
        """What tells it from every other chunk of the sweep."""
        ...


AnyJob = TypeVar("AnyJob", bound=Job)


@dataclass(frozen=True)
class Machines:
    """Where chunks are computed.

    Attributes:
        workers: processes; 0 for one a core.
        scheduler: address of a Dask scheduler instead.
    """

    workers: int = 0
    scheduler: str = ""


class Progress(Protocol):
    """Is told how a sweep goes."""

    def begins(self, title: str, total: int, done: int) -> AbstractContextManager[None]:
        """Show a sweep, of which some chunks are on disk already."""
        ...

    def advances(self) -> None:
        """Count one more chunk."""
        ...


class Quiet:
    """Shows nothing."""

    def begins(self, title: str, total: int, done: int) -> AbstractContextManager[None]:
        """Show nothing."""
        return nullcontext()

    def advances(self) -> None:
        """Show nothing."""


class Store:
    """Finished chunks on disk, each whole or not there.

    Args:
        directory: where they lie; it is made.
        settings: what all of them depend on, in words; chunks of other settings are not mixed in.

    Raises:
        InvalidInput: if the directory holds chunks of other settings.
    """

    def __init__(self, directory: Path, settings: str) -> None:
        from estimation.recording.files import write_atomically

        self._directory = directory
        directory.mkdir(parents=True, exist_ok=True)
        note = directory / "settings.txt"
        if note.exists() and note.read_text(encoding="utf-8") != settings:
            raise InvalidInput(
                f"{directory}: chunks of", note.read_text(encoding="utf-8"), f"{settings}, or another --out"
            )
        if not note.exists():
            write_atomically(note, settings)

    def load(self, name: str) -> Arrays | None:
        """Return a finished chunk, or None; one that cannot be read counts as not there."""
        try:
            with np.load(io.BytesIO(self._path(name).read_bytes()), allow_pickle=False) as file:
                return {key: file[key] for key in file.files}
        except (OSError, ValueError, EOFError, KeyError, BadZipFile):
            return None

    def save(self, name: str, arrays: Arrays) -> None:
        """Keep a finished chunk."""
        path = self._path(name)
        content = io.BytesIO()
        np.savez_compressed(content, **dict(arrays))  # type: ignore[arg-type]
        draft = path.with_name(f".{path.name}.{os.getpid()}.tmp")
        with draft.open("wb") as file:
            file.write(content.getvalue())
            file.flush()
            os.fsync(file.fileno())
        os.replace(draft, path)

    def _path(self, name: str) -> Path:
        return self._directory / f"{_UNFIT.sub('-', name)}.npz"


def sweep(
    title: str,
    work: Callable[[AnyJob], Arrays],
    jobs: Sequence[AnyJob],
    store: Store | None = None,
    machines: Machines | None = None,
    progress: Progress | None = None,
) -> list[Arrays]:
    """Compute every chunk that is not on disk yet, and return all, in the order of the jobs.

    Args:
        title: what to show.
        work: a function of a module; its result depends on its job alone.
        jobs: the chunks.
        store: where finished ones are kept; nowhere if None.
        machines: where they are computed.
        progress: is told.
    """
    machines, progress = machines or Machines(), progress or Quiet()
    found: list[Arrays | None] = [store.load(job.name) if store else None for job in jobs]
    missing = [number for number, arrays in enumerate(found) if arrays is None]
    with progress.begins(title, len(jobs), len(jobs) - len(missing)):
        for place, arrays in _computed(work, [jobs[number] for number in missing], machines):
            number = missing[place]
            found[number] = arrays
            if store:
                store.save(jobs[number].name, arrays)
            progress.advances()
    return [arrays for arrays in found if arrays is not None]


def _computed(
    work: Callable[[AnyJob], Arrays], jobs: Sequence[AnyJob], machines: Machines
) -> Iterator[tuple[int, Arrays]]:
    if jobs:
        yield from in_parallel(work, jobs, machines.workers, machines.scheduler)


def pieces(count: int, size: int) -> list[tuple[int, int]]:
    """Return (first trial, number of trials) of chunks that cover so many trials."""
    return [(first, min(size, count - first)) for first in range(0, count, size)]
