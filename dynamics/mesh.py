"""A closed triangle mesh of an object's surface: read from STL or OBJ, and checked before anything is made of it.

A mesh that a soft body can be made of is closed (every edge joins two triangles), oriented (all triangles turn
outward), not too large, in one piece, and seen whole from its middle (star-shaped), for the body is filled with
tetrahedra from there.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from dynamics.errors import InvalidInput

Array = NDArray[np.float64]

MAX_BYTES = 20_000_000
MAX_TRIANGLES = 4000  # more would only cost time: the deformation has a few cells an axis
WELD = 1e-6  # of the diagonal: points nearer than this are one, for STL repeats them in every triangle
_STL_HEADER = 84
_STL_RECORD = 50


@dataclass(frozen=True)
class Mesh:
    """Points and triangles of a surface.

    Attributes:
        points: [m], (N, 3).
        triangles: point numbers, counterclockwise seen from outside, (M, 3).
    """

    points: Array
    triangles: NDArray[np.int64]

    @property
    def extents(self) -> tuple[float, float, float]:
        """Lengths of the bounding box [m]."""
        x, y, z = (float(e) for e in np.ptp(self.points, axis=0))
        return x, y, z

    @property
    def volume(self) -> float:
        """Enclosed volume, the sum of the tetrahedra from the origin [m^3]; negative if turned inside out."""
        a, b, c = (self.points[self.triangles[:, i]] for i in range(3))
        return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)

    @property
    def fill(self) -> float:
        """Share of the bounding box that it fills."""
        return self.volume / math.prod(self.extents)

    def center_of_volume(self) -> Array:
        """Return the centroid of the enclosed volume [m], (3,)."""
        a, b, c = (self.points[self.triangles[:, i]] for i in range(3))
        volumes = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6
        center: Array = volumes @ (a + b + c) / 4 / volumes.sum()
        return center

    def centred(self) -> Mesh:
        """Return it moved so that the middle of its bounding box is the origin."""
        middle = (self.points.min(axis=0) + self.points.max(axis=0)) / 2
        return Mesh(self.points - middle, self.triangles)

    def scaled(self, factors: tuple[float, float, float] | float) -> Mesh:
        """Return it scaled by a factor, or by one along each axis."""
        return Mesh(self.points * np.asarray(factors), self.triangles)

    def clearance(self) -> float:
        """Return how deep the center of volume is under the nearest triangle [m]; <= 0 where it sees a back."""
        a, b, c = (self.points[self.triangles[:, i]] for i in range(3))
        normal = np.cross(b - a, c - a)
        length = np.linalg.norm(normal, axis=1)
        return float(np.min(np.einsum("ij,ij->i", normal, a - self.center_of_volume()) / length))


def read_mesh(path: Path, unit: float = 1.0) -> Mesh:
    """Read the surface of an object from an STL or OBJ file, check it, and centre it on its bounding box.

    Args:
        path: ends in ``.stl`` or ``.obj``.
        unit: length of one of the file's units [m].

    Raises:
        InvalidInput: naming the file and what is wrong with it.
    """
    where = str(path)
    try:
        with path.open("rb") as file:
            content = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise InvalidInput(where, error.strerror or str(error), "a readable STL or OBJ file") from None
    if len(content) > MAX_BYTES:
        raise InvalidInput(where, f"more than {MAX_BYTES} bytes", f"a mesh file of at most {MAX_BYTES}")
    suffix = path.suffix.lower()
    if suffix == ".stl":
        corners = _stl(where, content)
    elif suffix == ".obj":
        corners = _obj(where, content)
    else:
        raise InvalidInput(where, f"suffix {suffix!r}", ".stl or .obj")
    if not len(corners):
        raise InvalidInput(where, "no triangles", "a closed surface")
    if len(corners) > MAX_TRIANGLES:
        raise InvalidInput(where, f"{len(corners)} triangles", f"a mesh of at most {MAX_TRIANGLES}")
    if not np.all(np.isfinite(corners)) or np.abs(corners).max() > 1e12:
        raise InvalidInput(where, "points that are not finite", "finite numbers")
    if np.ptp(corners, axis=(0, 1)).min() <= 0:
        raise InvalidInput(where, "a surface without extent", "a body that encloses a volume")
    mesh = _welded(corners * unit)
    check_mesh(where, mesh)
    return mesh.centred()


def check_mesh(where: str, mesh: Mesh) -> None:
    """Refuse a mesh that no soft body can be made of.

    Raises:
        InvalidInput: if it is not closed, not oriented, inside out, in pieces, or not star-shaped.
    """
    t = mesh.triangles
    if not len(t) or np.any((t[:, 0] == t[:, 1]) | (t[:, 1] == t[:, 2]) | (t[:, 2] == t[:, 0])):
        raise InvalidInput(where, "triangles without area", "triangles of three different points")
    directed = np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]])
    undirected, uses = np.unique(np.sort(directed, axis=1), axis=0, return_counts=True)
    open_edges = int(np.sum(uses == 1))
    if open_edges:
        raise InvalidInput(where, f"{open_edges} open edges", "a closed mesh: every edge joins two triangles")
    if np.any(uses != 2):
        raise InvalidInput(
            where, f"{int(np.sum(uses != 2))} edges of more than two triangles", "every edge joins two triangles"
        )
    if len(np.unique(directed, axis=0)) != len(directed):
        raise InvalidInput(where, "triangles that turn against each other", "all triangles turned outward")
    if _pieces(len(mesh.points), undirected) > 1:
        raise InvalidInput(where, "several separate surfaces", "a mesh in one piece")
    if mesh.volume <= 0:
        raise InvalidInput(where, "triangles that turn inward", "all triangles turned outward")
    if mesh.clearance() <= 0:
        raise InvalidInput(
            where,
            "a surface with parts hidden from its middle",
            "a star-shaped body: every triangle faces away from the center of volume",
        )


def _pieces(count: int, edges: NDArray[np.int64]) -> int:
    """Return how many pieces the points that edges join form."""
    label = np.arange(count)
    while True:
        lowest = np.minimum(label[edges[:, 0]], label[edges[:, 1]])
        new = label.copy()
        np.minimum.at(new, edges[:, 0], lowest)
        np.minimum.at(new, edges[:, 1], lowest)
        new = new[new]
        if np.array_equal(new, label):
            return len(np.unique(label[np.unique(edges)]))
        label = new


def _welded(corners: Array) -> Mesh:
    """Return the mesh of triangles given by their corners, (M, 3, 3), with equal corners made one point."""
    flat = corners.reshape(-1, 3)
    low = flat.min(axis=0)
    step = WELD * float(np.linalg.norm(np.ptp(flat, axis=0)))
    _, first, which = np.unique(
        np.round((flat - low) / step).astype(np.int64), axis=0, return_index=True, return_inverse=True
    )
    return Mesh(flat[first], which.reshape(-1, 3))


def _stl(where: str, content: bytes) -> Array:
    """Return the corners of an STL file's triangles, (M, 3, 3)."""
    if len(content) >= _STL_HEADER:
        (count,) = struct.unpack("<I", content[80:_STL_HEADER])
        if len(content) == _STL_HEADER + _STL_RECORD * count:
            body = np.frombuffer(content, dtype=np.uint8, offset=_STL_HEADER).reshape(count, _STL_RECORD)
            return body[:, 12:48].copy().view("<f4").reshape(count, 3, 3).astype(np.float64)
    lines = _text(where, content, "an STL file, binary or ASCII").split("\n")
    rows = [line.split() for line in lines]
    if not rows or not rows[0] or rows[0][0] != "solid":
        raise InvalidInput(where, "neither binary nor ASCII STL", "an STL file")
    points = [_numbers(where, row[1:], 3) for row in rows if row and row[0] == "vertex"]
    if len(points) % 3:
        raise InvalidInput(where, f"{len(points)} vertices", "three for every triangle")
    return np.array(points, dtype=np.float64).reshape(-1, 3, 3)


