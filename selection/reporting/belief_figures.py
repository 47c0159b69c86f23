"""Figures of what was thought and believed: gains of actions, classes before and after, beliefs over the steps."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from estimation.observation import Observation
from selection.reporting.document import Figure
from selection.reporting.drawing import SIZE, SMALL, Sheet, bare, drawing, only_horizontal_grid
from selection.reporting.palette import LIGHT
from selection.reporting.story import Score
from selection.reporting.text import bits, listed, name_of, number, percent, seconds, signed

ROW = 0.44  # inches a row with its words above
MOST_ROWS = 12
MOST_CLASSES = 7
FAINT = 0.005  # a class that was as probable as this neither before nor after is among the others
LIVELY = 0.02  # the same over a whole run, once something was measured
INK, SOFT, LINE, MUTED = LIGHT["ink"], LIGHT["soft"], LIGHT["line"], LIGHT["muted"]


@dataclass(frozen=True)
class Learned:
    """What was learned of a quantity: the value found, 90 % intervals at the end and at the start, the truth."""

    name: str
    text: str
    value: float
    final: tuple[float, float]
    first: tuple[float, float]
    truth: float | None


def gains(name: str, scores: Sequence[Score], price: float, choice: str) -> Figure:
    """Draw what the planner expects of every action: bits, their price, and what is left."""
    rows = sorted(scores, key=lambda s: (s.feasible, s.name == choice, s.value), reverse=True)[:MOST_ROWS]
    with drawing():
        sheet = Sheet(0.5 + ROW * max(len(rows), 1))
        axes = sheet.axes(0.14, 0.42, 0.14, 0.02)
        bare(axes)
        low = min([0.0, *(score.value for score in rows if score.feasible)])
        high = max([0.1, *(max(score.bits, score.value) for score in rows)])
        axes.set_xlim(low, high + 1e-9)
        axes.set_ylim(len(rows), 0)
        for i, score in enumerate(rows):
            _gain(axes, i, score, price, score.name == choice, (low, high))
        axes.spines["bottom"].set_visible(True)
        axes.xaxis.set_major_locator(_few_ticks())
        axes.xaxis.set_major_formatter(_plain_formatter())
        axes.set_xlabel("Information [bit]")
        said = [
            f"{s.name} {bits(s.bits)} in {seconds(s.seconds)}, worth {bits(s.value)}"
            if s.feasible
            else f"{s.name} not possible: {s.reason}"
            for s in rows
        ]
        return sheet.finish(
            name,
            "What each action promised",
            f"The whole bar is the information expected, its dark part what is left after the price of time "
            f"({price:g} bit a second).",
            f"Bars of expected information: {listed(said)}. Chosen: {choice or 'none'}.",
        )


def _gain(axes: Any, row: int, score: Score, price: float, chosen: bool, ends: tuple[float, float]) -> None:
    low, high = ends
    weight = "bold" if chosen else "normal"
    word = f"{name_of(score.name, 22)}{' – chosen' if chosen else ''}"
    axes.text(low, row + 0.34, word, weight=weight, color=INK if score.feasible else SOFT, va="baseline")
    cost = price * score.seconds
    follows = score.value - (score.bits - cost)
    more = f" + {follows:.2f} to follow" if follows > 0.005 else ""
    told = (
        f"{score.bits:.2f} − {cost:.2f} for {seconds(score.seconds)}{more} = {signed(score.value)}"
        if score.feasible
        else f"{score.bits:.2f} – {name_of(score.reason, 26)}"
    )
    axes.text(high, row + 0.34, told, ha="right", va="baseline", color=SOFT, size=SMALL)
    at, height = row + 0.62, 0.32
    axes.plot([0, 0], [at - 0.2, at + 0.2], color=SOFT, linewidth=0.8, zorder=4, clip_on=False)
    if not score.feasible:
        axes.barh(at, score.bits, height, color=LINE)
        return
    axes.barh(at, score.bits, height, color=LIGHT["pale"])
    axes.barh(at, score.value, height, color=LIGHT["accent"] if score.value >= 0 else MUTED)


def change(
    name: str, variable: str, before: Mapping[str, float], after: Mapping[str, float], shades: Mapping[str, str]
) -> Figure:
    """Draw the probabilities of a variable's classes before an action as outlines and after it as bars."""
    peak = {key: max(before.get(key, 0.0), after.get(key, 0.0)) for key in {**before, **after}}
    order = sorted(peak, key=lambda key: (-after.get(key, 0.0), -before.get(key, 0.0), key))
    shown = [key for key in order if peak[key] >= FAINT][:MOST_CLASSES]
    rest = [key for key in order if key not in shown]
    rows = [(key, before.get(key, 0.0), after.get(key, 0.0), shades.get(key, MUTED)) for key in shown]
    if rest:
        word = f"{len(rest)} others" if len(rest) > 1 else rest[0]
        rows.append((word, sum(before.get(k, 0.0) for k in rest), sum(after.get(k, 0.0) for k in rest), MUTED))
    with drawing():
        sheet = Sheet(0.48 + 0.3 * len(rows))
        axes = sheet.axes(1.52, 0.42, 1.36, 0.02)
        bare(axes)
        axes.set_xlim(0, 1)
        axes.set_ylim(len(rows), 0)
        for i, (word, old, new, colour) in enumerate(rows):
            _label(axes, i, word)
            axes.barh(i + 0.5, new, 0.46, color=colour)
            axes.barh(i + 0.5, old, 0.74, facecolor="none", edgecolor=SOFT, linewidth=0.9)
            said = percent(new) if percent(old) == percent(new) else f"{percent(old)} → {percent(new)}"
            axes.text(1.05, i + 0.5, said, va="center", color=SOFT, size=SMALL)
        axes.axvline(0.0, color=SOFT, linewidth=0.8)
        axes.spines["bottom"].set_visible(True)
        axes.set_xticks([0, 0.5, 1], ["0", "50", "100"])
        axes.set_xlabel("Probability [%]")
        words = [f"{word} from {percent(old)} to {percent(new)}" for word, old, new, _ in rows]
        return sheet.finish(
            name,
            f"What was believed of the {variable}",
            "Outlines: before. Bars: after.",
            f"Probabilities of the {variable}: {listed(words)}.",
        )


