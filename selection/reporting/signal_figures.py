"""Figures of raw signals: stress over strain, joint torques without and with the object, forces of a rub."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimation.stiffness.fit import CURVE, ONSET, predict
from selection.reporting.analysis import Hold, Pinching, Rubbing, Squeezing
from selection.reporting.document import Figure
from selection.reporting.drawing import SMALL, Sheet, bare, drawing, only_horizontal_grid
from selection.reporting.palette import LIGHT
from selection.reporting.text import listed, number, plain, quantity

Array = NDArray[np.float64]

MOST_POINTS = 500  # of a cloud
MOST_SAMPLES = 24  # of a hold in one pose
MOST_POSES = 8
MOST_JOINTS = 8
SPIKE = 0.5  # probability to be no spike below which a reading is drawn as one
INK, SOFT, LINE, MUTED = LIGHT["ink"], LIGHT["soft"], LIGHT["line"], LIGHT["muted"]
BLUE, RUST = LIGHT["c1"], LIGHT["c2"]


def stress_strain_curve(name: str, squeezing: Squeezing) -> Figure:
    """Draw stress over strain with the curve fitted to it, as in Fig. 4.4 of the thesis."""
    curve, estimate = squeezing.curve, squeezing.estimate
    parameters = estimate.fit.parameters
    onset = float(parameters[ONSET])
    strain, stress = 100 * (curve.strain - onset), curve.stress / 1e3
    weights = np.asarray(estimate.weights)
    good = weights >= SPIKE if len(weights) == len(stress) else np.ones(len(stress), dtype=bool)
    with drawing():
        sheet = Sheet(3.4)
        axes = sheet.axes(0.62, 0.5, 0.1, 0.12)
        only_horizontal_grid(axes)
        keep = _thinned(len(strain), MOST_POINTS)
        good_rows, spikes = keep[good[keep]], keep[~good[keep]]
        axes.plot(
            strain[good_rows], stress[good_rows], "o", color=BLUE, markersize=2.6, alpha=0.55, label="readings"
        )
        if len(spikes):
            axes.plot(
                strain[spikes], stress[spikes], "o", color=RUST, markersize=3.2, markerfacecolor="none",
                label="taken as spikes",
            )  # fmt: skip
        across = np.linspace(float(np.min(curve.strain)), float(np.max(curve.strain)), 200)
        fitted = predict(parameters, across, curve.geometry)[0] / 1e3
        modulus = (
            f"E = {quantity(estimate.young_modulus, estimate.sd, 'Pa')}"
            if estimate.bound is None
            else f"E ≥ {plain(estimate.bound, 'Pa')}"
        )
        axes.plot(100 * (across - onset), fitted, color=INK, label=f"fit: {modulus}")
        axes.axvline(0, color=SOFT, linewidth=0.8, linestyle=(0, (3, 3)))
        low, high = float(np.min(stress[good])), float(np.max(stress[good]))
        margin = 0.06 * (high - low)
        axes.set_ylim(min(low, 0.0) - margin, high + 2 * margin)
        axes.set_xlabel("Strain from first touch [%]")
        axes.set_ylabel("Stress [kPa]")
        axes.legend(loc="upper left", borderaxespad=0.2)
        if len(spikes) and len(good_rows):
            seen = np.mean((stress[spikes] <= high + 2 * margin) & (stress[spikes] >= min(low, 0.0) - margin))
            outside = "" if seen == 1 else " Spikes beyond the axis are not shown."
        else:
            outside = ""
        slope = "" if len(parameters) <= CURVE else " The modulus is the slope at first touch."
        return sheet.finish(
            name,
            "Stress and strain",
            f"Every reading of the closing pads, and the curve fitted to them.{slope}{outside}",
            f"Stress up to {number(high)} kPa over strain up to {number(float(np.max(strain)))} %; {modulus}.",
        )


def gripper_signals(name: str, squeezing: Squeezing) -> Figure:
    """Draw opening and motor current of the gripper over time."""
    keep = _thinned(len(squeezing.time), 700)
    time = squeezing.time[keep] - squeezing.time[0]
    with drawing():
        sheet = Sheet(3.4)
        above = sheet.axes(0.62, 1.92, 0.1, 0.12)
        below = sheet.axes(0.62, 0.5, 0.1, 1.6)
        for axes, series, label in (
            (above, 1e3 * squeezing.opening, "Opening [mm]"),
            (below, squeezing.effort, "Current [A]"),
        ):
            only_horizontal_grid(axes)
            axes.plot(time, series[keep], color=BLUE, linewidth=1.1)
            axes.set_ylabel(label)
            axes.set_xlim(0, float(time[-1]) if len(time) > 1 and time[-1] > 0 else 1.0)
            axes.yaxis.set_label_coords(-0.105, 0.5)
        above.tick_params(axis="x", labelbottom=False, length=0)
        above.spines["bottom"].set_visible(False)
        below.set_xlabel("Time from first closing [s]")
        opening = squeezing.opening * 1e3
        return sheet.finish(
            name,
            "The gripper's signals",
            "The current tells of force only while the pads move.",
            f"Opening between {number(float(opening.min()))} and {number(float(opening.max()))} mm and motor "
            f"current up to {number(float(squeezing.effort.max()))} A over {number(float(time[-1]))} s.",
        )


def torques(name: str, holds: Sequence[Hold]) -> Figure:
    """Draw every joint's torque without and with the object, less that of the empty hand, pose by pose."""
    holds = holds[:MOST_POSES]
    joints = min(holds[0].load.shape[1], MOST_JOINTS)
    rows = (joints + 2) // 2
    with drawing():
        sheet = Sheet(0.55 + 0.98 * rows)
        reach = _reach(holds)
        for joint in range(joints):
            row, column = divmod(joint, 2)
            left = 0.68 + column * 2.2
            top = 0.1 + row * 0.98
            axes = sheet.axes(left, sheet.height - top - 0.86, sheet.width - left - 2.04, top + 0.14)
            only_horizontal_grid(axes)
            axes.axhline(0, color=SOFT, linewidth=0.6)
            for i, hold in enumerate(holds):
                _pose(axes, i + 1, hold, joint)
            axes.set_ylim(-reach, reach)
            axes.set_xlim(0.45, len(holds) + 0.55)
            axes.set_xticks(range(1, len(holds) + 1))
            axes.yaxis.set_major_locator(_few(3))
            axes.spines["bottom"].set_visible(False)
            axes.tick_params(axis="x", length=0, labelbottom=joint >= joints - 2)
            axes.tick_params(axis="y", labelleft=column == 0)
            axes.text(
                0.01, 1.0, f"joint {joint + 1}", transform=axes.transAxes, va="bottom", color=INK, size=SMALL
            )
        sheet.figure.text(0.01, 0.55, "Torque less the empty hand's [N m]", rotation=90, va="center", color=SOFT)
        sheet.figure.text(1.7 / sheet.width, 0.06 / sheet.height, "Pose", ha="center", color=SOFT)
        _legend(sheet, joints)
        shift = np.abs(np.mean([h.load.mean(axis=0) for h in holds], axis=0))
        most = int(np.argmax(shift))
        return sheet.finish(
            name,
            "Torques without and with the object",
            "In each pose from left to right: empty, with the object, empty again. Bars: what the estimated "
            "payload asks.",
            f"Torques of {joints} joints in {len(holds)} poses; the load shows most in joint {most + 1}, with "
            f"{number(float(shift[most]))} N m on average.",
        )


