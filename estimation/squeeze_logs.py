"""Stiffness from squeezes by any gripper, read from CSV files: ``python -m estimation.squeeze_logs``.

A file has the columns ``force_N`` and ``opening_m``, one row a reading, in order; files whose names differ only in
a number at the end are repeats of one object.
"""

from __future__ import annotations

import argparse
import csv
import dataclasses
import json
import math
import re
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dynamics.command_line import interrupted
from dynamics.compression import Geometry, StressStrain, geometry_of, stress_strain
from dynamics.errors import InvalidInput, PalpateError
from dynamics.gripper import ParallelGripper, robotiq_2f85
from dynamics.shapes import Shape
from estimation.stiffness import estimate_stiffness
from estimation.stiffness.estimate import StiffnessEstimate
from estimation.stiffness.repeats import (
    FusedStiffness,
    calibrate_series_stiffness,
    fuse_stiffness,
    without_gripper,
)

COLUMNS = ("force_N", "opening_m")


@dataclass(frozen=True)
class SqueezedObject:
    """What the squeezes of one object tell.

    Attributes:
        name: of its files.
        estimates: one a squeeze.
        fused: all together.
    """

    name: str
    estimates: tuple[StiffnessEstimate, ...]
    fused: FusedStiffness


def read_squeeze(path: Path, geometry: Geometry) -> StressStrain:
    """Read force and opening from a CSV file.

    Raises:
        InvalidInput: for a file that cannot be read, or lacks a column, or holds something that is not a number.
    """
    try:
        with path.open(newline="") as file:
            reader = csv.DictReader(file)
            missing = [name for name in COLUMNS if name not in (reader.fieldnames or ())]
            if missing:
                raise InvalidInput(f"{path}: columns", reader.fieldnames, ", ".join(COLUMNS))
            rows = [[float(row[name] or "nan") for name in COLUMNS] for row in reader]
    except (OSError, UnicodeDecodeError, ValueError, TypeError) as error:
        raise InvalidInput(str(path), str(error), "a CSV file of numbers") from None
    table = np.array(rows).reshape(-1, 2)
    return stress_strain(table[:, 0], table[:, 1], geometry)


def series_stiffness_of(paths: Sequence[Path]) -> tuple[float, float]:
    """Return stiffness of gripper and pads and its standard deviation, from squeezes of a rigid block [N/m]."""
    width = _widest(paths)
    plain = Geometry("box", width, width)
    return calibrate_series_stiffness([read_squeeze(path, plain) for path in paths])


def estimate_files(
    name: str,
    paths: Sequence[Path],
    shape: Shape,
    width: float | None,
    poisson: float,
    series: tuple[float, float],
) -> SqueezedObject:
    """Estimate one object's stiffness from its files.

    Args:
        name: of the object.
        paths: its squeezes.
        shape: what is squeezed; a box is as wide as its pads.
        width: extent along the closing direction [m]; None to take it from the openings at contact.
        poisson: Poisson's ratio.
        series: stiffness of gripper and pads, and its standard deviation [N/m].
    """
    known = _widest(paths) if width is None else width
    estimates = _estimates(paths, shape, known, poisson, (math.inf, 0.0) if width is None else series)
    if width is None:
        known = float(np.median([e.onset for e in estimates]))
        estimates = _estimates(paths, shape, known, poisson, series)
    if math.isinf(series[0]):
        return SqueezedObject(name, estimates, fuse_stiffness(estimates))
    together = _estimates(paths, shape, known, poisson, (math.inf, 0.0))
    return SqueezedObject(name, estimates, without_gripper(fuse_stiffness(together), together, *series))


def _widest(paths: Sequence[Path]) -> float:
    """Return the widest opening in some files, which no object in them exceeds [m]."""
    metre = Geometry("box", 1.0, 1.0)
    openings = [
        1.0 - float(np.min(curve.strain)) for curve in (read_squeeze(path, metre) for path in paths) if len(curve)
    ]
    return min(max(openings, default=0.1), 1.0)


