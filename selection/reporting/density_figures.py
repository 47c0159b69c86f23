"""Figures of properties: what each material promises, the reading on it, and what is believed after it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimation.belief import Belief
from estimation.measurement import Measurement
from estimation.mixture import Mixture
from estimation.network import UNKNOWN
from selection.reporting.document import Figure
from selection.reporting.drawing import SMALL, Sheet, drawing
from selection.reporting.palette import LIGHT
from selection.reporting.reading_curve import reading_density
from selection.reporting.text import labelled, listed, name_of, plain, quantity, unit_of

Array = NDArray[np.float64]

POINTS = 241
WIDE = 30.0  # largest over smallest value, from which an axis is logarithmic
COUNTED = 0.002  # probability of a class from which its values must be on the axis
INK, SOFT, MUTED = LIGHT["ink"], LIGHT["soft"], LIGHT["muted"]


@dataclass(frozen=True)
class _Class:
    """The part of a mixture that belongs to one class, not normalised."""

    name: str
    part: Mixture

    @property
    def weight(self) -> float:
        return float(self.part.weights.sum())


def densities(
    name: str,
    before: Belief,
    after: Belief | None,
    reading: Measurement,
    shades: Mapping[str, str],
    truth: float | None,
) -> Figure:
    """Draw what each material promised for a reading, the reading on it, and below what is believed after it.

    As in Fig. 3.17 of the thesis: the curves are widened by the reading's own uncertainty, so that their
    heights at its mean are the likelihoods, weighted by what was believed.
    """
    classes = _classes(before, reading.property)
    low, high, log = _range(classes, reading)
    factor = unit_of(reading.unit, reading.mean)[1]
    with drawing():
        columns, legend = legend_size([c.name for c in classes if c.weight > COUNTED], shades, 1)
        own = legend + (1.25 if after is not None else 0.0)
        sheet = Sheet(own + 2.65)
        bottom = own + 0.55
        above = sheet.axes(0.14, bottom, 0.14, 0.24)
        x = np.geomspace(low, high, POINTS) if log else np.linspace(low, high, POINTS)
        handles = _promised(above, classes, reading, x, log, shades, factor)
        _frame(above, "Before: what each material would read", factor, low, high, log)
        if after is not None:
            below = sheet.axes(0.14, legend + 0.5, 0.14, sheet.height - legend - 1.2)
            _concluded(below, after.marginal(reading.property), reading, factor, truth)
            below.set_xlabel(labelled(reading.property, reading.unit, reading.mean), labelpad=2)
        else:
            above.set_xlabel(labelled(reading.property, reading.unit, reading.mean), labelpad=2)
        draw_legend(sheet, handles, columns)
        said = quantity(reading.mean, reading.sd, reading.unit)
        return sheet.finish(
            name,
            f"{reading.property.capitalize()}: the reading among the materials",
            f"Line and band: {said}. Dots: how well the reading fits each material, times its probability.",
            f"Densities of {reading.property} of {listed([c.name for c in classes if c.weight > COUNTED])}, "
            f"with the reading {said}" + ("" if truth is None else f" and the truth {plain(truth, reading.unit)}"),
        )


def legend_size(names: Sequence[str], shades: Mapping[str, str], more: int = 0) -> tuple[int, float]:
    """Return the columns of a legend of classes, and its height [inches].

    Args:
        names: of the classes; those without a colour of their own share one entry.
        shades: colours by name.
        more: further entries.
    """
    own = [name for name in names if name == UNKNOWN or shades.get(name, MUTED) != MUTED]
    entries = len(own) + (len(own) < len(names)) + more
    columns = 3 if max((len(name) for name in own), default=0) <= 15 else 2
    return columns, 0.2 * math.ceil(entries / columns) + 0.1


def draw_legend(sheet: Sheet, handles: Sequence[Any], columns: int) -> None:
    """Draw a legend along the lower edge."""
    sheet.figure.legend(
        handles=handles,
        loc="lower left",
        bbox_to_anchor=(0.005, 0.0),
        ncols=columns,
        columnspacing=1.2,
        borderaxespad=0.0,
        handlelength=1.3,
    )


def _promised(
    axes: Any,
    classes: list[_Class],
    reading: Measurement,
    x: Array,
    log: bool,
    shades: Mapping[str, str],
    factor: float,
    reads: bool = True,
) -> list[Any]:
    """Draw the widened curves of the classes, and the reading; return what the legend shows."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles: list[Any] = []
    rest, dots, top = [], [], 0.0
    scale = x if log else np.ones_like(x)
    at_mean = np.array([max(reading.mean, x[0])])
    drawn = sorted(
        (c for c in classes if not reads or c.weight > COUNTED),
        key=lambda c: (c.name == UNKNOWN, shades.get(c.name, MUTED) == MUTED, -c.weight),
    )
    for one in drawn:
        curve = reading_density(one.part, x, reading.sd) * scale
        height = float(reading_density(one.part, at_mean, reading.sd)[0]) * (float(at_mean[0]) if log else 1.0)
        colour = SOFT if one.name == UNKNOWN else shades.get(one.name, MUTED)
        if one.name == UNKNOWN:
            axes.plot(x * factor, curve, color=SOFT, linewidth=1.2, linestyle=(0, (4, 2)))
            handles.append(Line2D([], [], color=SOFT, linewidth=1.2, linestyle=(0, (4, 2)), label=UNKNOWN))
        elif colour == MUTED:
            axes.plot(x * factor, curve, color=MUTED, linewidth=0.9)
            rest.append(one.name)
        else:
            axes.fill_between(x * factor, curve, color=colour, alpha=0.18, linewidth=0)
            axes.plot(x * factor, curve, color=colour)
            handles.append(Patch(color=colour, label=name_of(one.name, 17)))
        top = max(top, float(np.max(curve)))
        dots.append((height, colour))
    if rest:
        word = f"{len(rest)} others" if len(rest) > 1 else name_of(rest[0], 17)
        handles.append(Line2D([], [], color=MUTED, linewidth=0.9, label=word))
    axes.set_ylim(0, top * 1.12 if top > 0 else 1.0)
    if not reads:
        return handles
    for height, colour in dots:
        if height > 0.01 * top:
            axes.plot(reading.mean * factor, height, "o", color=colour, markersize=5, zorder=5)
    _band(axes, reading, factor)
    handles.append(Line2D([], [], color=INK, linewidth=1.2, label="reading"))
    return handles