def perceived(name: str, seen: Observation, shades: Mapping[str, str]) -> Figure:
    """Draw how well what was perceived fits each class, relative to the best."""
    best = max(value for _, value in seen.likelihoods)
    order = sorted(seen.likelihoods, key=lambda item: -item[1])[:MOST_ROWS]
    with drawing():
        sheet = Sheet(0.48 + 0.3 * len(order))
        axes = sheet.axes(1.52, 0.42, 0.6, 0.02)
        bare(axes)
        axes.set_xlim(0, 1)
        axes.set_ylim(len(order), 0)
        for i, (word, value) in enumerate(order):
            _label(axes, i, word)
            axes.barh(i + 0.5, value / best, 0.46, color=shades.get(word, MUTED))
            axes.text(1.03, i + 0.5, number(value / best, 2), va="center", color=SOFT, size=SMALL)
        axes.axvline(0.0, color=SOFT, linewidth=0.8)
        axes.spines["bottom"].set_visible(True)
        axes.set_xticks([0, 0.5, 1], ["0", "0.5", "1"])
        axes.set_xlabel("Likelihood, relative to the best")
        words = [f"{word} {number(value / best, 2)}" for word, value in order]
        return sheet.finish(
            name,
            "What was perceived",
            f"How well it fits each {name_of(seen.variable)}, whatever was believed before.",
            f"Relative likelihoods of the {seen.variable}: {listed(words)}.",
        )


def _label(axes: Any, row: int, word: str) -> None:
    """Name a row to the left of its bar, in smaller letters if it is long."""
    name = name_of(word, 19)
    size = SMALL if len(name) > 16 else SIZE
    axes.text(-0.035, row + 0.5, name, ha="right", va="center", color=INK, size=size)


def course(
    name: str,
    variable: str,
    moments: Sequence[tuple[str, Mapping[str, float]]],
    shades: Mapping[str, str],
    threshold: float | None,
) -> Figure:
    """Draw how the probabilities went from moment to moment."""
    later = [found for _, found in moments[1:]] or [moments[0][1]]
    tops = [key for key in shades if max(found.get(key, 0.0) for found in later) >= LIVELY][:6]
    rest = [key for key in {**moments[0][1], **moments[-1][1]} if key not in tops]
    lines = [(key, [found.get(key, math.nan) for _, found in moments], shades[key]) for key in tops]
    if rest:
        word = f"{len(rest)} others" if len(rest) > 1 else rest[0]
        lines.append((word, [sum(found.get(key, 0.0) for key in rest) for _, found in moments], MUTED))
    with drawing():
        sheet = Sheet(2.9)
        axes = sheet.axes(0.6, 0.45, 1.5, 0.12)
        only_horizontal_grid(axes)
        last = len(moments) - 1
        axes.set_xlim(-0.08, max(last, 1))
        axes.set_ylim(-0.02, 1.02)
        axes.set_yticks([0, 0.25, 0.5, 0.75, 1], ["0", "25", "50", "75", "100"])
        if threshold is not None:
            axes.axhline(threshold, color=SOFT, linewidth=0.8, linestyle=(0, (3, 3)))
        for key, line, colour in reversed(lines):
            style = (0, (4, 2)) if key == "unknown" else "solid"
            width = 1.0 if colour == MUTED else 1.6
            axes.plot(
                line, color=colour, linestyle=style, linewidth=width, marker="o", markersize=4, clip_on=False
            )
        ends = [(line[-1] if math.isfinite(line[-1]) else 0.0, i) for i, (_, line, _) in enumerate(lines)]
        for at, i in _apart(ends, 0.075):
            key, _, colour = lines[i]
            own, moved = ((height + 0.02) / 1.04 for height in (ends[i][0], at))
            axes.text(1.05, moved, name_of(key, 19), transform=axes.transAxes, va="center", color=INK, size=SMALL)
            axes.plot([1.015, 1.04], [own, moved], transform=axes.transAxes, color=colour, clip_on=False)
        every = max(1, math.ceil(len(moments) / 6))
        marks = list(range(0, len(moments), every))
        axes.set_xticks(marks, [name_of(moments[i][0], 12) for i in marks])
        for label, i in zip(axes.get_xticklabels(), marks, strict=True):
            label.set_ha("left" if i == 0 else ("right" if i == last and last > 1 else "center"))
        axes.set_ylabel("Probability [%]")
        first, final = moments[0][1], moments[-1][1]
        words = [f"{key} from {percent(first.get(key, 0.0))} to {percent(final.get(key, 0.0))}" for key in tops]
        goal = "" if threshold is None else f"Dashed: the {100 * threshold:g} % at which it would stop."
        return sheet.finish(
            name, f"How the {variable} emerged", goal, f"Probabilities over the steps: {listed(words)}."
        )


