"""Compute the calibration of the fidelity ``indentation`` again: ``python -m sim.calibrate [FILE]``.

Every soft object that comes with the project is pressed as in `sim.press`; about a second each.
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections.abc import Iterator
from pathlib import Path

from models import objects
from sim.calibration import COLUMNS, TABLE, Key, compute, key_of, rows_of, shorter_side
from sim.truth import TrueObject, read_truth


def calibrated() -> Iterator[tuple[Key, TrueObject]]:
    """Yield the soft objects that come with the project, of those with equal factors one."""
    seen = set()
    for name in objects.names():
        truth = read_truth(objects.locate(name))
        if not truth.is_rigid:
            key = key_of(truth, shorter_side(truth))
            if key not in seen:
                seen.add(key)
                yield key, truth


def about() -> list[str]:
    """Return how the table is computed, in lines of comment."""
    import mujoco

    from sim import press
    from sim.bodies import CELLS, POINTS_AROUND
    from sim.calibration import BENCH_DEPTH, SHALLOW
    from sim.contact import STIFFER, TIMESTEP

    return [
        "# Modulus that pads feel of an object of few cells over the true one: python -m sim.calibrate",
        f"# MuJoCo {mujoco.__version__}; step {TIMESTEP} s; {CELLS['indentation']} cells an axis, "
        f"{POINTS_AROUND['indentation']} points around; contact {STIFFER:g} times stiffer than the object",
        f"# 2F-85 pads, {press.SPEED} m/s, no gravity; fits of theory with a free onset: bench up to strain "
        f"{BENCH_DEPTH}, hand from {SHALLOW} of the depth to the depth",
    ]


def main(arguments: list[str]) -> int:
    """Write the table."""
    parser = argparse.ArgumentParser(prog="python -m sim.calibrate")
    parser.add_argument("file", type=Path, nargs="?", default=TABLE, metavar="FILE")
    options = parser.parse_args(arguments)
    rows = rows_of((key, compute(truth, shorter_side(truth))) for key, truth in calibrated())
    with options.file.open("w", newline="", encoding="utf-8") as file:
        file.write("\n".join(about()) + "\n")
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(rows)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