def _obj(where: str, content: bytes) -> Array:
    """Return the corners of an OBJ file's faces, (M, 3, 3); faces of more corners are split from the first."""
    points: list[list[float]] = []
    faces: list[tuple[int, int, int]] = []
    for line in _text(where, content, "an OBJ file").split("\n"):
        words = line.split()
        if words and words[0] == "v":
            points.append(_numbers(where, words[1:4], 3))
        elif words and words[0] == "f":
            around = [_index(where, word, len(points)) for word in words[1:]]
            if len(around) < 3:
                raise InvalidInput(where, " ".join(words[:4]), "a face of at least three points")
            faces += [(around[0], b, c) for b, c in pairwise(around[1:])]
    if not faces:
        return np.zeros((0, 3, 3))
    if max(max(face) for face in faces) >= len(points):
        raise InvalidInput(where, f"a face with point {max(max(f) for f in faces) + 1}", f"1 to {len(points)}")
    corners: Array = np.array(points)[np.array(faces)]
    return corners


def _index(where: str, word: str, count: int) -> int:
    try:
        index = int(word.split("/")[0])
    except ValueError:
        raise InvalidInput(where, f"face corner {word!r}", "a point's number") from None
    if index == 0 or index < -count:
        raise InvalidInput(where, f"face corner {word!r}", "numbers from 1, or negative ones from the end")
    return index - 1 if index > 0 else count + index


def _numbers(where: str, words: list[str], count: int) -> list[float]:
    try:
        numbers = [float(word) for word in words]
    except ValueError:
        numbers = []
    if len(numbers) != count:
        raise InvalidInput(where, f"point {' '.join(words)[:60]!r}", f"{count} numbers")
    return numbers


def _text(where: str, content: bytes, valid: str) -> str:
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError:
        raise InvalidInput(where, "bytes that are not text", valid) from None
