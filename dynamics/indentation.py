"""How much stiffer a block feels under pads that are smaller than its faces: kappa, from a finite-element table.

    kappa = F / (A_pad E e)

for the force F at the strain e. The table holds kappa for pads that hold the surface sideways and for pads that
slip, over Poisson's ratio, slenderness L / sqrt(B H), face ratio H / B, and the pad's shares a / B and b / H of a
face. Its values are Richardson's extrapolation 2 k(12) - k(6) of :class:`dynamics.elasticity.PressedBlock` with 12
and 6 cells per half extent: the corner under a pad's edge makes the error of k(n) proportional to 1 / n.
``python -m dynamics.indentation FILE`` computes the table again.
"""

from __future__ import annotations

import csv
import math
import sys
from collections.abc import Sequence
from functools import cache
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from dynamics.elasticity import PressedBlock

Array = NDArray[np.float64]

TABLE = Path(__file__).parent / "indentation.csv"
POISSON = (0.0, 0.15, 0.3, 0.45)
SLENDERNESS = (0.25, 0.5, 1.0, 2.0, 4.0)
FACE_RATIO = (1.0, 2.0, 4.0)
SHARES = tuple(k / 6 for k in range(1, 7))
COARSE, FINE = 6, 12  # cells per half extent
INTERPOLATION_SD = 0.015  # relative, of the table between its points; see the tests


def indentation_factor(
    size: tuple[float, float, float], pad: tuple[float, float], poisson: float
) -> tuple[float, float]:
    """Return kappa and its standard deviation, for pads centred on two opposite faces of a block.

    The value is that of pads that hold the surface; the standard deviation covers pads that slip and the table's
    interpolation. Beyond the table the block is cut to its range: material that far from a pad carries no load.

    Args:
        size: of the block along the closing direction, across and along the pad [m].
        pad: the pad's extents across and along [m].
        poisson: Poisson's ratio, in [0, 0.5); the table ends at 0.45.
    """
    length, across, along = size
    a, b = min(pad[0], across), min(pad[1], along)
    if along < across:  # the table has the longer side along
        across, along, a, b = along, across, b, a
    across, along = min(across, a / SHARES[0]), min(along, b / SHARES[0])
    if along < across:
        across, along, a, b = along, across, b, a
    along = max(b, min(along, FACE_RATIO[-1] * across))
    place = (
        poisson,
        math.log(length / math.sqrt(across * along)),
        math.log(along / across),
        math.log(a / across),
        math.log(b / along),
    )
    axes = (
        np.array(POISSON),
        np.log(SLENDERNESS),
        np.log(FACE_RATIO),
        np.log(SHARES),
        np.log(SHARES),
    )
    logs = _interpolate(_table(), axes, place)
    glued, slipping = math.exp(logs[0]), math.exp(logs[1])
    return glued, math.hypot((glued - slipping) / math.sqrt(12.0), INTERPOLATION_SD * glued)


def compute_row(poisson: float, slenderness: float, face_ratio: float) -> Array:
    """Return kappa of every pair of shares, glued and slipping, for one block, (6, 6, 2)."""
    across, along = 1 / math.sqrt(face_ratio), math.sqrt(face_ratio)
    found = []
    for cells in (COARSE, FINE):
        block = PressedBlock.of((across, along, slenderness), poisson, cells)
        k = cells // COARSE
        found.append(
            [
                [[block.force(k * i, k * j, glued=g) * 36 / (i * j) for g in (True, False)] for j in range(1, 7)]
                for i in range(1, 7)
            ]
        )
    coarse, fine = np.array(found)
    return np.asarray(2 * fine - coarse)  # forces of strain 1 with E = 1 on a face of area 1


def compute_table(path: Path) -> None:
    """Compute the whole table and write it as CSV."""
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["poisson", "slenderness", "face_ratio", "across", "along", "glued", "slipping"])
        for poisson, slenderness, face_ratio in product(POISSON, SLENDERNESS, FACE_RATIO):
            kappa = compute_row(poisson, slenderness, face_ratio)
            for i, j in product(range(6), repeat=2):
                shares = (f"{i + 1}/6", f"{j + 1}/6")
                values = (f"{v:.4f}" for v in kappa[i, j])
                writer.writerow([poisson, slenderness, face_ratio, *shares, *values])
            file.flush()


@cache
def _table() -> Array:
    """Return the logarithms of kappa, (4, 5, 3, 6, 6, 2)."""
    with TABLE.open(newline="") as file:
        rows = [(float(row["glued"]), float(row["slipping"])) for row in csv.DictReader(file)]
    shape = (len(POISSON), len(SLENDERNESS), len(FACE_RATIO), 6, 6, 2)
    table: Array = np.log(np.array(rows)).reshape(shape)
    return table


def _interpolate(values: Array, axes: Sequence[Array], place: Sequence[float]) -> Array:
    """Return a table's last axis at a place, linear along every other axis and constant beyond their ends."""
    table: Array = values
    for axis, at in zip(axes, place, strict=True):
        upper = int(np.clip(np.searchsorted(axis, at), 1, len(axis) - 1))
        share = float(np.clip((at - axis[upper - 1]) / (axis[upper] - axis[upper - 1]), 0.0, 1.0))
        table = np.asarray((1 - share) * table[upper - 1] + share * table[upper])
    return table


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: python -m dynamics.indentation FILE")
    compute_table(Path(sys.argv[1]))
