"""Every action of a recording measured again by the function that measures it online, and the belief after it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from dynamics.errors import InvalidInput, PalpateError
from dynamics.signals import Phase
from estimation.belief import Belief
from estimation.conclude import conclude
from estimation.measurement import Measurement
from estimation.observation import Observation
from estimation.recording import Recording
from estimation.reestimation.description import Known
from estimation.reestimation.episodes import (
    Episode,
    episodes_of,
    find_holds,
    find_squeezes,
    find_weighing,
    mark_all,
)
from estimation.size import SizeEstimate


@dataclass(frozen=True)
class Redone:
    """One action measured again.

    Attributes:
        action: its name.
        measurements: by the current estimators.
        recorded: what was measured at the time.
        notes: what else there is to know, such as why there is no measurement.
    """

    action: str
    measurements: tuple[Measurement, ...]
    recorded: tuple[Measurement, ...]
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Reestimate:
    """A recording estimated again.

    Attributes:
        recording: what it was made from.
        actions: in order.
        belief: what follows from them, if there is a reference.
        recorded_belief: what was believed last at the time: probabilities by variable, and properties.
        notes: what a reader should know.
    """

    recording: Recording
    actions: tuple[Redone, ...]
    belief: Belief | None
    recorded_belief: Mapping[str, Any]
    notes: tuple[str, ...]


def reestimate(recording: Recording, known: Known, tares: Sequence[Recording] = ()) -> Reestimate:
    """Measure the actions of a recording again and draw the conclusion.

    Args:
        recording: with marks, or without: then holds and squeezes are found.
        known: robot, object and reference.
        tares: recordings of the empty arm, whose stands are the tares of a log without marks.

    Raises:
        InvalidInput: if a log without marks has nothing in it that can be measured.
    """
    notes = [*recording.notes, *known.notes]
    state = _State(known, tuple(one.observation for one in recording.observations))
    done = []
    if recording.marks:
        for episode in episodes_of(recording):
            phases = [recording.phase(mark) for mark in episode.marks]
            done.append(_measure(state, episode, phases, bool(recording.decisions) and not episode.recorded))
    else:
        for episode, phases in _found(recording, tares, notes):
            done.append(_measure(state, episode, phases, unused=False))
    last = recording.beliefs[-1].data if recording.beliefs else {}
    return Reestimate(recording, tuple(done), state.belief(), last, tuple(notes))


class _State:
    """What is known so far, as in an exploration."""

    def __init__(self, known: Known, observed: tuple[Observation, ...] = ()) -> None:
        self.known, self.observed = known, observed
        self.size = None if known.declared is None else SizeEstimate.declared(known.declared)
        self.measured: list[Measurement] = []

    def take(self, measurement: Measurement, edge: int) -> None:
        if measurement.property == "width":
            if self.size is not None:
                self.size = self.size.with_edge(edge, measurement)
        else:
            self.measured.append(measurement)

    def belief(self) -> Belief | None:
        if self.known.blank is None or self.size is None:
            return None
        return conclude(self.known.blank, self.size, self.measured, self.observed)


Result = tuple[Sequence[Measurement], tuple[str, ...]]


def _weigh(state: _State, phases: Sequence[Phase], edge: int) -> Result:
    from estimation.weighing import measure_weighing

    estimate, measurements = measure_weighing(state.known.arm, phases)
    return measurements, () if measurements else (estimate.verdict,)


def _squeeze(state: _State, phases: Sequence[Phase], edge: int) -> Result:
    from estimation.squeezed import believe_squeeze

    known = state.known
    if known.declared is None or state.size is None:
        return (), ("no elasticity: the object's shape and size are unknown; option --object",)
    found = believe_squeeze(known.arm, known.gripper, known.declared.shape, state.size, edge, phases)
    return found.measurements, found.notes


def _rub(state: _State, phases: Sequence[Phase], edge: int) -> Result:
    from estimation.rubbing import measure_rub

    return (measure_rub(state.known.arm, phases, gripper=state.known.gripper)[1],), ()


def _slip(state: _State, phases: Sequence[Phase], edge: int) -> Result:
    from estimation.slipping import measure_slip

    return (measure_slip(state.known.arm, state.known.gripper, phases)[1],), ()


KINDS: dict[str, Callable[[_State, Sequence[Phase], int], Result]] = {
    "weigh": _weigh,
    "squeeze": _squeeze,
    "rub": _rub,
    "slip": _slip,
}
"""For every kind of action the function that measures it; a further kind needs a line here."""


def _measure(state: _State, episode: Episode, phases: Sequence[Phase], unused: bool) -> Redone:
    recorded = tuple(one.measurement for one in episode.recorded)
    kind = KINDS.get(episode.action)
    if kind is None:
        for one in recorded:  # a kind without samples, such as a look: its word is taken
            state.take(one, 0)
        return Redone(episode.action, recorded, recorded, ("measurements taken over: not made from samples",))
    edge = closing_edge(state.known, phases)
    try:
        measurements, notes = kind(state, phases, edge)
    except PalpateError as error:
        return Redone(episode.action, (), recorded, (f"no measurement: {error}",))
    if unused:
        now = ", ".join(f"{m.property} {m.mean:.4g} +- {m.sd:.2g} {m.unit}" for m in measurements)
        why = "left out, as at the time: the action failed or was interrupted"
        return Redone(episode.action, (), recorded, (f"{why} ({now or 'no measurement'})",))
    for one in measurements:
        state.take(one, edge)
    return Redone(episode.action, tuple(measurements), recorded, notes)


def closing_edge(known: Known, phases: Sequence[Phase]) -> int:
    """Return the edge that the pads close on: as recorded, or 0 or 1, the nearer to the tool's y axis."""
    if known.closing_edge is not None:
        return known.closing_edge
    grasped = [phase for phase in phases if phase.name in ("grasp", "close", "compress") and phase.samples]
    if known.declared is None or not grasped:
        return 1
    closing = known.arm.tool_pose(grasped[0].samples[-1].q)[:2, 1]
    along = known.declared.pose()[:2, :2].T @ closing
    return int(abs(along[1]) >= abs(along[0]))


