"""What experiments come to, ready to be shown: tables with a note, and curves with their intervals."""

from __future__ import annotations

import csv
import io
import math
from dataclasses import dataclass
from pathlib import Path

from dynamics.errors import InvalidInput
from estimation.recording.files import write_atomically

Value = str | int | float | None
"""What stands in a cell; None where there is nothing to say."""


@dataclass(frozen=True)
class ResultTable:
    """A table.

    Attributes:
        name: short and fit for a file name, such as ``virtual-mode-1``.
        title: what it shows.
        note: which figures of the thesis are reproduced, which are not, and why; may be empty.
        columns: headings.
        rows: one tuple a row, as long as the headings.

    Raises:
        InvalidInput: if a row is not as long as the headings.
    """

    name: str
    title: str
    note: str
    columns: tuple[str, ...]
    rows: tuple[tuple[Value, ...], ...]

    def __post_init__(self) -> None:
        for number, row in enumerate(self.rows):
            if len(row) != len(self.columns):
                raise InvalidInput(f"table {self.name}: row {number}", row, f"{len(self.columns)} cells")

    def texts(self) -> tuple[tuple[str, ...], ...]:
        """Return the rows as they are read by people."""
        return tuple(tuple(shown(value) for value in row) for row in self.rows)

    def csv(self) -> str:
        """Return headings and rows as CSV, numbers in full."""
        out = io.StringIO()
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(self.columns)
        writer.writerows(["" if value is None else value for value in row] for row in self.rows)
        return out.getvalue()


@dataclass(frozen=True)
class LearningCurve:
    """How a figure develops with what was spent; several of one `figure` belong into one plot.

    Attributes:
        figure: the plot that it belongs to, fit for a file name, such as ``accuracy-of-material``.
        title: of that plot.
        label: what this line is, such as a policy.
        x_label, y_label: names of the axes, with units in brackets.
        x, y: the points.
        low, high: ends of the 95 % interval at every point.

    Raises:
        InvalidInput: if the sequences differ in length.
    """

    figure: str
    title: str
    label: str
    x_label: str
    y_label: str
    x: tuple[float, ...]
    y: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]

    def __post_init__(self) -> None:
        sizes = [len(part) for part in (self.x, self.y, self.low, self.high)]
        if len(set(sizes)) != 1:
            raise InvalidInput(f"curve {self.figure}: {self.label}", sizes, "as many x as y, low and high")


def curves_table(figure: str, curves: tuple[LearningCurve, ...]) -> ResultTable:
    """Return the points of a plot as a table."""
    first = curves[0]
    rows = tuple(
        (curve.label, *point)
        for curve in curves
        for point in zip(curve.x, curve.y, curve.low, curve.high, strict=True)
    )
    columns = ("line", first.x_label, first.y_label, "low", "high")
    return ResultTable(figure, first.title, "", columns, rows)


def shown(value: Value) -> str:
    """Return the text of a cell."""
    if value is None:
        return ""
    if isinstance(value, float):
        if not math.isfinite(value):
            return "-"
        return f"{value:.0f}" if abs(value) >= 1000 else f"{value:.3g}"
    return str(value)


def write_tables(directory: Path, tables: tuple[ResultTable, ...], curves: tuple[LearningCurve, ...]) -> None:
    """Write one CSV a table and a plot into a directory, each whole or not at all."""
    directory.mkdir(parents=True, exist_ok=True)
    for figure in dict.fromkeys(curve.figure for curve in curves):
        tables = (*tables, curves_table(figure, tuple(curve for curve in curves if curve.figure == figure)))
    for table in tables:
        write_atomically(directory / f"{table.name}.csv", table.csv())
