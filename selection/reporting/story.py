"""The story of a run, read from what is on disk: what was thought, done, measured and believed, step by step.

A run may have been killed, or written by an older program: what is missing is told, never guessed.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from estimation.measurement import Measurement
from estimation.observation import Observation
from estimation.recording import Entry, Recorded, Recording, read_recording
from estimation.reestimation.episodes import Episode, episodes_of
from selection.reporting.text import clean

RESULT = "result.json"
MOST_STEPS = 60


@dataclass(frozen=True)
class Score:
    """What the planner thought of an action: expected bits, seconds, what choosing it is worth, and why not."""

    name: str
    bits: float
    seconds: float
    value: float
    feasible: bool
    reason: str


@dataclass(frozen=True)
class Believed:
    """A belief about a quantity [SI unit]: median and the middle 90 %."""

    median: float
    interval: tuple[float, float]
    unit: str


@dataclass(frozen=True)
class Beliefs:
    """What was believed at one time: probabilities of every variable's classes, and quantities."""

    classes: Mapping[str, Mapping[str, float]]
    quantities: Mapping[str, Believed]

    def entropy(self, variable: str) -> float:
        """Return what is not known of a variable [bits]: H = -sum P ld P."""
        found = self.classes.get(variable, {})
        return -sum(p * math.log2(p) for p in found.values() if p > 0)

    def best(self, variable: str) -> tuple[str, float]:
        """Return the most probable class and its probability."""
        found = self.classes.get(variable, {})
        return max(found.items(), key=lambda item: item[1], default=("nothing", math.nan))


@dataclass(frozen=True)
class Step:
    """One decision and the action that followed.

    Attributes:
        number: from 1.
        target: what the information is about.
        price: of time [bits/s].
        scores: of every action.
        choice: the action chosen; empty where the exploration stopped.
        stop: why it stopped.
        episode: the action's phases, if any were recorded.
        measurements: what it measured.
        observations: what it perceived of classes.
        notes: what else is known of it.
        seconds: robot time that it took [s]; NaN where it was interrupted.
        ok: whether it succeeded; None where nobody said.
        before, after: beliefs; None where they were not recorded.
    """

    number: int
    target: str
    price: float
    scores: tuple[Score, ...]
    choice: str
    stop: str
    episode: Episode | None
    measurements: tuple[Measurement, ...]
    observations: tuple[Observation, ...]
    notes: tuple[str, ...]
    seconds: float
    ok: bool | None
    before: Beliefs | None
    after: Beliefs | None

    @property
    def chosen(self) -> Score | None:
        """The score of the action that was chosen."""
        return next((score for score in self.scores if score.name == self.choice), None)


