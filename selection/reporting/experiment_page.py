"""The page of an experiment: its tables with their notes, and its curves, from what was computed or is on disk."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from dynamics.errors import InvalidInput
from estimation.network import Network
from estimation.recording.files import to_json, write_atomically
from selection.reporting.curve_figures import intervals, intervals_of, learning_curves, reference_densities, styles
from selection.reporting.document import Block, Document, Figure, Gallery, Section, Table
from selection.reporting.document import paragraph as said
from selection.reporting.files import write_document
from selection.reporting.text import name_of, slug, title_of, typeset
from selection.trials.result_tables import LearningCurve, ResultTable

REPORT, DATA = "report.html", "report.json"
LONGEST_LEAD = 160  # letters in large type
_FORMAT = "palpate-experiment/1"


def write_experiment_report(
    directory: Path,
    tables: Sequence[ResultTable],
    curves: Sequence[LearningCurve],
    *,
    title: str = "Experiments",
    lead: str = "",
    facts: Sequence[tuple[str, str]] = (),
    references: Sequence[str] = (),
) -> Path:
    """Write the page of an experiment into its directory, with what it is made of beside it; return its path.

    Args:
        directory: of the experiment; made if it is not there.
        tables: in the order of the page; a column ``rate...`` before ``low`` and ``high`` is drawn too, next to
            one of ``thesis...``.
        curves: those of one figure share a plot, and one label has one colour throughout.
        title: the heading.
        lead: what the experiment found, in a sentence or two.
        facts: pairs of a label and a value: repetitions, seeds, versions.
        references: names of the references of materials, whose densities are drawn.

    Raises:
        CannotRecord: if the files cannot be written.
    """
    content = {
        "format": _FORMAT,
        "title": title,
        "lead": lead,
        "facts": [list(fact) for fact in facts],
        "references": list(references),
        "tables": [asdict(table) | {"rows": [_finite(row) for row in table.rows]} for table in tables],
        "curves": [asdict(curve) for curve in map(_whole, curves)],
    }
    directory.mkdir(parents=True, exist_ok=True)
    write_atomically(directory / DATA, to_json(f"{directory / DATA}", content))
    return write_stored_experiment_report(directory)


def write_stored_experiment_report(directory: Path, out: Path | None = None) -> Path:
    """Write the page of an experiment again from its ``report.json``; return its path.

    Raises:
        InvalidInput: if there is none, or it is unusable.
        CannotRecord: if the files cannot be written.
    """
    path = directory / DATA
    where = f"report of {directory}"
    try:
        content: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InvalidInput(where, "neither run.mcap nor report.json", "a run or an experiment") from None
    except (OSError, ValueError, RecursionError) as error:
        raise InvalidInput(str(path), str(error), "JSON, as an experiment writes it") from None
    try:
        if content["format"] != _FORMAT:
            raise InvalidInput(f"{path}: format", content["format"], _FORMAT)
        tables = tuple(
            ResultTable(
                str(row["name"]),
                str(row["title"]),
                str(row["note"]),
                tuple(map(str, row["columns"])),
                tuple(map(tuple, row["rows"])),
            )
            for row in content["tables"]
        )
        curves = tuple(_curve(row) for row in content["curves"])
        facts = [(str(label), str(value)) for label, value in content["facts"]]
        title, lead = str(content["title"]), str(content["lead"])
        references = [str(name) for name in content["references"]]
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise InvalidInput(str(path), repr(error), f"JSON of the format {_FORMAT}") from None
    document = experiment_document(tables, curves, title, lead, facts, references)
    return write_document(document, out or directory / REPORT)


def experiment_document(
    tables: Sequence[ResultTable],
    curves: Sequence[LearningCurve],
    title: str,
    lead: str,
    facts: Sequence[tuple[str, str]],
    references: Sequence[str],
) -> Document:
    """Return the page of an experiment."""
    blocks: list[Block] = []
    if lead:
        blocks.append(said(typeset(lead), kind="lead" if len(lead) <= LONGEST_LEAD else ""))
    style = styles([curve.label for curve in curves])
    groups: dict[str, list[Block]] = {}
    for name in dict.fromkeys(curve.figure for curve in curves):
        own = [curve for curve in curves if curve.figure == name]
        groups.setdefault(_world(own[0]), []).append(learning_curves(own, style))
    for given in tables:
        columns = tuple(typeset(column) for column in given.columns)
        table = replace(given, note=typeset(given.note))
        rates = intervals_of(table)
        chart: tuple[Figure, ...] = ()
        if rates:
            chart = (intervals(f"{slug(table.name)}-{slug(rates.kind)}", rates),)
        blocks.append(Section(table.title, (Table(table, columns=columns, quiet=True), *chart)))
    for world, drawn in groups.items():
        label = "How knowledge grows"
        blocks.append(Section(title_of(world or "Learning curves"), (Gallery(tuple(drawn)),), label))
    priors = [figure for name in references for figure in _reference(name)]
    if priors:
        blocks.append(Section("What was known of the materials", (Gallery(tuple(priors)),)))
    if facts:
        rows = tuple((label, value) for label, value in facts)
        setup = ResultTable("set-up", "How it was set up", "", ("what", "value"), rows)
        settings = Table(setup, columns=("Setting", "Value"), quiet=True, pairs=True)
        blocks.append(Section("How it was set up", (settings,)))
    end = "Made by Palpate from report.json; figures and tables are also in the folders beside it."
    return Document(name_of(title, 120), "Experiment", tuple(blocks), end)


def _reference(name: str) -> Iterable[Figure]:
    try:
        network = Network.from_file(name)
    except InvalidInput:
        return []
    return [reference_densities(network, quantity) for quantity in network.property_names]


def _world(curve: LearningCurve) -> str:
    """Return what stands before a colon in the title of a plot; plots that share it stand together."""
    before, colon, _ = curve.title.partition(": ")
    return before if colon else ""


def _curve(row: dict[str, Any]) -> LearningCurve:
    x, y, low, high = (tuple(float(v) for v in row[key]) for key in ("x", "y", "low", "high"))
    figure, title, label, x_label, y_label = (
        str(row[key]) for key in ("figure", "title", "label", "x_label", "y_label")
    )
    return LearningCurve(figure, title, label, x_label, y_label, x, y, low, high)


def _whole(curve: LearningCurve) -> LearningCurve:
    """Return a curve without the points that are no numbers."""
    points = [p for p in zip(curve.x, curve.y, curve.low, curve.high, strict=True) if all(map(math.isfinite, p))]
    x, y, low, high = zip(*points, strict=True) if points else ((), (), (), ())
    return replace(curve, x=x, y=y, low=low, high=high)


def _finite(row: Sequence[Any]) -> list[Any]:
    return [None if isinstance(cell, float) and not math.isfinite(cell) else cell for cell in row]
