"""Pictures of squeezes: force and opening over time, and stress over strain with the modulus in the legend."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from selection.reporting.drawing import look
from selection.robots import Truth
from selection.squeezes import Squeezed

FILES = ("squeeze.png", "squeeze.svg")
AIR_SHOWN = 0.1  # of the strain that was reached, before contact
MOST_TOLD = 8  # squeezes that a legend names


def plot(directory: Path, squeezes: Sequence[Squeezed], truth: Truth, title: str) -> tuple[Path, ...]:
    """Draw the squeezes into a directory, as PNG and as SVG; return the files.

    Args:
        directory: of the run.
        squeezes: in order.
        truth: what the object really is; its modulus is drawn as a line.
        title: of the picture.
    """
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    white = {"figure.facecolor": "white", "savefig.facecolor": "white"}
    with rc_context({**look(), **white}):
        figure = Figure(figsize=(7.2, 9.0), layout="constrained")
        FigureCanvasAgg(figure)
        over_force, over_opening, over_strain = figure.subplots(3, 1, height_ratios=(1, 1, 1.5))
        for number, one in enumerate(squeezes):
            color = f"C{number}"
            start = one.time[0]
            name = _name(one) if number < MOST_TOLD else None
            over_force.plot(one.time - start, one.force, color=color, linewidth=1.2, label=name)
            over_opening.plot(one.time - start, 1e3 * one.opening, color=color, linewidth=1.2)
            if one.estimate is None or one.curve is None:
                continue
            # Strain counts from where the object was touched.
            strain = (one.estimate.onset - one.opening) / one.estimate.geometry.width
            near = strain > -AIR_SHOWN * one.estimate.max_strain
            strain, stress = strain[near], one.curve.stress[near] / 1e3
            top = int(np.argmax(strain))
            over_strain.plot(strain[: top + 1] * 100, stress[: top + 1], ".", color=color, markersize=3)
            over_strain.plot(strain[top:] * 100, stress[top:], color=color, linewidth=0.6, alpha=0.7)
            line = np.linspace(0.0, one.estimate.max_strain, 50)
            label = _legend(one) if number < MOST_TOLD else None
            if label is not None and len(squeezes) > 1:
                label = f"{_name(one)}: {label}"
            fitted = [one.estimate.stress(float(e)) / 1e3 for e in line]
            over_strain.plot(100 * line, fitted, color=color, linewidth=1.6, label=label)
        _add_truth(over_strain, squeezes, truth)
        over_force.set(ylabel="force [N]", title=title)
        over_opening.set(ylabel="opening [mm]", xlabel="time [s]")
        over_strain.set(ylabel="stress [kPa]", xlabel="strain [%]")
        if len(squeezes) > 1:
            over_force.legend(loc="upper right", fontsize=8)
        if over_strain.get_legend_handles_labels()[0]:
            over_strain.legend(loc="upper left", fontsize=8)
        for axes in (over_force, over_opening, over_strain):
            axes.grid(alpha=0.3)
        paths = tuple(directory / name for name in FILES)
        figure.savefig(paths[0], dpi=130)
        figure.savefig(paths[1], metadata={"Date": None})
    return paths


def _name(squeezed: Squeezed) -> str:
    return f"{1e3 * squeezed.stroke.speed:g} mm/s to {1e3 * float(np.min(squeezed.opening)):.1f} mm"


def _legend(squeezed: Squeezed) -> str:
    estimate = squeezed.estimate
    assert estimate is not None
    if estimate.bound is not None:
        return f"E ≥ {estimate.bound / 1e3:.3g} kPa"
    return f"E = {estimate.young_modulus / 1e3:.4g} ± {estimate.sd / 1e3:.2g} kPa"


def _add_truth(axes: object, squeezes: Sequence[Squeezed], truth: Truth) -> None:
    """Draw the true modulus over the law of the contact."""
    known = [s.estimate for s in squeezes if s.estimate is not None and s.estimate.bound is None]
    if not known:
        return
    longest = max(known, key=lambda e: e.max_strain)
    true = truth.properties["elasticity"]
    strain = np.linspace(0.0, longest.max_strain, 50)
    stress = true * longest.geometry.law_of(strain)
    axes.plot(  # type: ignore[attr-defined]
        100 * strain, stress / 1e3, "k--", linewidth=0.9, label=f"true: {true / 1e3:.4g} kPa"
    )