def _concluded(axes: Any, belief: Mixture, reading: Measurement, factor: float, truth: float | None) -> None:
    """Draw the belief after the reading, close up, with reading and truth."""
    low, high = belief.interval(0.99)
    low = min(low, reading.mean - 3 * reading.sd)
    low = max(low, 0.0) if belief.scale == "log" else low
    high = max(high, reading.mean + 3 * reading.sd)
    if truth is not None and low - 2 * (high - low) < truth < high + 2 * (high - low):
        margin = 0.05 * (high - low)
        low, high = min(low, truth - margin), max(high, truth + margin)
    x = np.linspace(low, high, POINTS)
    curve = np.asarray(belief.density(x))
    axes.fill_between(x * factor, curve, color=LIGHT["pale"], alpha=0.6, linewidth=0)
    axes.plot(x * factor, curve, color=LIGHT["accent"])
    axes.set_ylim(0, float(np.max(curve)) * 1.12 or 1.0)
    _band(axes, reading, factor)
    title = "After: what is believed, close up"
    if truth is not None and low <= truth <= high:
        axes.plot(
            truth * factor,
            0.0,
            "D",
            color=INK,
            markersize=7,
            markerfacecolor=LIGHT["page"],
            clip_on=False,
            zorder=6,
        )
        title += " – diamond: the truth"
    _frame(axes, title, factor, low, high, False)


