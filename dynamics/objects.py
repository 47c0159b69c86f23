"""What the user declares as known of an object before it is handled: its shape, its size and where it stands.

An object file has a table ``[declared]``, read here, and may have a table ``[truth]``, which only the simulator
and the final comparison read.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from dynamics.collision import Box
from dynamics.errors import InvalidInput
from dynamics.tables import Table, read_toml

Shape = Literal["box"]
SHAPES: tuple[Shape, ...] = ("box",)

LONGEST_NAME = 80


@dataclass(frozen=True)
class DeclaredObject:
    """What is known of an object beforehand.

    Attributes:
        name: what it is called.
        shape: ``box``.
        size: edge lengths along its own x, y and z [m].
        size_sd: standard deviation of each edge length [m].
        position: where its base stands on the table: x and y in the arm's base frame [m].
        yaw: how far it is turned about the vertical [rad].
        source: the file that says so, for messages.
    """

    name: str
    shape: Shape
    size: tuple[float, float, float]
    size_sd: float
    position: tuple[float, float]
    yaw: float
    source: str = "declared object"

    @property
    def volume(self) -> float:
        """Volume of the declared shape [m^3]."""
        return math.prod(self.size)

    @property
    def volume_sd(self) -> float:
        """Standard deviation of the volume, its edges independent [m^3]."""
        relative = sum((self.size_sd / edge) ** 2 for edge in self.size)
        return self.volume * math.sqrt(relative)

    def pose(self) -> NDArray[np.float64]:
        """Return the pose of its centre in the base, standing on the table, (4, 4)."""
        pose = np.eye(4)
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        pose[:2, :2] = [[c, -s], [s, c]]
        pose[:3, 3] = [*self.position, self.size[2] / 2]
        return pose

    def box(self) -> Box:
        """Return the box that it fills, for collision checks."""
        return Box("object", self.size, self.pose())


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
    declared = DeclaredObject(
        name=_name(table, path.stem),
        shape=_shape(table.text("shape", "box", SHAPES)),
        size=_three(table.numbers("size_m", 3, at_least=0.02, at_most=0.3, unit="m")),
        size_sd=table.number("size_sd_m", 0.0005, above=0.0, at_most=0.02, unit="m"),
        position=_two(table.numbers("position_m", 2, (0.5, 0.0), at_least=-0.9, at_most=0.9, unit="m")),
        yaw=math.radians(table.number("yaw_deg", 0.0, at_least=-180, at_most=180, unit="deg")),
        source=str(path),
    )
    table.done()
    return declared


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
