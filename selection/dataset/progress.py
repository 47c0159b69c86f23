"""What a person sees while a dataset grows: a bar with the time that is left, or a line an object."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Protocol, TextIO

from selection.dataset.one import Outcome


def show_progress(outcomes: Iterable[Outcome], count: int, missing: int, quiet: bool = False) -> None:
    """Take the outcomes as they come, and show how far it is on stderr.

    Args:
        outcomes: of what was missing.
        count, missing: how many objects there are to be, and how many of them are not there yet.
        quiet: show nothing.
    """
    with _progress(count, missing, quiet) as progress:
        for outcome in outcomes:
            progress.done(outcome)


class _Progress(Protocol):
    def done(self, outcome: Outcome) -> None: ...


@contextmanager
def _progress(count: int, missing: int, quiet: bool) -> Iterator[_Progress]:
    if quiet or not missing:
        yield _Nothing()
    elif sys.stderr.isatty():
        with _bar(count, missing) as bar:
            yield bar
    else:
        yield _Lines(count, missing, sys.stderr)


class _Nothing:
    def done(self, outcome: Outcome) -> None:
        """Show nothing."""


class _Lines:
    """A line an object, where there is no terminal."""

    def __init__(self, count: int, missing: int, out: TextIO) -> None:
        self._count, self._missing, self._out = count, missing, out
        self._done, self._began = 0, time.monotonic()

    def done(self, outcome: Outcome) -> None:
        self._done += 1
        left = self._missing - self._done
        minutes = (time.monotonic() - self._began) / self._done * left / 60
        trouble = outcome.error or "; ".join(outcome.failed)
        so_far = f"{self._count - left} of {self._count} objects, about {minutes:.0f} min left"
        print(so_far + (f"; object {outcome.index}: {trouble}" if trouble else ""), file=self._out, flush=True)


@contextmanager
def _bar(count: int, missing: int) -> Iterator[_Progress]:
    """Show a bar with the time that is left, on a terminal."""
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    columns = (TextColumn("objects"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    left = TimeRemainingColumn()
    with Progress(
        *columns, TextColumn("left"), left, console=Console(stderr=True), speed_estimate_period=600
    ) as progress:
        task = progress.add_task("explored", total=count, completed=count - missing)

        class Bar:
            def done(self, outcome: Outcome) -> None:
                trouble = outcome.error or "; ".join(outcome.failed)
                if trouble:
                    progress.console.print(f"object {outcome.index}: {trouble}", markup=False)
                progress.advance(task)

        yield Bar()
