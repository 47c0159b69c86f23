"""The tables of a run's page, and its configuration."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from selection.reporting.document import Block, Code, Folded, Table, paragraph
from selection.reporting.story import Beliefs, Story
from selection.reporting.text import (
    clean,
    interval,
    name_of,
    number,
    percent,
    plain,
    reading,
    seconds,
    signed,
    slug,
    title_of,
)
from selection.trials.result_tables import ResultTable, Value

LONGEST_VALUE = 160
_LABELS = {
    "object": "Object",
    "reference": "Reference of materials",
    "prior": "Prior of materials",
    "seed": "Seed of everything random",
    "noise": "Errors of the simulated sensors",
    "confidence": "Probability at which to stop",
    "budget_s": "Robot time allowed [s]",
    "price_bits_per_s": "Price of time [bit/s]",
    "robot": "Robot",
    "revision": "Revision of the arm",
    "vision": "Vision",
    "arm": "Description of the arm",
    "torque_gain_sd": "Relative sd of the torque sensors' gain",
    "model_sha256": "SHA-256 of the description",
}


def found_table(story: Story, true_value: Callable[[str], float | None]) -> Table:
    """Return what is believed of every quantity at the end, next to the truth where that is told."""
    measured: dict[str, list[str]] = {}
    for step in story.acts:
        for one in step.measurements:
            name, value = reading(one)
            measured.setdefault(name, []).append(value)
    last = story.last.quantities if story.last is not None else {}
    truths = any(true_value(name) is not None for name in last)
    rows: list[tuple[Value, ...]] = []
    texts: list[tuple[str, ...]] = []
    for name, found in last.items():
        low, high = found.interval
        true = true_value(name)
        readings = measured.get(name, [])
        row: tuple[Value, ...] = (name, found.median, low, high, found.unit, len(readings))
        text: tuple[str, ...] = (
            title_of(name),
            plain(found.median, found.unit),
            interval(found.interval, found.unit),
        )
        text += ("; ".join(readings) or "inferred",)
        if truths:
            inside = None if true is None else "inside" if low <= true <= high else "outside"
            row += (true, inside)
            text += ("–" if true is None else f"{plain(true, found.unit)}, {inside}",)
        rows.append(row)
        texts.append(text)
    columns: tuple[str, ...] = ("quantity", "median", "low_90", "high_90", "unit", "readings")
    shown: tuple[str, ...] = ("Quantity", "Found", "90 % interval", "Measured")
    if truths:
        columns, shown = (*columns, "truth", "truth_in_interval"), (*shown, "Truth")
    result = ResultTable("found", "What is believed of the object", "", columns, tuple(rows))
    return Table(result, tuple(texts), shown, quiet=True)


def measurement_table(story: Story) -> Table:
    """Return every measurement."""
    rows: list[tuple[Value, ...]] = []
    texts: list[tuple[str, ...]] = []
    for step in story.acts:
        for one in step.measurements:
            rows.append((step.number, step.choice, one.property, one.mean, one.sd, one.unit))
            name, value = reading(one)
            relative = percent(one.sd / abs(one.mean)) if one.mean else "–"
            texts.append((str(step.number), name_of(step.choice), title_of(name), value, relative))
    result = ResultTable(
        "measurements",
        "Measurements",
        "± one standard deviation." if rows else "There are none.",
        ("step", "action", "quantity", "mean", "sd", "unit"),
        tuple(rows),
    )
    return Table(result, tuple(texts), ("Step", "Action", "Quantity", "Value", "Relative sd"))


def decision_table(story: Story) -> Table:
    """Return what the planner thought of every action at every step."""
    rows: list[tuple[Value, ...]] = []
    texts: list[tuple[str, ...]] = []
    for step in story.steps:
        for score in step.scores:
            chosen = score.name == step.choice
            verdict = "chosen" if chosen else score.reason
            rows.append((step.number, score.name, score.bits, score.seconds, score.value, verdict))
            texts.append(
                (
                    str(step.number),
                    name_of(score.name),
                    f"{score.bits:.3f}",
                    seconds(score.seconds),
                    signed(score.value, 3) if score.feasible else "–",
                    name_of(verdict),
                )
            )
    result = ResultTable(
        "decisions",
        "Expected information of every action",
        "",
        ("step", "action", "bits", "seconds", "value_bits", "verdict"),
        tuple(rows),
    )
    shown = ("Step", "Action", "Information [bit]", "Time", "Worth [bit]", "Verdict")
    return Table(result, tuple(texts), shown)


def belief_table(variable: str, moments: Sequence[tuple[str, Beliefs]]) -> Table:
    """Return the probability of every class of a variable at every moment."""
    names = dict.fromkeys(name for _, belief in moments for name in belief.classes.get(variable, {}))
    last = moments[-1][1].classes.get(variable, {}) if moments else {}
    order = sorted(names, key=lambda name: -last.get(name, 0.0))
    values = {name: [belief.classes.get(variable, {}).get(name) for _, belief in moments] for name in order}
    columns = tuple(f"{i}: {name_of(word)}" if i else name_of(word) for i, (word, _) in enumerate(moments))
    result = ResultTable(
        f"beliefs-of-{variable}" if variable.isidentifier() else "beliefs",
        f"Probabilities of the {variable}",
        "",
        (variable, *columns),
        tuple((name, *values[name]) for name in order),
    )
    texts = tuple((name_of(name), *("–" if p is None else percent(p) for p in values[name])) for name in order)
    return Table(result, texts, (title_of(variable), *columns))


def configuration_blocks(story: Story) -> tuple[Block, ...]:
    """Return the configuration of a run, and the versions of what computed it."""
    config = story.recording.config
    if not config:
        return (paragraph("The run has no configuration on disk."),)
    scalars = {key: value for key, value in config.items() if not isinstance(value, Mapping | list)}
    scalars.pop("object_file", None)
    rows: list[tuple[Value, ...]] = [
        (_LABELS.get(key, name_of(key)), _said(value)) for key, value in scalars.items()
    ]
    if story.recording.started:
        rows.insert(0, ("Started (universal time)", _moment(story.recording.started)))
    blocks: list[Block] = [_pairs("configuration", "Configuration", rows)]
    versions = story.result.get("versions") or config.get("versions")
    if isinstance(versions, Mapping):
        parts: list[tuple[Value, ...]] = [(name_of(key), _said(value)) for key, value in versions.items()]
        blocks.append(Folded("Versions", (_pairs("versions", "Versions", parts),)))
    text = config.get("object_file")
    if isinstance(text, str):
        blocks.append(Folded("The object's file", (Code(clean(text)),)))
    for key, table in config.items():
        if isinstance(table, Mapping) and key != "versions":
            own: list[tuple[Value, ...]] = [(name_of(k), _said(v)) for k, v in table.items()]
            blocks.append(Folded(f"{title_of(key)}, in SI units", (_pairs(name_of(key), title_of(key), own),)))
    samples = story.recording.samples
    if len(samples):
        time = samples.time
        blocks.append(
            paragraph(
                f"{len(samples)} samples of {samples.q.shape[1]} joints and the gripper over "
                f"{seconds(float(time[-1] - time[0]))} are in run.mcap.",
                kind="note",
            )
        )
    return tuple(blocks)


def _pairs(name: str, title: str, rows: Sequence[tuple[Value, ...]]) -> Table:
    texts = tuple(tuple(str(cell) for cell in row) for row in rows)
    result = ResultTable(slug(name), title, "", ("what", "value"), tuple(rows))
    return Table(result, texts, ("Setting", "Value"), quiet=True, pairs=True)


def _said(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.6g}" if math.isfinite(value) else number(value)
    if isinstance(value, str):
        return name_of(value, LONGEST_VALUE) or "–"
    return name_of(json.dumps(value, default=str), LONGEST_VALUE)


def _moment(text: str) -> str:
    """Return a time of ISO 8601 to the second."""
    return name_of(text[:19].replace("T", " "))
