"""What the user declares as known of an object before it is handled: its shape, its size and where it stands.

An object file has a table ``[declared]``, read here, and may have a table ``[truth]``, which only the simulator
and the final comparison read.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from dynamics.collision import Box
from dynamics.errors import InvalidInput
from dynamics.mesh import Mesh, read_mesh
from dynamics.shapes import FILL, SHAPES, Lengths, Shape, relative_volume_sd
from dynamics.tables import Table, read_toml

LONGEST_NAME = 80
SMALLEST, LARGEST = 0.02, 0.3  # m
_MESH_SUFFIXES = (".stl", ".obj")


@dataclass(frozen=True)
class DeclaredObject:
    """What is known of an object beforehand.

    Attributes:
        name: what it is called.
        shape: ``box``, ``cylinder`` (standing), ``sphere``, ``ellipsoid`` or ``mesh``.
        size: lengths of its bounding box along its own x, y and z, z upward [m].
        size_sd: standard deviation of each length [m].
        position: where its base stands on the table: x and y in the arm's base frame [m].
        yaw: how far it is turned about the vertical [rad].
        source: the file that says so, for messages.
        mesh: the surface of a ``mesh``, centred on its bounding box, of this size.
    """

    name: str
    shape: Shape
    size: tuple[float, float, float]
    size_sd: float
    position: tuple[float, float]
    yaw: float
    source: str = "declared object"
    mesh: Mesh | None = field(default=None, compare=False, repr=False)

    @property
    def fill(self) -> float:
        """Share of the bounding box that it fills [-]."""
        return FILL[self.shape] if self.mesh is None else self.mesh.fill

    @property
    def volume(self) -> float:
        """Volume of the declared shape [m^3]."""
        return self.fill * math.prod(self.size)

    @property
    def volume_sd(self) -> float:
        """Standard deviation of the volume, lengths that are not one independent [m^3]."""
        return self.volume * relative_volume_sd(self.shape, self.size, (self.size_sd,) * 3)

    def pose(self) -> NDArray[np.float64]:
        """Return the pose of its centre in the base, standing on the table, (4, 4)."""
        pose = np.eye(4)
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        pose[:2, :2] = [[c, -s], [s, c]]
        pose[:3, 3] = [*self.position, self.size[2] / 2]
        return pose

    def box(self) -> Box:
        """Return its bounding box, or the round body in it, for collision checks."""
        bodies: dict[Shape, Literal["cylinder", "ellipsoid"]] = {
            "cylinder": "cylinder",
            "sphere": "ellipsoid",
            "ellipsoid": "ellipsoid",
        }
        return Box("object", self.size, self.pose(), bodies.get(self.shape, "box"))


def read_declared(path: Path) -> DeclaredObject:
    """Read the declared part of an object file.

    Raises:
        InvalidInput: for a file that is missing or malformed, naming key, value and what is valid.
    """
    file = Table(str(path), read_toml(path))
    file.text("about", "")
    file.has("truth")
    table = file.table("declared")
    file.done()
    shape = _shape(table.text("shape", "box", SHAPES))
    mesh = _read_surface(table, path) if shape == "mesh" else None
    declared = DeclaredObject(
        name=_name(table, path.stem),
        shape=shape,
        size=read_size(table, shape) if mesh is None else mesh.extents,
        size_sd=table.number("size_sd_m", 0.0005, above=0.0, at_most=0.02, unit="m"),
        position=_two(table.numbers("position_m", 2, (0.5, 0.0), at_least=-0.9, at_most=0.9, unit="m")),
        yaw=math.radians(table.number("yaw_deg", 0.0, at_least=-180, at_most=180, unit="deg")),
        source=str(path),
        mesh=mesh,
    )
    table.done()
    return declared


def read_size(table: Table, shape: Shape, known: Lengths | None = None) -> Lengths:
    """Return the lengths of a shape's bounding box from the keys that describe the shape [m].

    ``size_m`` of a box or an ellipsoid (its full axes), ``diameter_m`` and ``height_m`` of a cylinder,
    ``diameter_m`` of a sphere, and the factor ``scale`` by which a mesh differs from the known one.

    Args:
        table: the file's table.
        shape: what is described.
        known: what holds for keys that are not there; a missing key is an error without it, and a mesh needs it.
    """
    if shape == "mesh":
        assert known is not None
        scale = table.number("scale", 1.0, at_least=0.5, at_most=2.0)
        return scale * known[0], scale * known[1], scale * known[2]
    if shape in ("box", "ellipsoid"):
        return _three(table.numbers("size_m", 3, known, at_least=SMALLEST, at_most=LARGEST, unit="m"))
    width, height = (None, None) if known is None else (known[0], known[2])
    diameter = table.number("diameter_m", width, at_least=SMALLEST, at_most=LARGEST, unit="m")
    if shape == "sphere":
        return diameter, diameter, diameter
    return diameter, diameter, table.number("height_m", height, at_least=SMALLEST, at_most=LARGEST, unit="m")


def _read_surface(table: Table, path: Path) -> Mesh:
    """Return the mesh that an object file names, relative to itself.

    Raises:
        InvalidInput: for a mesh that cannot be used, or whose size in metres cannot be meant.
    """
    name = table.text("mesh")
    unit = table.number("mesh_unit_m", 1.0, at_least=1e-6, at_most=1.0, unit="m")
    if not name.lower().endswith(_MESH_SUFFIXES) or not name.isprintable():
        raise InvalidInput(f"{table.where}: mesh", name, f"the path of a file {' or '.join(_MESH_SUFFIXES)}")
    mesh = read_mesh(path.parent / name, unit)
    if not all(SMALLEST <= extent <= LARGEST for extent in mesh.extents):
        raise InvalidInput(
            f"{table.where}: mesh",
            f"{name} of {' x '.join(f'{extent:.4g}' for extent in mesh.extents)} m",
            f"lengths of {SMALLEST} to {LARGEST} m; mesh_unit_m says what one of the file's units is",
        )
    return mesh


def _name(table: Table, default: str) -> str:
    """Return the object's name, which also names folders."""
    name = table.text("name", default)
    if not name.isprintable() or not name.strip(". ") or "/" in name or "\\" in name or len(name) > LONGEST_NAME:
        valid = f"a name of 1 to {LONGEST_NAME} printable characters without slashes"
        raise InvalidInput(f"{table.where}: name", name, valid)
    return name


def _shape(name: str) -> Shape:
    return next(shape for shape in SHAPES if shape == name)


def _three(values: tuple[float, ...]) -> tuple[float, float, float]:
    a, b, c = values
    return a, b, c


def _two(values: tuple[float, ...]) -> tuple[float, float]:
    a, b = values
    return a, b
