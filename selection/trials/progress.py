"""A progress bar with the remaining time, for people at a terminal; a line a sweep for files."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager


class Bar:
    """Shows a sweep on standard error, so that standard output stays clean."""

    def __init__(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

        columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
        self._progress = Progress(*columns, TextColumn("left"), console=Console(stderr=True))
        self._task = self._progress.add_task("", visible=False)

    @contextmanager
    def begins(self, title: str, total: int, done: int) -> Iterator[None]:
        """Show a sweep while it goes on."""
        with self._progress:
            # what is on disk already took no time, and would make the rest look quick
            self._task = self._progress.add_task(title, total=total - done)
            yield
            self._progress.remove_task(self._task)

    def advances(self) -> None:
        """Count one more chunk."""
        self._progress.advance(self._task)


class Log:
    """Says when a sweep begins and ends."""

    @contextmanager
    def begins(self, title: str, total: int, done: int) -> Iterator[None]:
        """Say both."""
        start = time.monotonic()
        kept = f", {done} of them on disk" if done else ""
        sys.stderr.write(f"{title}: {total} chunks{kept}\n")
        yield
        sys.stderr.write(f"{title}: done in {time.monotonic() - start:.1f} s\n")

    def advances(self) -> None:
        """Say nothing."""
