"""Figures of experiments: learning curves with 95 % bands, calibration, rates, reference densities."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from estimation.network import Network
from selection.reporting.document import Figure
from selection.reporting.drawing import SMALL, Sheet, bare, drawing, only_horizontal_grid
from selection.reporting.palette import LIGHT, SERIES, colours
from selection.reporting.text import listed, name_of, number, slug, title_of, typeset
from selection.trials.result_tables import LearningCurve, ResultTable, Value

INK, SOFT, LINE, MUTED = LIGHT["ink"], LIGHT["soft"], LIGHT["line"], LIGHT["muted"]
DASHES: tuple[Any, ...] = ("solid", (0, (5, 2)), (0, (1, 1.6)), (0, (5, 2, 1, 2)))
MOST_LINES = 16
MOST_INTERVALS = 60
LONGEST_TITLE = 120
MANY = 6  # lines from which bands are drawn paler
MARKED = 12  # points of a line up to which each is marked
ROW = 0.235  # inches


@dataclass(frozen=True)
class Interval:
    """A figure with its 95 % interval and what the thesis printed for it; rows of a group stand together."""

    group: str
    label: str
    value: float
    low: float
    high: float
    thesis: float | None = None


@dataclass(frozen=True)
class Intervals:
    """Figures of one kind.

    Attributes:
        kind: of what they are, as their column says; rates are shown in percent, from 0 to 100.
        rows: in the order of the table.
    """

    kind: str
    rows: tuple[Interval, ...]

    @property
    def are_rates(self) -> bool:
        """Tell whether they are shares of one."""
        return self.kind.lower().startswith("rate")


def styles(labels: Sequence[str]) -> dict[str, tuple[str, Any]]:
    """Return a colour and a dash for every label, the same for one label in all figures of a page."""
    order = list(dict.fromkeys(labels))
    return {
        label: (LIGHT[SERIES[i % len(SERIES)]], DASHES[(i // len(SERIES)) % len(DASHES)])
        for i, label in enumerate(order)
    }


def learning_curves(curves: Sequence[LearningCurve], style: Mapping[str, tuple[str, Any]]) -> Figure:
    """Draw the curves of one plot with their bands; where both axes are probabilities, with the diagonal."""
    first = curves[0]
    shown = [curve for curve in curves if curve.x][:MOST_LINES]
    diagonal = _is_calibration(shown, first.figure)
    columns = 2 if max((len(curve.label) for curve in shown), default=0) <= 26 else 1
    legend = 0.2 * math.ceil((len(shown) + diagonal) / columns) + 0.12
    with drawing():
        sheet = Sheet(2.75 + (1.2 if diagonal else 0.0) + legend)
        axes = sheet.axes(0.66, 0.5 + legend, 0.14, 0.12)
        only_horizontal_grid(axes)
        if diagonal:
            axes.plot([0, 1], [0, 1], color=SOFT, linewidth=1, linestyle=(0, (3, 3)), label="perfectly calibrated")
        for curve in shown:
            colour, dash = style[curve.label]
            x, y = np.array(curve.x), np.array(curve.y)
            low, high = np.array(curve.low), np.array(curve.high)
            if not np.allclose(low, high):
                axes.fill_between(
                    x, low, high, color=colour, alpha=0.16 if len(shown) <= MANY else 0.07, linewidth=0
                )
            mark = "o" if len(x) <= MARKED else None
            axes.plot(x, y, color=colour, linestyle=dash, marker=mark, markersize=3.4, label=name_of(curve.label))
        if diagonal:
            axes.set_xlim(0, 1)
            axes.set_ylim(0, 1)
        elif shown:
            _limits(axes, shown)
        axes.set_xlabel(typeset(name_of(first.x_label, 48)))
        axes.set_ylabel(typeset(name_of(first.y_label, 40)))
        if shown:
            sheet.figure.legend(
                loc="lower left",
                bbox_to_anchor=(0.01, 0.0),
                ncols=columns,
                borderaxespad=0.1,
                columnspacing=1.0,
                handlelength=1.8,
            )
        ends = [f"{curve.label} ends at {number(curve.y[-1])}" for curve in shown]
        left_out = len(curves) - len(shown)
        more = f" {left_out} more lines are in the table." if left_out > 0 else ""
        return sheet.finish(
            slug(first.figure),
            title_of(f"{first.title.partition(': ')[2] or first.title} against {first.x_label}", LONGEST_TITLE),
            f"Bands: 95 % intervals.{more}",
            f"{first.y_label} against {first.x_label}: {listed(ends)}.",
        )


def intervals(name: str, found: Intervals) -> Figure:
    """Draw figures with their 95 % intervals, row by row, next to those of the thesis."""
    rows = found.rows[:MOST_INTERVALS]
    thesis = any(row.thesis is not None for row in rows)
    places, heads, at = [], [], 0.0
    for i, row in enumerate(rows):
        if row.group and (i == 0 or row.group != rows[i - 1].group):
            heads.append((at + (0.35 if i else 0.0), row.group))
            at = heads[-1][0] + 1.0
        places.append(at)
        at += 1.0
    with drawing():
        sheet = Sheet(0.62 + ROW * at)
        axes = sheet.axes(1.8, 0.48, 0.2, 0.08)
        bare(axes)
        low, high = _ends(found)
        axes.set_xlim(low, high)
        axes.set_ylim(at - 0.3, -0.6)
        for place, group in heads:
            axes.text(-0.59, place, name_of(group, 46), weight="bold", va="center", size=SMALL, **_along(axes))
        for y, row in zip(places, rows, strict=True):
            axes.axhline(y, color=LINE, linewidth=0.6)
            axes.plot([row.low, row.high], [y, y], color=LIGHT["accent"], linewidth=4.5, alpha=0.45)
            axes.plot(row.value, y, "o", color=LIGHT["accent"], markersize=5, clip_on=False)
            if row.thesis is not None:
                mark = {"markersize": 6, "markerfacecolor": "none", "clip_on": False}
                axes.plot(row.thesis, y, "D", color=INK, **mark)
            axes.text(-0.03, y, name_of(row.label, 21), ha="right", va="center", size=SMALL, **_along(axes))
        axes.spines["bottom"].set_visible(True)
        if found.are_rates:
            axes.set_xticks([0, 0.25, 0.5, 0.75, 1], ["0", "25", "50", "75", "100"])
        else:
            from matplotlib.ticker import MaxNLocator

            axes.xaxis.set_major_locator(MaxNLocator(5))
        kind = typeset(title_of(found.kind))
        axes.set_xlabel(f"{kind} [%]" if found.are_rates else kind)
        said = [f"{row.group} {row.label} {number(row.value)}".strip() for row in rows]
        return sheet.finish(
            name,
            kind,
            "Dots and bars: with 95 % intervals." + (" Diamonds: as printed in the thesis." if thesis else ""),
            f"{kind}: {listed(said)}.",
        )


def _along(axes: Any) -> dict[str, Any]:
    """Return what places a text at a share of the axes' width and at a row."""
    return {"transform": axes.get_yaxis_transform(), "color": INK}


