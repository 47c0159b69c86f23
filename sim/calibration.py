"""How much too stiff the few cells of the fidelity ``indentation`` are under pads, as it was computed beforehand.

``calibration.csv`` holds the factor of `sim.press` over shape, size and Poisson's ratio, and how it was computed;
``python -m sim.calibrate`` computes it again. Between its points the factor's logarithm is linear in those of
the lengths, and beyond them the nearest point counts. A mesh, of which there is no table, is pressed when built.
"""

from __future__ import annotations

import csv
import math
from functools import cache
from itertools import product
from pathlib import Path

from dynamics.shapes import Lengths, Shape
from sim.truth import TrueObject

TABLE = Path(__file__).parent / "calibration.csv"
POISSON = (0.0, 0.3, 0.4, 0.45)
WIDTHS = (0.02, 0.035, 0.06, 0.085)  # m
SIDES = (0.02, 0.04, 0.08, 0.16, 0.3)  # m
AXES = (0.02, 0.04, 0.08, 0.16)  # m
TIED = (0.0,)
GRID: dict[Shape, tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...]]] = {
    "box": (WIDTHS, SIDES, SIDES),
    "cylinder": (WIDTHS, TIED, SIDES),
    "sphere": (WIDTHS, TIED, TIED),
    "ellipsoid": (WIDTHS, AXES, AXES),
}
"""Lengths of the table along the closing direction, across it, and upward [m]; 0 for one that is not free."""

Key = tuple[Shape, float, float, float, float]


def modulus_factor(truth: TrueObject) -> float:
    """Return the modulus that pads feel of an object of few cells, over the true one [-].

    The pads are those of the 2F-85 and close along the shorter side.
    """
    axis = 0 if truth.size[0] < truth.size[1] else 1
    if truth.shape == "mesh":
        from sim.press import press

        return press(truth, axis)
    lengths = truth.size[axis], truth.size[1 - axis], truth.size[2]
    return interpolate(truth.shape, lengths, truth.poisson)


def interpolate(shape: Shape, lengths: Lengths, poisson: float) -> float:
    """Return the factor of a shape from the table.

    Args:
        shape: one of ``GRID``.
        lengths: along the closing direction, across it, and upward [m].
        poisson: Poisson's ratio.
    """
    table = stored()
    places = [
        _between([math.log(x) for x in axis] if len(axis) > 1 else [0.0], math.log(length))
        for axis, length in zip(GRID[shape], lengths, strict=True)
    ]
    places.append(_between(list(POISSON), poisson))
    logarithm = 0.0
    for corner in product((0, 1), repeat=4):
        share = math.prod(place[1] if end else 1 - place[1] for place, end in zip(places, corner, strict=True))
        if share > 0:
            a, b, c, d = (place[0] + end for place, end in zip(places, corner, strict=True))
            key = (shape, GRID[shape][0][a], GRID[shape][1][b], GRID[shape][2][c], POISSON[d])
            logarithm += share * math.log(table[key])
    return math.exp(logarithm)


@cache
def stored() -> dict[Key, float]:
    """Return the table as it is stored."""
    with TABLE.open(newline="", encoding="utf-8") as file:
        rows = csv.DictReader(line for line in file if not line.startswith("#"))
        return {
            (
                next(shape for shape in GRID if shape == row["shape"]),
                float(row["width_m"]),
                float(row["across_m"]),
                float(row["height_m"]),
                float(row["poisson"]),
            ): float(row["factor"])
            for row in rows
        }


def _between(axis: list[float], value: float) -> tuple[int, float]:
    """Return the interval of an axis that a value is in, and its share of the way to the interval's end."""
    if len(axis) == 1:
        return 0, 0.0
    value = min(max(value, axis[0]), axis[-1])
    low = max(i for i in range(len(axis) - 1) if axis[i] <= value)
    return low, (value - axis[low]) / (axis[low + 1] - axis[low])