def friction(name: str, rubbing: Rubbing) -> Figure:
    """Draw the force ratio of every stroke along its way, with the coefficient it came to."""
    with drawing():
        sheet = Sheet(3.2)
        axes = sheet.axes(0.62, 0.5, 0.1, 0.12)
        only_horizontal_grid(axes)
        normal = np.where(rubbing.normal > 0.05 * np.max(rubbing.normal), rubbing.normal, np.nan)
        ratio = rubbing.tangential / normal
        way = np.linspace(0, 100, ratio.shape[1])
        for i, stroke in enumerate(ratio[:12]):
            axes.plot(way, stroke, color=BLUE if i % 2 == 0 else RUST, linewidth=1.1, alpha=0.8)
        mean, sd = rubbing.coefficient, rubbing.sd
        axes.axhspan(mean - sd, mean + sd, color=INK, alpha=0.12, linewidth=0)
        axes.axhline(mean, color=INK, linewidth=1.2)
        axes.set_ylim(0, max(1.6 * mean, mean + 4 * sd))
        axes.set_xlim(0, 100)
        axes.set_xlabel("Share of the stroke [%]")
        axes.set_ylabel("Tangential over normal force")
        from matplotlib.lines import Line2D

        handles = [Line2D([], [], color=BLUE, label="strokes forward")]
        if len(ratio) > 1:
            handles.append(Line2D([], [], color=RUST, label="and back"))
        handles.append(Line2D([], [], color=INK, label=f"μ = {quantity(mean, sd, '1')}"))
        axes.legend(handles=handles, loc="lower right", ncols=1)
        return sheet.finish(
            name,
            "Forces of the rub",
            f"Pressed on with {number(float(np.nanmean(normal)))} N on average. Line and band: the coefficient "
            "found.",
            f"Ratio of tangential to normal force over {len(ratio)} strokes; friction {quantity(mean, sd, '1')}.",
        )


