"""How much too stiff the few cells of the fidelity ``indentation`` are under pads.

An object's cells do not follow the law of its contact quite, nor are they as stiff wherever the pads take hold, so
there is a factor (see `sim.press`) for every depth of squeeze, with pads where the hand closes them, and one for
the bench, whose pads are in the middle. ``calibration.csv`` holds those of the objects that come with the project,
and how they were computed; ``python -m sim.calibrate`` computes them again. Any other object is pressed when it is
first built, in about a second.
"""

from __future__ import annotations

import csv
import hashlib
import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from dynamics.errors import InvalidInput
from dynamics.grasping import grasp_height
from dynamics.gripper import robotiq_2f85
from sim.truth import TrueObject

TABLE = Path(__file__).parent / "calibration.csv"
DEPTHS = (0.025, 0.05, 0.1, 0.15, 0.2, 0.3)  # largest strain of a squeeze
SHALLOW = 0.25  # share of it from which a squeeze is read: less, and the object would fall
BENCH_DEPTH = 0.10  # strain to which the bench's factor holds, read from 0 on
FORCE = 54.0  # N at which the hand ends a squeeze
COLUMNS = (
    "shape", "width_m", "across_m", "height_m", "poisson", "mesh", "above_m", "bench",
    *(f"hand_{depth:g}" for depth in DEPTHS),
)  # fmt: skip


@dataclass(frozen=True)
class Key:
    """What the factors of an object depend on.

    Attributes:
        shape: one of `dynamics.shapes.SHAPES`.
        lengths: along the closing direction, across it, and upward [um].
        poisson: Poisson's ratio.
        mesh: digest of a mesh's surface; empty for other shapes.
        above: height of the pads' middle over the object's where the hand closes them [um].
    """

    shape: str
    lengths: tuple[int, int, int]
    poisson: float
    mesh: str
    above: int


@dataclass(frozen=True)
class Factors:
    """Modulus that pads feel of an object of few cells, over the true one [-].

    Attributes:
        bench: with pads in the middle, over strains up to ``BENCH_DEPTH``.
        hand: with pads where the hand closes them, for squeezes of ``DEPTHS``.
    """

    bench: float
    hand: tuple[float, ...]

    def at(self, depth: float) -> float:
        """Return the hand's factor for a squeeze to a strain, between those of ``DEPTHS`` by its logarithm."""
        return float(np.interp(math.log(depth), np.log(DEPTHS), self.hand))


def modulus_factor(truth: TrueObject) -> float:
    """Return the factor of an object that the hand squeezes along its shorter side [-]."""
    return factors_of(truth, shorter_side(truth)).at(depth_reached(truth))


def bench_factor(truth: TrueObject, axis: int) -> float:
    """Return the factor of an object on the bench, pressed along its axis 0 or 1 [-]."""
    return factors_of(truth, axis).bench


def factors_of(truth: TrueObject, axis: int) -> Factors:
    """Return the factors of an object: the stored ones, or it is pressed."""
    key = key_of(truth, axis)
    if key not in _known():
        _known()[key] = compute(truth, axis)
    return _known()[key]


def compute(truth: TrueObject, axis: int) -> Factors:
    """Press an object along an axis, on the bench and as the hand does, and return its factors."""
    from sim.press import press

    middle = press(truth, axis)
    above = height_above(truth, axis)
    held = middle if abs(above) < 1e-6 else press(truth, axis, above)
    hand = tuple(held.factor(SHALLOW * depth, depth) for depth in DEPTHS)
    return Factors(middle.factor(0.0, BENCH_DEPTH), hand)


def depth_reached(truth: TrueObject) -> float:
    """Return the strain to which the hand squeezes an object: the deepest, or where ``FORCE`` is met."""
    from sim.press import under_pads

    geometry = under_pads(truth, shorter_side(truth))
    strains = np.linspace(DEPTHS[0], DEPTHS[-1], 200)
    enough = truth.young_modulus * geometry.area * geometry.law_of(strains) >= FORCE
    return float(strains[int(np.argmax(enough))]) if enough.any() else DEPTHS[-1]


def shorter_side(truth: TrueObject) -> int:
    """Return the horizontal axis that the hand closes along."""
    return 0 if truth.size[0] < truth.size[1] else 1


def height_above(truth: TrueObject, axis: int) -> float:
    """Return how high above an object's middle the hand closes its pads [m]; 0 where it cannot."""
    try:
        return grasp_height(robotiq_2f85("pad"), truth.declared, axis) - truth.declared.size[2] / 2
    except InvalidInput:
        return 0.0


def key_of(truth: TrueObject, axis: int) -> Key:
    """Return what the factors of an object depend on."""
    mesh = truth.declared.mesh
    digest = ""
    if truth.shape == "mesh" and mesh is not None:
        whole = np.round(mesh.points / mesh.extents, 6).tobytes() + mesh.triangles.tobytes()
        digest = hashlib.sha256(whole).hexdigest()[:16]
    lengths = tuple(round(1e6 * x) for x in (truth.size[axis], truth.size[1 - axis], truth.size[2]))
    above = round(1e6 * height_above(truth, axis))
    return Key(truth.shape, lengths, round(truth.poisson, 6), digest, above)  # type: ignore[arg-type]


def stored() -> dict[Key, Factors]:
    """Return the factors as they are stored."""
    with TABLE.open(newline="", encoding="utf-8") as file:
        rows = csv.DictReader(line for line in file if not line.startswith("#"))
        return {_key(row): _factors(row) for row in rows}


def rows_of(entries: Iterable[tuple[Key, Factors]]) -> list[tuple[str, ...]]:
    """Return factors as rows of the table."""
    return [
        (
            key.shape,
            *(f"{length / 1e6:g}" for length in key.lengths),
            f"{key.poisson:g}",
            key.mesh,
            f"{key.above / 1e6:g}",
            f"{factors.bench:.4f}",
            *(f"{factor:.4f}" for factor in factors.hand),
        )
        for key, factors in entries
    ]


@cache
def _known() -> dict[Key, Factors]:
    return stored() if TABLE.exists() else {}


def _key(row: dict[str, str]) -> Key:
    width, across, height = (round(1e6 * float(row[name])) for name in ("width_m", "across_m", "height_m"))
    above = round(1e6 * float(row["above_m"]))
    return Key(row["shape"], (width, across, height), float(row["poisson"]), row["mesh"], above)


def _factors(row: dict[str, str]) -> Factors:
    return Factors(float(row["bench"]), tuple(float(row[f"hand_{depth:g}"]) for depth in DEPTHS))
