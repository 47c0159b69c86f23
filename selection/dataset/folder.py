"""The folder of a dataset: what it was made with, what is complete in it, and what is still to be explored."""

from __future__ import annotations

import fcntl
import hashlib
import os
import re
import shutil
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from pathlib import Path
from typing import Any, Self

from dynamics.errors import InvalidInput, PalpateError
from dynamics.tables import Table, read_toml
from estimation.parallel import in_parallel
from estimation.recording.files import CannotRecord, to_toml, write_atomically
from models import references
from selection.dataset.one import Job, Outcome, Setup, explore_object, keep_failure
from selection.result import versions

FORMAT = "palpate-dataset/1"
IDENTITY, OBJECTS = "dataset.toml", "objects"
_UNDERWAY = re.compile(r"\.(\d{6})\..+")

Work = Callable[[Job], Outcome]


class WorkersDie(PalpateError):
    """Processes end before they explore anything."""


class Dataset:
    """A folder of explorations, held by one process at a time.

    Args:
        root: the folder.
        setup: what all its objects share.
    """

    def __init__(self, root: Path, setup: Setup) -> None:
        self.root, self.setup = root, setup
        self._lock: int | None = None

    @classmethod
    def open(cls, root: Path, setup: Setup) -> Self:
        """Begin a dataset, or take it up again, and hold it until it is closed.

        Raises:
            InvalidInput: if something else is in the folder, it was made with something else, or another process
                holds it.
            CannotRecord: if it cannot be written.
        """
        if root.exists() and not root.is_dir():
            raise InvalidInput(f"--out {root}", "a file", "a folder")
        made = cls(root, setup)
        wanted = identity(setup)
        try:
            root.mkdir(parents=True, exist_ok=True)
            made._hold()
            if (root / IDENTITY).is_file():
                _compare(root / IDENTITY, wanted)
            elif all(path.name.startswith(f".{IDENTITY}") for path in root.iterdir()):
                write_atomically(root / IDENTITY, to_toml("dataset", wanted))
            else:
                raise InvalidInput(f"--out {root}", "something else", "a new folder, or one with a dataset")
            (root / OBJECTS).mkdir(exist_ok=True)
            made._clear()
        except OSError as error:
            made.close()
            raise CannotRecord(f"{root}: {error.strerror}; no dataset can be kept there") from error
        except PalpateError:
            made.close()
            raise
        return made

    def job(self, index: int) -> Job:
        """Return the job of an object."""
        return Job(self.root, index, self.setup)

    def missing(self, count: int) -> list[int]:
        """Return which of the first objects are not complete."""
        return [index for index in range(count) if not self.job(index).folder.exists()]

    def explore(
        self, count: int, workers: int = 0, scheduler: str = "", work: Work = explore_object
    ) -> Iterator[Outcome]:
        """Explore what is missing of the first objects; yield how each went, as it is done.

        An object on which a process dies is explored once more by a process of its own, and kept as a failure if
        that one dies too.

        Args:
            count: how many objects there are to be.
            workers, scheduler: as for `estimation.parallel.in_parallel`.
            work: explores one object.

        Raises:
            CannotRecord: if the disk does not take it.
            InvalidInput: for a scheduler that cannot be reached.
            WorkersDie: if they do, without an object to blame.
        """
        while missing := self.missing(count):
            try:
                for _, outcome in in_parallel(work, [self.job(i) for i in missing], workers, scheduler):
                    yield outcome
            except BrokenProcessPool:
                suspects = self._underway()
                if not suspects:
                    raise WorkersDie("the worker processes end before they explore anything") from None
                for index in suspects:
                    yield self._alone(work, index)

    def close(self) -> None:
        """Let other processes have it; what was under way is removed."""
        if self._lock is not None:
            self._clear()
            os.close(self._lock)
            self._lock = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _hold(self) -> None:
        self._lock = os.open(self.root, os.O_RDONLY)
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(self._lock)
            self._lock = None
            raise InvalidInput(
                f"--out {self.root}", "another process at work in it", "a folder for itself"
            ) from None

    def _clear(self) -> None:
        """Remove what a process that ended has left unfinished."""
        for path in (self.root / OBJECTS).glob(".*"):
            if _UNDERWAY.fullmatch(path.name):
                shutil.rmtree(path, ignore_errors=True)

    def _underway(self) -> list[int]:
        """Return the objects that were being explored when the processes ended."""
        found = (_UNDERWAY.fullmatch(path.name) for path in (self.root / OBJECTS).iterdir())
        return sorted({int(match[1]) for match in found if match})

    def _alone(self, work: Work, index: int) -> Outcome:
        job = self.job(index)
        try:
            with ProcessPoolExecutor(1, get_context("spawn")) as pool:
                return pool.submit(work, job).result()
        except BrokenProcessPool:
            self._clear()
            folder = job.folder.with_name(f".{index:06d}.died")
            folder.mkdir()
            message = "the process that explored it ended without a word"
            keep_failure(folder, "ProcessDied", message)
            os.rename(folder, job.folder)
            return Outcome(index, (), message)


def identity(setup: Setup) -> dict[str, Any]:
    """Return what decides, with an object's number, everything that is in its folder."""
    return {
        "format": FORMAT,
        "seed": setup.seed,
        "reference": setup.reference,
        "reference_sha256": _digest(references.locate(setup.reference)),
        "noise": setup.noise,
        "noise_sha256": _digest(Path(setup.noise)) if Path(setup.noise).is_file() else "",
        "price_bits_per_s": setup.price,
        "confidence": setup.confidence,
        "budget_s": setup.budget,
        "poisson": setup.poisson,
        "versions": versions(),
    }


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _compare(path: Path, wanted: dict[str, Any]) -> None:
    """Refuse a dataset that was made with something else, naming the first difference."""
    found = read_toml(path)
    Table(str(path), found)
    flat, asked = ({**d, **d.get("versions", {})} for d in (found, wanted))
    for key, value in asked.items():
        if key != "versions" and flat.get(key) != value:
            raise InvalidInput(f"{path}: {key}", flat.get(key), f"{value!r}, or another --out")