def _found(
    recording: Recording, tares: Sequence[Recording], notes: list[str]
) -> list[tuple[Episode, list[Phase]]]:
    """Find what can be measured in a log without marks."""
    notes.append("the log has no marks: its phases were found by where the arm stands and the gripper closes")
    found: list[tuple[Episode, list[Phase]]] = []
    refused: InvalidInput | None = None
    if tares:
        empty = [tare.phase(m) for tare in tares for m in mark_all("weigh", *_named("tare", tare))]
        marks = mark_all("weigh", *_named("hold", recording))
        found.append((Episode("weigh", marks), [*empty, *(recording.phase(mark) for mark in marks)]))
    else:
        try:
            marks = find_weighing(recording.samples)
            found.append((Episode("weigh", marks), [recording.phase(mark) for mark in marks]))
        except InvalidInput as error:
            refused = error
            notes.append(f"no weighing: {error}")
    squeezes = find_squeezes(recording.samples)
    if squeezes:
        found.append((Episode("squeeze", squeezes), [recording.phase(mark) for mark in squeezes]))
    if refused is not None and not found:
        raise refused
    return found


def _named(name: str, recording: Recording) -> tuple[list[str], list[tuple[int, int]]]:
    stretches = find_holds(recording.samples)
    return [name] * len(stretches), stretches


def change_in_sds(new: Measurement, old: Measurement) -> float:
    """Return how far a measurement moved, in its recorded standard deviations."""
    return float(np.abs(new.mean - old.mean) / old.sd)


def matched(action: Redone) -> list[tuple[Measurement | None, Measurement | None]]:
    """Return new and recorded measurements side by side, by property and order."""
    pairs: list[tuple[Measurement | None, Measurement | None]] = []
    left = list(action.recorded)
    for one in action.measurements:
        old = next((other for other in left if other.property == one.property), None)
        if old is not None:
            left.remove(old)
        pairs.append((one, old))
    return [*pairs, *((None, old) for old in left)]