@dataclass(frozen=True)
class Story:
    """A run.

    Attributes:
        recording: everything that was recorded.
        object_name: what was explored.
        steps: in order; the last may have no choice, but a reason to stop.
        first, last: what was believed beforehand and at the end; None where nothing was recorded.
        result: of a run that ended well, as it is on disk; empty for another.
        notes: what a reader should know of the data.
    """

    recording: Recording
    object_name: str
    steps: tuple[Step, ...]
    first: Beliefs | None
    last: Beliefs | None
    result: Mapping[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    @property
    def acts(self) -> tuple[Step, ...]:
        """The steps that did something."""
        return tuple(step for step in self.steps if step.choice)

    @property
    def stopped_because(self) -> str:
        """Why the run ended; empty where it was broken off."""
        said = self.result.get("stopped_because")
        return clean(said) if isinstance(said, str) else (self.steps[-1].stop if self.steps else "")

    @property
    def seconds(self) -> float:
        """Robot time spent [s]."""
        found = as_number(self.result.get("seconds"))
        if found is not None:
            return found
        time = self.recording.samples.time
        return float(time[-1] - time[0]) if len(time) else 0.0

    @property
    def target(self) -> str:
        """What the information was about."""
        return self.steps[0].target if self.steps else "material"


def read_story(directory: Path) -> Story:
    """Read the story of a run directory.

    Raises:
        InvalidInput: if there is no recording in it.
    """
    recording = read_recording(directory)
    notes = list(recording.notes)
    result = _result(directory / RESULT, notes)
    decisions, beliefs = recording.decisions, recording.beliefs
    told = _told(result)
    steps: list[Step] = []
    if len(decisions) > MOST_STEPS:
        notes.append(f"only the first {MOST_STEPS} of {len(decisions)} decisions are shown")
    chosen = [i for i, entry in enumerate(decisions) if entry.data.get("choice")]
    # A resumed run's result tells of its last part alone.
    outcome = {
        i: row
        for i, row in zip(reversed(chosen), reversed(told), strict=False)
        if row.get("action") == decisions[i].data.get("choice")
    }
    episodes = episodes_of(recording) if recording.marks else ()
    for i, entry in enumerate(decisions[:MOST_STEPS]):
        following = decisions[i + 1] if i + 1 < len(decisions) else None
        steps.append(_step(i, entry, following, recording, episodes, outcome.get(i, {})))
    name = recording.object_name or str(result.get("object", "")) or "an object"
    first = believed(beliefs[0].data) if beliefs else None
    last = believed(result) if isinstance(result.get("belief"), Mapping) else None
    last = last or (believed(beliefs[-1].data) if beliefs else None)
    return Story(recording, name, tuple(steps), first, last, result, tuple(clean(note) for note in notes))


def believed(data: Mapping[str, Any]) -> Beliefs:
    """Return a belief as it stands in a recording or a result; what is malformed is left out."""
    classes: dict[str, dict[str, float]] = {}
    for variable, found in _mapping(data.get("belief")).items():
        numbers = {str(name): as_number(p) for name, p in _mapping(found).items()}
        kept = {name: p for name, p in numbers.items() if p is not None and 0 <= p <= 1}
        if kept:
            classes[str(variable)] = kept
    quantities = {}
    for name, row in _mapping(data.get("properties")).items():
        told = _mapping(row)
        mean, sd = as_number(told.get("mean")), as_number(told.get("sd"))
        if mean is None or sd is None:
            continue
        ends = [as_number(end) for end in _listed(told.get("interval_90"))]
        low, high = (ends[0], ends[1]) if len(ends) == 2 else (None, None)
        if low is None or high is None:
            low, high = mean - 1.645 * sd, mean + 1.645 * sd
        median = as_number(told.get("median"))
        middle = mean if median is None else median
        quantities[str(name)] = Believed(middle, (low, high), str(told.get("unit", "")))
    return Beliefs(classes, quantities)


def _step(
    index: int,
    entry: Entry,
    following: Entry | None,
    recording: Recording,
    episodes: tuple[Episode, ...],
    told: Mapping[str, Any],
) -> Step:
    data = entry.data
    choice = str(data.get("choice") or "")
    at = (entry.time, entry.row)
    end = (following.time, following.row) if following is not None else (math.inf, math.inf)
    earlier = [one for one in recording.beliefs if (one.time, one.row) <= at]
    later = [one for one in recording.beliefs if at < (one.time, one.row) <= end]
    measured = [m for m in recording.measurements if at < (m.time, m.row) <= end and m.action == choice]
    observed = tuple(
        o.observation for o in recording.observations if at < (o.time, o.row) <= end and o.action == choice
    )
    after = believed(later[-1].data) if later and choice else None
    took = as_number(told.get("seconds"))
    if took is None:
        took = later[-1].time - entry.time if after is not None else math.nan
    ok = told.get("ok")
    notes = [clean(note) for note in _listed(told.get("notes"))]
    if choice and not told and after is None:
        notes.append("The run ended in the middle of this action.")
    return Step(
        number=index + 1,
        target=str(data.get("target", "material")),
        price=as_number(data.get("price")) or 0.0,
        scores=tuple(_score(str(name), row) for name, row in _mapping(data.get("actions")).items()),
        choice=choice,
        stop=clean(data.get("stop") or ""),
        episode=_episode(episodes, choice, entry, following, measured),
        measurements=tuple(m.measurement for m in measured),
        observations=observed,
        notes=tuple(notes),
        seconds=took,
        ok=ok if isinstance(ok, bool) else (True if measured or observed else None),
        before=believed(earlier[-1].data) if earlier else None,
        after=after,
    )


def _episode(
    episodes: tuple[Episode, ...], choice: str, entry: Entry, following: Entry | None, measured: list[Recorded]
) -> Episode | None:
    stop = following.row if following is not None else math.inf
    for episode in episodes:
        if episode.action == choice and entry.row <= episode.marks[0].start < stop:
            return Episode(choice, episode.marks, tuple(measured))
    return None


def _score(name: str, row: Any) -> Score:
    row = _mapping(row)
    bits, seconds, value = (as_number(row.get(key)) or 0.0 for key in ("bits", "seconds", "value"))
    return Score(name, bits, seconds, value, bool(row.get("feasible", True)), clean(row.get("reason") or ""))


def _result(path: Path, notes: list[str]) -> Mapping[str, Any]:
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        notes.append("There is no result: the run failed, was stopped, or still goes on.")
        return {}
    except (OSError, ValueError, RecursionError) as error:
        notes.append(f"{RESULT} is unusable: {error}")
        return {}
    if isinstance(found, dict):
        return found
    notes.append(f"{RESULT} is unusable: it holds no table")
    return {}


def _told(result: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    return [row for row in _listed(result.get("actions")) if isinstance(row, Mapping)]


def _mapping(value: Any) -> Mapping[str, Any]:
    return value if isinstance(value, Mapping) else {}


def _listed(value: Any) -> list[Any]:
    return value if isinstance(value, list) else []


def as_number(value: Any) -> float | None:
    """Return a value of a file as a finite number; None if it is none."""
    if isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e300:
        return float(value)
    return None
