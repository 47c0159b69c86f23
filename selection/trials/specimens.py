"""The objects of the simulated experiments: soft bodies, listed and novel, and the thesis' A and B."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from estimation.network import LINEAR, MATERIAL, Network, Property, Unknown
from estimation.sensor import Sensor
from models import objects

EDGE = 0.056
"""Edge of the cubes [m], as in the thesis."""
LISTED = (
    "yellow-sponge",
    "foam-block",
    "eva-block",
    "white-cube",
    "black-cube",
    "soft-cube",
    "hard",
    "soft",
    "medium",
    "rubber-cube",
    "heavy-cube",
    "foam-cylinder",
    "rubber-ball",
    "sponge-ellipsoid",
)
"""Shipped objects of every material of the reference ``soft-cubes``, most of them cubes."""
UNLISTED = ("steel-block", "clay-cube")
"""Shipped objects of no material of it."""
REFERENCE = "soft-cubes"


@dataclass(frozen=True)
class Specimen:
    """A soft cube.

    Attributes:
        name: such as ``white-cube``.
        text: its object file.
        novel: whether the reference does not list its material.
    """

    name: str
    text: str
    novel: bool = False


@contextmanager
def on_disk(specimen: Specimen) -> Iterator[Path]:
    """Yield the path of the object file, which is there for as long."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{specimen.name}.toml"
        path.write_text(specimen.text, encoding="utf-8")
        yield path


def cube(name: str, material: str, mass: float, modulus: float, novel: bool = False) -> Specimen:
    """Return a soft cube of 56 mm.

    Args:
        name: of the object.
        material: true class.
        mass: [kg].
        modulus: Young's modulus [Pa].
        novel: whether the reference does not list it.
    """
    edges = ", ".join([str(EDGE)] * 3)
    text = (
        f'[declared]\nshape = "box"\nsize_m = [{edges}]\nsize_sd_m = 0.0005\n'
        "position_m = [0.5, 0.0]\nyaw_deg = 0.0\n\n"
        f'[truth]\nmaterial = "{material}"\nmass_kg = {mass}\nyoung_modulus_pa = {modulus}\nfriction = 0.8\n'
    )
    return Specimen(name, text, novel)


def listed() -> tuple[Specimen, ...]:
    """Return shipped objects of every material of the reference."""
    return tuple(_shipped(name) for name in LISTED)


def novel() -> tuple[Specimen, ...]:
    """Return objects of no material of the reference: combinations that none has, and two shipped ones."""
    return (*NOVEL, *(_shipped(name, novel=True) for name in UNLISTED))


def _shipped(name: str, novel: bool = False) -> Specimen:
    return Specimen(name, objects.locate(name).read_text(encoding="utf-8"), novel)


NOVEL = (
    cube("novel-dense-soft", "unknown", 0.350, 60e3, novel=True),
    cube("novel-light-stiff", "unknown", 0.090, 500e3, novel=True),
    cube("novel-airy", "unknown", 0.004, 60e3, novel=True),
    cube("novel-dense", "unknown", 0.450, 200e3, novel=True),
    cube("novel-foam", "unknown", 0.040, 120e3, novel=True),
)
"""Combinations of density and elasticity that no listed material has."""

A, B = cube("material-a", "material-a", 0.079, 30e3), cube("material-b", "material-b", 0.132, 36e3)
"""Ambiguous in elasticity, distinguishable in density (thesis Fig. 4.2, which prints no numbers)."""


def reference_ab() -> Network:
    """Return the reference of materials A and B: densities five sds apart, elasticities three quarters of one."""
    names = ("material-a", "material-b")
    return Network(
        "materials-ab",
        names,
        (
            Property("density", MATERIAL, "kg/m^3", LINEAR, (450.0, 750.0), (60.0, 60.0)),
            Property("elasticity", MATERIAL, "Pa", LINEAR, (30e3, 36e3), (8e3, 8e3)),
        ),
        (0.5, 0.5),
        unknown=Unknown(0.05),
        sensors=(("weigh", Sensor("density", 20.0)), ("squeeze", Sensor("elasticity", 3e3))),
    )
