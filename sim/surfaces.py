"""The surfaces of simulated objects: points and triangles that enclose a shape, for every shape but the box.

A surface is centred on the middle of the shape's bounding box. Its points lie on the true surface, the outermost
ones at the ends of the axes, so that pads and table meet the object exactly where they should; the volume that the
flat triangles cut off is made up for in the modulus, see `sim.bodies`.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from dynamics.mesh import Mesh

AROUND = 24  # points around a circle, a multiple of four
RINGS = 12  # steps from pole to pole of an ellipsoid
LAYERS = 4  # steps along a cylinder's side


def cylinder(size: tuple[float, float, float]) -> Mesh:
    """Return a standing cylinder: its diameters along x and y, and its height [m]."""
    circle = _circle()
    rim, inner = circle / 2, circle / 4
    heights = np.linspace(-0.5, 0.5, LAYERS + 1)
    rings = [_at(inner, heights[0]), *(_at(rim, z) for z in heights), _at(inner, heights[-1])]
    return _closed(rings, bottom=-0.5, top=0.5).scaled(size)


def ellipsoid(size: tuple[float, float, float]) -> Mesh:
    """Return an ellipsoid, a sphere among them, by its three axes [m]."""
    circle = _circle()
    angles = np.linspace(-math.pi / 2, math.pi / 2, RINGS + 1)[1:-1]
    rings = [_at(math.cos(a) / 2 * circle, math.sin(a) / 2) for a in angles]
    return _closed(rings, bottom=-0.5, top=0.5).scaled(size)


def _circle() -> NDArray[np.float64]:
    angles = 2 * math.pi * np.arange(AROUND) / AROUND
    return np.stack([np.cos(angles), np.sin(angles)], axis=1)


def _at(ring: NDArray[np.float64], z: float) -> NDArray[np.float64]:
    return np.column_stack([ring, np.full(len(ring), z)])


def _closed(rings: list[NDArray[np.float64]], bottom: float, top: float) -> Mesh:
    """Join rings of points from bottom to top, and close both ends with a point on the axis."""
    points = np.concatenate([*rings, [[0.0, 0.0, bottom], [0.0, 0.0, top]]])
    low, high = len(points) - 2, len(points) - 1
    last = (len(rings) - 1) * AROUND
    triangles = []
    for k in range(AROUND):
        after = (k + 1) % AROUND
        triangles.append((low, after, k))
        triangles.append((high, last + k, last + after))
        for ring in range(len(rings) - 1):
            a, b = ring * AROUND + k, ring * AROUND + after
            triangles += [(a, b, b + AROUND), (a, b + AROUND, a + AROUND)]
    return Mesh(points, np.array(triangles))
