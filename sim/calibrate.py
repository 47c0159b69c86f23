"""Compute the calibration of the fidelity ``indentation`` again: ``python -m sim.calibrate [FILE]``.

Every object of the table is pressed as in `sim.press`; some minutes on one core.
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections.abc import Iterator
from itertools import product
from pathlib import Path

from dynamics.objects import DeclaredObject
from dynamics.shapes import Lengths, Shape
from sim.calibration import GRID, POISSON, TABLE, Key
from sim.truth import TrueObject

COLUMNS = ("shape", "width_m", "across_m", "height_m", "poisson", "factor")


def keys() -> Iterator[Key]:
    """Yield every point of the table."""
    for shape, axes in GRID.items():
        for width, across, height, poisson in product(*axes, POISSON):
            yield shape, width, across, height, poisson


def compute(key: Key) -> float:
    """Return the factor of one point of the table."""
    from sim.press import press

    shape, width, across, height, poisson = key
    lengths = (across or width, width, height or width)
    return press(example(shape, lengths, poisson), 1)


def example(shape: Shape, size: Lengths, poisson: float) -> TrueObject:
    """Return an object of a shape whose modulus and mass do not matter.

    Args:
        shape: all but a mesh.
        size: lengths of its bounding box [m].
        poisson: Poisson's ratio.
    """
    declared = DeclaredObject(shape, shape, size, 0.0005, (0.5, 0.0), 0.0)
    return TrueObject(declared, size, 0.1, 5e4, poisson, 0.8, 0.002, "unknown")


def about() -> list[str]:
    """Return how the table is computed, in lines of comment."""
    import mujoco

    from sim import press
    from sim.bodies import CELLS, POINTS_AROUND
    from sim.contact import STIFFER, TIMESTEP

    return [
        "# Modulus that pads feel of an object of few cells over the true one: python -m sim.calibrate",
        f"# MuJoCo {mujoco.__version__}; step {TIMESTEP} s; {CELLS['indentation']} cells an axis, "
        f"{POINTS_AROUND['indentation']} points around; contact {STIFFER:g} times stiffer than the object",
        f"# 2F-85 pads, {press.SPEED} m/s, no gravity; fit of theory with a free onset up to strain {press.DEPTH}",
    ]


def main(arguments: list[str]) -> int:
    """Write the table."""
    parser = argparse.ArgumentParser(prog="python -m sim.calibrate")
    parser.add_argument("file", type=Path, nargs="?", default=TABLE, metavar="FILE")
    options = parser.parse_args(arguments)
    rows = [(*key, f"{compute(key):.4f}") for key in keys()]
    with options.file.open("w", newline="", encoding="utf-8") as file:
        file.write("\n".join(about()) + "\n")
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(rows)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
