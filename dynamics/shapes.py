"""The shapes an object may have: how much of its bounding box each fills, and which of its lengths are one.

A shape is given by the extents of its bounding box along its own x, y and z, z upward.
"""

from __future__ import annotations

import math
from typing import Literal

Shape = Literal["box", "cylinder", "sphere", "ellipsoid", "mesh"]
SHAPES: tuple[Shape, ...] = ("box", "cylinder", "sphere", "ellipsoid", "mesh")

FILL: dict[Shape, float] = {
    "box": 1.0,
    "cylinder": math.pi / 4,
    "sphere": math.pi / 6,
    "ellipsoid": math.pi / 6,
}
"""Volume over that of the bounding box; a mesh's is its own."""

TIED: dict[Shape, tuple[tuple[int, ...], ...]] = {
    "box": ((0,), (1,), (2,)),
    "cylinder": ((0, 1), (2,)),
    "sphere": ((0, 1, 2),),
    "ellipsoid": ((0,), (1,), (2,)),
    "mesh": ((0, 1, 2),),
}
"""Extents that are known together, for they are one length or scale with one: a cylinder's two diameters."""

Lengths = tuple[float, float, float]


def relative_volume_sd(shape: Shape, size: Lengths, sd: Lengths) -> float:
    """Return the relative standard deviation of the volume [-].

        (sd_V / V)^2 = sum over lengths (n sd / length)^2,   n: how many extents the length is.

    Args:
        shape: one of ``SHAPES``.
        size: extents [m].
        sd: their standard deviations [m]; of tied extents the longest one's counts.
    """
    total = 0.0
    for group in TIED[shape]:
        longest = max(group, key=lambda axis: size[axis])
        total += (len(group) * sd[longest] / size[longest]) ** 2
    return math.sqrt(total)


def tied_to(shape: Shape, axis: int) -> tuple[int, ...]:
    """Return the axes whose extents are known together with one axis' extent, itself among them."""
    return next(group for group in TIED[shape] if axis in group)
