"""What the experiments leave behind: CSV, JSON, a report, and words on the screen."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TextIO

from estimation.recording.files import to_json, write_atomically
from selection.reporting import write_experiment_report
from selection.result import versions
from selection.trials.result_tables import ResultTable, write_tables
from selection.trials.studies import Outcome

FORMAT = "palpate-experiments/1"
REFERENCES = ("thesis-3.1-erratum",)


def write(outcome: Outcome, directory: Path, json: Path | None, page: bool = True) -> None:
    """Write one CSV a table and a plot, the page of it all, and everything as JSON if a file is named.

    Args:
        outcome: what the studies came to.
        directory: where tables and the page go.
        json: the file; none if None.
        page: whether to draw the page.

    Raises:
        CannotRecord: if a file cannot be written.
    """
    write_tables(directory, outcome.tables, outcome.curves)
    if page:
        facts = [*outcome.settings, *(("version of " + name, value) for name, value in versions().items())]
        write_experiment_report(
            directory,
            outcome.tables,
            outcome.curves,
            title="The experiments",
            lead=" ".join(outcome.found),
            facts=facts,
            references=REFERENCES,
        )
    if json is not None:
        content = {
            "format": FORMAT,
            "settings": dict(outcome.settings),
            "found": list(outcome.found),
            "versions": versions(),
            "cells": [cell.record() for cell in outcome.cells],
            "tables": [asdict(table) for table in outcome.tables],
            "curves": [asdict(curve) for curve in outcome.curves],
        }
        write_atomically(json, to_json(str(json), content, indent=1) + "\n")


def say(outcome: Outcome, directory: Path, out: TextIO, page: bool = True) -> None:
    """Print the tables, and where the files are."""
    for table in outcome.tables:
        out.write(_lines(table) + "\n\n")
    shown = f"the page: {directory / 'report.html'}; " if page else ""
    out.write(f"{shown}tables and curves as CSV: {directory}\n")


def _lines(table: ResultTable) -> str:
    rows = [table.columns, *table.texts()]
    widths = [max(len(row[i]) for row in rows) for i in range(len(table.columns))]
    lines = [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows
    ]
    return "\n".join([table.title, *lines, *([table.note] if table.note else [])])