def learned(name: str, rows: Sequence[Learned]) -> Figure:
    """Draw intervals of quantities at the end and at the start, relative to the value found."""
    spans = [abs(end / row.value - 1) for row in rows for end in row.final]
    spans += [abs(row.truth / row.value - 1) for row in rows if row.truth is not None]
    reach = min(max([0.02, *spans]) * 1.15, 1.5)
    with drawing():
        sheet = Sheet(0.5 + ROW * len(rows))
        axes = sheet.axes(0.12, 0.42, 0.12, 0.02)
        bare(axes)
        axes.set_xlim(-reach, reach)
        axes.set_ylim(len(rows), 0)
        axes.axvline(0, color=LINE, linewidth=1)
        for i, row in enumerate(rows):
            axes.text(-reach, i + 0.34, name_of(row.name, 22), va="baseline", color=INK)
            axes.text(reach, i + 0.34, row.text, ha="right", va="baseline", color=SOFT, size=SMALL)
            at = i + 0.66
            for ends, height, colour in ((row.first, 0.06, MUTED), (row.final, 0.26, LIGHT["accent"])):
                left, right = (max(-reach, min(reach, end / row.value - 1)) for end in ends)
                axes.barh(at, right - left, height, left=left, color=colour)
            if row.truth is not None and abs(row.truth / row.value - 1) <= reach:
                axes.plot(
                    row.truth / row.value - 1, at, "D", color=INK, markersize=6, markerfacecolor=LIGHT["page"]
                )
        axes.spines["bottom"].set_visible(True)
        axes.xaxis.set_major_locator(_few_ticks(5))
        axes.xaxis.set_major_formatter(_percent_formatter())
        axes.set_xlabel("Deviation from the value found [%]")
        words = [f"{row.name} {row.text}" for row in rows]
        truths = any(row.truth is not None for row in rows)
        return sheet.finish(
            name,
            "How well it is known",
            "Thick: the 90 % interval at the end. Thin: at the start, cut at the edges."
            + (" Diamonds: the truth." if truths else ""),
            f"Quantities with their 90 % intervals: {listed(words)}.",
        )


def _apart(ends: Sequence[tuple[float, int]], gap: float) -> list[tuple[float, int]]:
    """Return heights moved apart so that the words there do not overlap, within 0 to 1, each with its number."""
    placed = sorted(ends, key=lambda end: (end[0], end[1]))
    heights: list[float] = []
    for at, _ in placed:
        heights.append(max(at, heights[-1] + gap) if heights else max(at, 0.0))
    ceiling = 1.0
    for i in reversed(range(len(heights))):
        heights[i] = min(heights[i], ceiling)
        ceiling = heights[i] - gap
    return [(height, key) for height, (_, key) in zip(heights, placed, strict=True)]


def _few_ticks(count: int = 5) -> Any:
    from matplotlib.ticker import MaxNLocator

    return MaxNLocator(count)


def _plain_formatter() -> Any:
    from matplotlib.ticker import FuncFormatter

    return FuncFormatter(lambda x, _: f"{x:.3g}".replace("-", "−"))


def _percent_formatter() -> Any:
    from matplotlib.ticker import FuncFormatter

    return FuncFormatter(lambda x, _: f"{100 * x:+.3g}".replace("-", "−").replace("+0", "0"))
