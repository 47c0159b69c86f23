"""What the exploration hears of a robot: samples, gathered into marked phases and kept as they come."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from dynamics.robot import Robot
from dynamics.signals import Phase, Sample
from estimation.recording import RunWriter


class Tape:
    """Listens to a robot.

    Args:
        robot: whose samples to gather.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._run: RunWriter | None = None
        self._tell: Callable[[str, str], None] | None = None
        robot.listen(self._hear)
        self._heard: list[Sample] | None = None
        self._phases: list[Phase] = []
        self._counts: Counter[tuple[str, str]] = Counter()

    def record(self, run: RunWriter) -> None:
        """Keep every further sample and mark in a run."""
        self._run = run

    def on_phase(self, tell: Callable[[str, str], None]) -> None:
        """Tell of every phase that begins: its action and its name."""
        self._tell = tell

    @contextmanager
    def phase(self, action: str, name: str) -> Iterator[list[Sample]]:
        """Gather the samples of a stretch of an action as one phase; yields the list that they arrive in."""
        index = self._counts[action, name]
        self._counts[action, name] += 1
        if self._run is not None:
            self._run.phase(action, name, index, self._robot.read().time)
        if self._tell is not None:
            self._tell(action, name)
        heard: list[Sample] = []
        self._heard = heard
        try:
            yield heard
        finally:
            self._heard = None
            if self._run is not None:
                self._run.end_phase(self._robot.read().time)
            self._phases.append(Phase(action, name, index, tuple(heard)))

    @property
    def phases(self) -> tuple[Phase, ...]:
        """The phases gathered since they were last taken."""
        return tuple(self._phases)

    def take(self) -> tuple[Phase, ...]:
        """Return the phases gathered since the last call."""
        phases, self._phases = tuple(self._phases), []
        return phases

    def _hear(self, sample: Sample) -> None:
        if self._run is not None:
            self._run.sample(sample)
        if self._heard is not None:
            self._heard.append(sample)