def slides(name: str, pinching: Pinching) -> Figure:
    """Draw what both pads pulled in every slide over what a pad pressed with, and the friction it came to."""
    mean, sd = pinching.coefficient, pinching.sd
    force = np.array([slide.force for slide in pinching.slides])
    pull = np.array([slide.tangential for slide in pinching.slides])
    with drawing():
        sheet = Sheet(3.2)
        axes = sheet.axes(0.62, 0.5, 0.14, 0.12)
        only_horizontal_grid(axes)
        right = 1.25 * float(np.max(force))
        x = np.array([0.0, right])
        axes.fill_between(x, 2 * (mean - sd) * x, 2 * (mean + sd) * x, color=INK, alpha=0.12, linewidth=0)
        axes.plot(x, 2 * mean * x, color=INK, label=f"2 μ F, μ = {quantity(mean, sd, '1')}")
        for slide in pinching.slides:
            ends = [slide.before, slide.after]
            axes.plot(ends, [slide.tangential] * 2, color=BLUE, linewidth=3, alpha=0.35)
        axes.plot(force, pull, "o", color=BLUE, markersize=6, label="slides")
        axes.set_xlim(0, right)
        axes.set_ylim(0, 1.25 * max(float(np.max(pull)), 2 * mean * float(np.max(force))))
        axes.set_xlabel("Force F of a pad [N]")
        axes.set_ylabel("Pull of both pads [N]")
        axes.legend(loc="upper left", borderaxespad=0.2)
        told = [f"{number(p)} N at {number(f)} N" for f, p in zip(force.tolist(), pull.tolist(), strict=True)]
        return sheet.finish(
            name,
            "Forces of the rub",
            "The pads pinch the object and slide down its sides. Bars: the force before and after each slide.",
            f"Pull of {len(told)} slides over the force of a pad: {listed(told)}; friction "
            f"{quantity(mean, sd, '1')}.",
        )


def _pose(axes: Any, at: int, hold: Hold, joint: int) -> None:
    for series, left, colour in ((hold.before, -0.42, MUTED), (hold.load, -0.13, BLUE), (hold.after, 0.16, MUTED)):
        if len(series):
            rows = _thinned(len(series), MOST_SAMPLES)
            x = at + left + 0.26 * np.arange(len(rows)) / max(len(rows) - 1, 1)
            axes.plot(x, series[rows, joint], color=colour, linewidth=0.8)
    level = hold.predicted[joint]
    axes.plot([at - 0.15, at + 0.15], [level, level], color=RUST, linewidth=2.2, solid_capstyle="butt", zorder=4)


def _legend(sheet: Sheet, joints: int) -> None:
    """Draw the legend in the free place after the last joint."""
    from matplotlib.lines import Line2D

    column = joints % 2
    left = 0.68 + 2.2 * column
    axes = sheet.axes(left, 0.12, sheet.width - left - 2.04, sheet.height - 1.0)
    bare(axes)
    handles = [
        Line2D([], [], color=MUTED, linewidth=1.4, label="empty hand"),
        Line2D([], [], color=BLUE, linewidth=1.4, label="with the object"),
        Line2D([], [], color=RUST, linewidth=2.2, label="estimated payload"),
    ]
    axes.legend(handles=handles, loc="lower left", borderaxespad=0.0)


def _reach(holds: Sequence[Hold]) -> float:
    """Return how far the torques' axes go to either side [N m]."""
    level = [np.abs(level) for hold in holds for level in (hold.load.mean(axis=0), hold.predicted)]
    noise = [hold.load.std(axis=0) for hold in holds]
    reach = float(np.nan_to_num(np.max(level) + 3 * np.max(noise)))
    return reach if reach > 0 else 1.0


def _thinned(count: int, most: int) -> NDArray[np.int_]:
    """Return at most so many rows, evenly spread."""
    return (
        np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(int)) if count else np.zeros(0, int)
    )


def _few(count: int) -> Any:
    from matplotlib.ticker import MaxNLocator

    return MaxNLocator(count, symmetric=True, min_n_ticks=3)