def _ends(found: Intervals) -> tuple[float, float]:
    """Return the ends of the axis."""
    if found.are_rates:
        return -0.02, 1.02
    values = [v for row in found.rows for v in (row.low, row.high, row.thesis) if v is not None]
    low, high = min(0.0, *values) if min(values) < 0.5 * max(values) else min(values), max(values)
    margin = 0.04 * (high - low) or 1.0
    return low - margin, high + margin


def intervals_of(table: ResultTable) -> Intervals | None:
    """Return the first figures of a table whose column ``low`` and ``high`` follow; None if there are none.

    Words before it that differ between rows name the rows, which are grouped by those that change least often;
    the thesis' own counts are in a column ``thesis...``.
    """
    names = [column.lower() for column in table.columns]
    after = next((i for i, pair in enumerate(pairwise(names)) if pair == ("low", "high")), 0)
    if after == 0:
        return None
    at = after - 1
    words = [i for i in range(at) if all(_is_word(row[i]) for row in table.rows)]
    varied = [i for i in words if len({row[i] for row in table.rows}) > 1]
    thesis = next((i for i, name in enumerate(names) if name.startswith("thesis")), None)
    runs = {i: 1 + sum(a[i] != b[i] for a, b in pairwise(table.rows)) for i in varied}
    leader = min(varied, key=lambda i: runs[i]) if len(varied) > 1 else None
    found = []
    for row in table.rows:
        numbers = [float(c) for c in row[at : at + 3] if isinstance(c, int | float) and math.isfinite(c)]
        if len(numbers) == 3:
            group = "" if leader is None else str(row[leader])
            label = ", ".join(str(row[i]) for i in varied if i != leader)
            printed = _share(row[thesis]) if thesis is not None else None
            value, low, high = numbers
            found.append(Interval(group, label, value, low, high, printed))
    return Intervals(table.columns[at], tuple(found)) if found else None


