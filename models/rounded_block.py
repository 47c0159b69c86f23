"""Make the surface of a rounded block, such as a bar of soap: ``python -m models.rounded_block OUT.stl``.

The surface is |2x/a|^4 + |2y/b|^4 + |2z/c|^4 = 1 for edges a, b, c, which has flat sides and round corners.
"""

from __future__ import annotations

import argparse
import struct
import sys
from itertools import product
from pathlib import Path

EXPONENT = 4
Point = tuple[float, float, float]


def rounded_block(edges: Point, steps: int) -> list[tuple[Point, Point, Point]]:
    """Return the triangles of the surface, counterclockwise seen from outside.

    Args:
        edges: lengths along x, y and z.
        steps: squares along a side of a face.
    """
    triangles = []
    for axis, side in product(range(3), (-1, 1)):
        for i, j in product(range(steps), repeat=2):
            quad = [
                _on_surface(axis, side, 2 * (i + a) / steps - 1, 2 * (j + b) / steps - 1, edges)
                for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))
            ]
            if side < 0:
                quad.reverse()
            triangles += [(quad[0], quad[1], quad[2]), (quad[0], quad[2], quad[3])]
    return triangles


def write_stl(path: Path, triangles: list[tuple[Point, Point, Point]]) -> None:
    """Write triangles as binary STL; normals are left to the reader."""
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *a, *b, *c, 0) for a, b, c in triangles)
    path.write_bytes(b"rounded block".ljust(80, b"\0") + struct.pack("<I", len(triangles)) + body)


def _on_surface(axis: int, side: int, u: float, v: float, edges: Point) -> Point:
    """Return the point of the surface in the direction of a point of the cube's face."""
    cube = [0.0, 0.0, 0.0]
    cube[axis], cube[(axis + 1) % 3], cube[(axis + 2) % 3] = float(side), u, v
    size = sum(abs(x) ** EXPONENT for x in cube) ** (1 / EXPONENT)
    x, y, z = (cube[k] / size * edges[k] / 2 for k in range(3))
    return x, y, z


def main(arguments: list[str]) -> int:
    """Write a rounded block."""
    parser = argparse.ArgumentParser(prog="python -m models.rounded_block")
    parser.add_argument("out", type=Path, metavar="OUT.stl")
    parser.add_argument("--edges", type=float, nargs=3, default=(80.0, 56.0, 36.0), metavar="LENGTH")
    parser.add_argument("--steps", type=int, default=8, help="squares along a side of a face")
    options = parser.parse_args(arguments)
    write_stl(options.out, rounded_block(tuple(options.edges), options.steps))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
