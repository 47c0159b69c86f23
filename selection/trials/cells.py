"""A cell of the thesis' tables: one policy in one context, counted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np

from estimation.belief import CORRECT, DIVERGED, UNDECIDED, WEAK
from selection.trials.explore import Trace
from selection.trials.protocol import letters
from selection.trials.statistics import log_score, mean_interval, wilson

SURE = 0.95


@dataclass(frozen=True)
class Cell:
    """One policy in one context.

    Attributes:
        environment: ``virtual``, ``simulation`` or ``emulator``.
        policy: its name.
        prior, measurement: the context.
        trials: number of trials.
        correct, weak, diverged, undecided: how many ended so.
        rate, low, high: share of correct ones and its 95 % interval.
        actions, seconds: means of what was used.
        to_sure: mean number of actions until P of a material is 0.95, those that never were counting in full.
        bits: mean log2 of P(truth) at the end over P(truth) beforehand [bits].
        first: how often every action came first.
        actions_named: names of these actions.
        thesis: the thesis' own C/W/D, or an empty text.
        source: where that stands.
    """

    environment: str
    policy: str
    prior: str
    measurement: str
    trials: int
    correct: int
    weak: int
    diverged: int
    undecided: int
    rate: float
    low: float
    high: float
    actions: float
    seconds: float
    to_sure: float
    bits: float
    first: tuple[int, ...]
    actions_named: tuple[str, ...]
    thesis: str = ""
    source: str = ""

    def record(self) -> dict[str, object]:
        """Return it as it stands in JSON."""
        return asdict(self)


def cell_of(
    environment: str,
    policy: str,
    context: tuple[str, str],
    trace: Trace,
    actions: Sequence[str],
    thesis: tuple[str, str] = ("", ""),
) -> Cell:
    """Count a cell's trials.

    Args:
        environment: where they ran.
        policy: what chose.
        context: prior and measurement.
        trace: the trials.
        actions: names of the actions.
        thesis: the thesis' own figure and its source.
    """
    found = letters(trace)
    counts = {letter: int(np.sum(found == letter)) for letter in (CORRECT, WEAK, DIVERGED, UNDECIDED)}
    trials = len(found)
    low, high = wilson(counts[CORRECT], trials)
    bits = log_score(trace.true[:, -1]) - log_score(trace.true[:, 0])
    return Cell(
        environment,
        policy,
        *context,
        trials,
        counts[CORRECT],
        counts[WEAK],
        counts[DIVERGED],
        counts[UNDECIDED],
        counts[CORRECT] / trials,
        low,
        high,
        float(np.mean(np.sum(trace.choices >= 0, axis=1))),
        float(np.mean(trace.seconds[:, -1])),
        mean_interval(actions_to(trace, SURE).astype(float))[0],
        float(np.mean(bits)),
        tuple(int(np.sum(trace.choices[:, 0] == i)) for i in range(len(actions))),
        tuple(actions),
        *thesis,
    )


def actions_to(trace: Trace, level: float, cap: int | None = None) -> np.ndarray:
    """Return after how many actions P of the most probable class reached a level, at most the cap, shape (N,)."""
    steps = trace.top.shape[1] - 1
    cap = steps if cap is None else cap
    reached = trace.top >= level
    return np.minimum(np.where(reached.any(axis=1), reached.argmax(axis=1), cap), cap)