def _estimates(
    paths: Sequence[Path], shape: Shape, width: float, poisson: float, series: tuple[float, float]
) -> tuple[StiffnessEstimate, ...]:
    geometry = geometry_of(shape, (width, width, width), _wide(width), poisson=poisson, rule="pad")
    geometry = dataclasses.replace(geometry, series_stiffness=series[0], series_stiffness_sd=series[1])
    return tuple(estimate_stiffness(read_squeeze(path, geometry)) for path in paths)


def main(arguments: list[str] | None = None) -> int:
    """Print the stiffness of every object."""
    parser = argparse.ArgumentParser(
        prog="python -m estimation.squeeze_logs", description="Stiffness from CSV files."
    )
    parser.add_argument("paths", nargs="+", type=Path, help="CSV files, or folders of them")
    parser.add_argument("--shape", default="sphere", choices=("box", "cylinder", "sphere"))
    parser.add_argument("--width", type=float, help="extent along closing [m]; without it, the opening at contact")
    parser.add_argument("--poisson", type=float, default=0.45)
    parser.add_argument(
        "--rigid", nargs="+", type=Path, default=[], help="squeezes of a rigid block, to calibrate"
    )
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args(arguments)
    try:
        series = series_stiffness_of(options.rigid) if options.rigid else (math.inf, 0.0)
        found = [
            estimate_files(name, paths, options.shape, options.width, options.poisson, series)
            for name, paths in _objects(options.paths).items()
        ]
    except PalpateError as error:
        print(error, file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return interrupted(parser.prog)
    if options.json:
        print(json.dumps({"series_stiffness": _finite(series[0]), "objects": {o.name: _plain(o) for o in found}}))
        return 0
    if options.rigid:
        print(f"gripper and pads: {series[0]:.4g} +- {series[1]:.2g} N/m")
    for o in sorted(found, key=lambda o: o.fused.interval[0]):
        each = ", ".join(_words(e.young_modulus, e.interval, e.bound) for e in o.estimates)
        print(f"{o.name:28} {_words(o.fused.young_modulus, o.fused.interval, o.fused.bound):28} of {each}")
    return 0


def _objects(paths: Sequence[Path]) -> dict[str, list[Path]]:
    """Return the files by object."""
    files = [f for path in paths for f in (sorted(path.glob("*.csv")) if path.is_dir() else [path])]
    if not files:
        raise InvalidInput("squeeze logs", [str(path) for path in paths], "at least one CSV file")
    groups: dict[str, list[Path]] = {}
    for file in files:
        groups.setdefault(re.sub(r"[_-]?\d+$", "", file.stem) or file.stem, []).append(file)
    return groups


def _wide(width: float) -> ParallelGripper:
    """Return a gripper that opens as far as an object needs."""
    gripper = robotiq_2f85()
    return dataclasses.replace(gripper, max_opening=max(gripper.max_opening, width))


def _plain(found: SqueezedObject) -> dict[str, object]:
    f = found.fused
    return {
        "young_modulus": _finite(f.young_modulus),
        "sd": _finite(f.sd),
        "interval": [_finite(v) for v in f.interval],
        "bound": f.bound,
        "width": f.width,
        "repeats": [
            {
                "young_modulus": _finite(e.young_modulus),
                "interval": [_finite(v) for v in e.interval],
                "bound": e.bound,
                "width": e.onset,
            }
            for e in found.estimates
        ],
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _words(modulus: float, interval: tuple[float, float], bound: float | None) -> str:
    if bound is not None:
        return f">= {bound / 1e3:.3g} kPa"
    return f"{modulus / 1e3:.3g} kPa ({interval[0] / 1e3:.3g} to {interval[1] / 1e3:.3g})"


if __name__ == "__main__":
    sys.exit(main())