def reference_densities(network: Network, quantity: str) -> Figure:
    """Draw the density of a property in every material of a reference, as in Figs. 3.16 and 3.19 of the thesis."""
    from estimation.belief import Belief
    from selection.reporting.density_figures import draw_legend, legend_size, prior_curves

    with drawing():
        names = network.classes("material")
        shades = colours(names)
        columns, legend = legend_size(names, shades)
        sheet = Sheet(2.4 + legend)
        axes = sheet.axes(0.14, legend + 0.5, 0.14, 0.12)
        handles = prior_curves(axes, Belief(network), quantity, shades)
        draw_legend(sheet, handles, columns)
        return sheet.finish(
            f"reference-{slug(network.name)}-{slug(quantity)}",
            f"{quantity.capitalize()} in the reference {name_of(network.name)}",
            "Areas: probability of each material beforehand.",
            f"Densities of {quantity} of {listed(list(names))}.",
        )


def _is_calibration(curves: Sequence[LearningCurve], figure: str) -> bool:
    if not any(word in figure.lower() for word in ("calibration", "reliability")) or not curves:
        return False
    values = [value for curve in curves for value in (*curve.x, *curve.y)]
    return min(values) >= 0 and max(values) <= 1


def _limits(axes: Any, curves: Sequence[LearningCurve]) -> None:
    """Let shares end at 1, and keep every band on the axes."""
    low = min(min(curve.low) for curve in curves)
    high = max(max(curve.high) for curve in curves)
    margin = 0.06 * (high - low) or 0.5
    low, high = (max(low, margin - 0.02), min(high, 1.02 - margin)) if low >= 0 and high <= 1 else (low, high)
    axes.set_ylim(low - margin, high + margin)
    left, right = min(min(curve.x) for curve in curves), max(max(curve.x) for curve in curves)
    axes.set_xlim(left - 0.02 * (right - left), right + 0.02 * (right - left) or left + 1)
    from matplotlib.ticker import MaxNLocator

    whole = all(float(x).is_integer() for curve in curves for x in curve.x)
    axes.xaxis.set_major_locator(MaxNLocator(7, integer=whole))
    axes.yaxis.set_major_locator(MaxNLocator(6))


def _is_word(cell: Value) -> bool:
    """Tell whether a cell names something, and does not count."""
    return isinstance(cell, str) and not cell.replace("/", "").isdecimal()


def _share(cell: Value) -> float | None:
    """Return the share of converged trials of a C/W/D cell."""
    parts = str(cell or "").split("/")
    if not all(part.isdecimal() for part in parts) or len(parts) < 2 or sum(map(int, parts)) == 0:
        return None
    return int(parts[0]) / sum(map(int, parts))