def _band(axes: Any, reading: Measurement, factor: float) -> None:
    ends = ((reading.mean - reading.sd) * factor, (reading.mean + reading.sd) * factor)
    axes.axvspan(*ends, color=INK, alpha=0.12, linewidth=0)
    axes.axvline(reading.mean * factor, color=INK, linewidth=1.2)


def _frame(axes: Any, title: str, factor: float, low: float, high: float, log: bool) -> None:
    from matplotlib.ticker import FuncFormatter, MaxNLocator

    axes.set_title(title, loc="left", size=SMALL, color=SOFT, pad=5)
    axes.spines["left"].set_visible(False)
    axes.set_yticks([])
    if log:
        axes.set_xscale("log")
        axes.xaxis.set_major_formatter(FuncFormatter(lambda v, _: _tick(v)))
        if math.log10(high / low) > 6:
            axes.xaxis.get_major_locator().set_params(numticks=6)
    else:
        axes.xaxis.set_major_locator(MaxNLocator(5))
    axes.set_xlim(low * factor, high * factor)


def _tick(value: float) -> str:
    """Return a power of ten as a label."""
    if 1e-3 < value < 1e5:
        return f"{value:,.0f}".replace(",", "\u202f") if value >= 1000 else f"{value:.4g}"
    return "10" + str(round(math.log10(value))).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def _range(classes: list[_Class], reading: Measurement) -> tuple[float, float, bool]:
    """Return the ends of an axis on which the listed classes and the reading are to be seen."""
    counted = [c for c in classes if c.weight > COUNTED and c.name != UNKNOWN] or classes
    lows, highs = [reading.mean - 4 * reading.sd, reading.mean], [reading.mean + 4 * reading.sd]
    scale = classes[0].part.scale if classes else "linear"
    for one in counted:
        part = one.part
        ends = part.means - 2.8 * part.sds, part.means + 2.8 * part.sds
        if scale == "log":
            ends = np.exp(np.clip(ends[0], -50, 50)), np.exp(np.clip(ends[1], -50, 50))
        lows.append(float(np.min(ends[0])))
        highs.append(float(np.max(ends[1])))
    low, high = min(lows), max(highs)
    positive = [end for end in lows if end > 0]
    if scale == "log" and positive:
        least = min(positive)
        if high / least > WIDE:
            return least / 1.1, high * 1.1, True
        return max(low, 0.0), high, False
    return (low, high, False) if high > low else (low - 1.0, low + 1.0, False)


def _classes(belief: Belief, quantity_name: str) -> list[_Class]:
    """Return a belief about a quantity, material by material."""
    whole = belief.marginal(quantity_name)
    network = belief.network
    rows = network.hypotheses.material
    found = []
    for i, name in enumerate(network.classes("material")):
        mine = rows == i
        weights = whole.weights[mine]
        if weights.sum() > 0:
            part = replace(whole, weights=weights, means=whole.means[mine], sds=whole.sds[mine])
            found.append(_Class(name, part))
    return found


def prior_curves(axes: Any, belief: Belief, quantity_name: str, shades: Mapping[str, str]) -> list[Any]:
    """Draw the densities of a quantity, a curve a material; return what a legend shows."""
    classes = _classes(belief, quantity_name)
    unit = belief.network.unit(quantity_name)
    centre = belief.marginal(quantity_name).quantile(0.5)
    reading = Measurement(quantity_name, centre, max(abs(centre), 1e-9) * 1e-9, unit)
    low, high, log = _range(classes, reading)
    x = np.geomspace(low, high, 2 * POINTS) if log else np.linspace(low, high, 2 * POINTS)
    factor = unit_of(unit, high)[1]
    axes.set_xlabel(labelled(quantity_name, unit, high), labelpad=2)
    handles = _promised(axes, classes, reading, x, log, shades, factor, reads=False)
    _frame(axes, "", factor, low, high, log)
    return handles
