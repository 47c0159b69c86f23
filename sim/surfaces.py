"""The surfaces of simulated objects: points and triangles that enclose a shape.

A surface is centred on the middle of the shape's bounding box. Its points lie on the true surface, the outermost
ones at the ends of the axes, so that pads and table meet the object exactly where they should; the volume that the
flat triangles cut off is made up for in the modulus, see `sim.bodies`. Pads are held by points, not by what is in
between: there is one at least every ``SPACING`` across, none in the middle, so that two are under a pad; and every
``RISE`` upward, one in the middle, for a pad that holds a tall body above it must not make it lean.

A soft body that is round is touched over a patch, by Hertz of radius (3 F R / 4 E*)^(1/3): 7 mm at 18 N for a ball
of 1 MPa and 60 mm, more for a softer one. Where its surface cannot form one it has flats of a quarter of its
radius, for held by two points it would turn between the pads as freely as on a bearing, and roll off at a touch.
"""

from __future__ import annotations

import math
from itertools import product

import numpy as np
from numpy.typing import NDArray

from dynamics.mesh import Mesh

Array = NDArray[np.float64]
Size = tuple[float, float, float]

SPACING = 0.019  # m; less than a pad's width
FOOT = 0.02  # radius of the flat that a round body stands on, over its diameter
RISE = 0.0125  # m; a third of a pad's length


def box(size: Size) -> Mesh:
    """Return a box by its three edges [m]."""
    counts = [_steps(size[0]), _steps(size[1]), _rises(size[2])]
    numbers: dict[tuple[int, int, int], int] = {}

    def number(cell: tuple[int, int, int]) -> int:
        return numbers.setdefault(cell, len(numbers))

    triangles = []
    for axis, end in product(range(3), (0, 1)):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for i, j in product(range(counts[u]), range(counts[v])):
            quad = []
            for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)):
                cell = [0, 0, 0]
                cell[axis], cell[u], cell[v] = end * counts[axis], i + a, j + b
                quad.append(number((cell[0], cell[1], cell[2])))
            if not end:
                quad.reverse()
            triangles += [(quad[0], quad[1], quad[2]), (quad[0], quad[2], quad[3])]
    points = np.array(list(numbers), dtype=np.float64) / counts - 0.5
    return Mesh(points, np.array(triangles)).scaled(size)


def cylinder(size: Size, around: int = 24) -> Mesh:
    """Return a standing cylinder: its diameters along x and y, and its height [m].

    Args:
        size: lengths of its bounding box [m].
        around: points around it, a multiple of four.
    """
    circle = _circle(around)
    heights = np.linspace(-0.5, 0.5, _rises(size[2]) + 1)
    return _closed([_at(circle / 2, z) for z in heights]).scaled(size)


def ellipsoid(size: Size, around: int = 24, flats: bool = False) -> Mesh:
    """Return an ellipsoid, a sphere among them, by its three axes [m].

    Args:
        size: lengths of its axes [m].
        around: points around it, a multiple of eight; from pole to pole it has half as many steps.
        flats: whether it is flat where it stands and where pads close on it, out to the points next to those;
            if not it has a small foot.
    """
    circle = _circle(around)
    angles = np.linspace(-math.pi / 2, math.pi / 2, around // 2 + 1)[1:-1]
    rings = [_at(math.cos(a) / 2 * circle, math.sin(a) / 2) for a in angles]
    if not flats:  # but for a small foot: a ball on a point tips over in a few seconds and rolls away
        return _closed([_at(FOOT * circle, -0.5), *rings, _at(FOOT * circle, 0.5)]).scaled(size)
    whole = _closed(rings)
    points = whole.points.copy()
    # Pads close on a sphere along its axes and half-way between, on any other along its axes.
    sides = _at(_circle(8 if len(set(size)) == 1 else 4), 0.0)
    edge = math.cos(2 * math.pi / around) / 2 - 1e-9
    for towards in (*sides, np.array([0.0, 0.0, -1.0]), np.array([0.0, 0.0, 1.0])):
        near = points @ towards >= edge
        points[near] += np.outer(0.5 - points[near] @ towards, towards)
    return Mesh(points, whole.triangles).scaled(size)


def _steps(length: float) -> int:
    """Return into how many steps a length across is divided, an odd number."""
    return max(3, math.ceil(length / SPACING) // 2 * 2 + 1)


def _rises(height: float) -> int:
    """Return into how many steps a height is divided, an even number."""
    return max(4, 2 * math.ceil(height / RISE / 2))


def _circle(around: int) -> Array:
    angles = 2 * math.pi * np.arange(around) / around
    return np.stack([np.cos(angles), np.sin(angles)], axis=1)


def _at(ring: Array, z: float) -> Array:
    return np.column_stack([ring, np.full(len(ring), z)])


def _closed(rings: list[Array]) -> Mesh:
    """Join rings of points from z = -1/2 up to 1/2, and close both ends with a point on the axis."""
    around = len(rings[0])
    points = np.concatenate([*rings, [[0.0, 0.0, -0.5], [0.0, 0.0, 0.5]]])
    low, high = len(points) - 2, len(points) - 1
    last = (len(rings) - 1) * around
    triangles = []
    for k in range(around):
        after = (k + 1) % around
        triangles += [(low, after, k), (high, last + k, last + after)]
        for ring in range(len(rings) - 1):
            a, b = ring * around + k, ring * around + after
            triangles += [(a, b, b + around), (a, b + around, a + around)]
    return Mesh(points, np.array(triangles))
