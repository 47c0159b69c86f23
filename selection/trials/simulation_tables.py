"""Tables of explorations of simulated objects, listed and novel."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from selection.trials.explore import Trace
from selection.trials.result_tables import ResultTable, Value
from selection.trials.statistics import log_score, mean_interval, wilson

KNOWN_AT_LEAST, NOVEL_AT_LEAST = 0.95, 0.75
"""Shares of listed objects classified and of novel ones reported as unknown that are asked for."""

_COLUMNS = (
    "policy",
    "explorations of listed objects",
    "right",
    "low",
    "high",
    "of novel objects",
    "called unknown",
    "low ",
    "high ",
    "listed called unknown",
    "actions",
    "seconds",
    "seconds, low",
    "seconds, high",
    "log2 P(truth)",
)


def policy_table(name: str, title: str, found: Mapping[str, Mapping[str, Trace]], readings: str) -> ResultTable:
    """Return one row a policy.

    Args:
        name, title: of the table.
        found: traces by policy and by object.
        readings: where the readings come from, in a sentence.
    """
    rows = tuple(
        _policy_row(policy, Trace.of([t.arrays() for t in traces.values()])) for policy, traces in found.items()
    )
    first = next(iter(found))
    whole = Trace.of([trace.arrays() for trace in found[first].values()])
    return ResultTable(name, title, f"{readings} {verdict(first, whole)}", _COLUMNS, rows)


def object_table(name: str, title: str, found: Mapping[str, Trace], note: str) -> ResultTable:
    """Return one row an object."""
    rows: list[tuple[Value, ...]] = []
    for object_name, trace in found.items():
        right, trials = int(trace.right[:, -1].sum()), len(trace.right)
        rows.append(
            (
                object_name,
                "novel" if trace.novel[0] else "listed",
                trials,
                right,
                *wilson(right, trials),
                float(trace.true[:, -1].mean()),
                float(np.sum(trace.choices >= 0, axis=1).mean()),
                float(trace.seconds[:, -1].mean()),
            )
        )
    columns = ("object", "material", "explorations", "right", "low", "high", "P(truth)", "actions", "seconds")
    return ResultTable(name, title, note, columns, tuple(rows))


def verdict(policy: str, trace: Trace) -> str:
    """Say whether listed objects are classified and novel ones reported as often as asked for."""
    known, novel = trace.right[~trace.novel, -1], trace.right[trace.novel, -1]
    said = []
    for what, right, asked in (
        ("listed objects classified", known, KNOWN_AT_LEAST),
        ("novel ones reported as unknown", novel, NOVEL_AT_LEAST),
    ):
        low, high = wilson(int(right.sum()), len(right))
        met = "met" if len(right) and right.mean() >= asked else "not met"
        share = 100 * float(right.mean()) if len(right) else float("nan")
        said.append(
            f"{what}: {share:.1f} % [{100 * low:.1f}, {100 * high:.1f}] of {len(right)}, "
            f"asked {100 * asked:.0f} %: {met}"
        )
    return f"{policy.capitalize()}: {'; '.join(said)}."


def _policy_row(policy: str, trace: Trace) -> tuple[Value, ...]:
    known, novel = ~trace.novel, trace.novel
    right, called = int(trace.right[known, -1].sum()), int(trace.right[novel, -1].sum())
    return (
        policy,
        int(known.sum()),
        right,
        *wilson(right, int(known.sum())),
        int(novel.sum()),
        called,
        *wilson(called, int(novel.sum())),
        int(trace.unknown[known, -1].sum()),
        float(np.sum(trace.choices >= 0, axis=1).mean()),
        *mean_interval(trace.seconds[:, -1]),
        float(log_score(trace.true[:, -1]).mean()),
    )
