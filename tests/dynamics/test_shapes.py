"""Declared shapes: volume and its spread by Monte Carlo, place, and what an object file may say."""

import math

import numpy as np
import pytest

from dynamics.errors import InvalidInput
from dynamics.objects import DeclaredObject, read_declared
from dynamics.shapes import SHAPES, tied_to
from models.rounded_block import main
from tests.sim.objects import SIZES, thing

SD = 0.001
KEYS = {
    "box": "size_m = [0.05, 0.06, 0.07]",
    "cylinder": "diameter_m = 0.06\nheight_m = 0.08",
    "sphere": "diameter_m = 0.06",
    "ellipsoid": "size_m = [0.08, 0.06, 0.05]",
    "mesh": "mesh = 'block.stl'\nmesh_unit_m = 0.001",
}


def write(folder, shape, keys, extra=""):
    if shape == "mesh":
        main([str(folder / "block.stl"), "--edges", "80", "56", "36", "--steps", "4"])
    path = folder / "thing.toml"
    path.write_text(f"[declared]\nshape = '{shape}'\n{keys}\n{extra}\n")
    return path


@pytest.mark.parametrize("shape", SHAPES)
def test_file_of_every_shape(tmp_path, shape):
    declared = read_declared(write(tmp_path, shape, KEYS[shape]))
    assert declared.shape == shape
    np.testing.assert_allclose(declared.size, SIZES[shape], rtol=1e-6)
    exact = {
        "box": 0.05 * 0.06 * 0.07,
        "cylinder": math.pi * 0.03**2 * 0.08,
        "sphere": 4 / 3 * math.pi * 0.03**3,
        "ellipsoid": 4 / 3 * math.pi * 0.04 * 0.03 * 0.025,
    }
    if shape == "mesh":
        assert declared.mesh is not None
        assert declared.volume == pytest.approx(declared.mesh.volume)
    else:
        assert declared.volume == pytest.approx(exact[shape])
    assert declared.pose()[2, 3] == pytest.approx(declared.size[2] / 2)
    box = declared.box()
    assert box.size == declared.size


@pytest.mark.parametrize("shape", SHAPES)
def test_spread_of_the_volume(shape):
    """Monte Carlo over the lengths that are free; its sd is known to 1/sqrt(2 n) = 0.3 %; second order 4e-4."""
    declared = thing(shape).declared
    declared = DeclaredObject(shape, shape, declared.size, SD, (0.5, 0), 0, mesh=declared.mesh)
    rng = np.random.default_rng(1)
    lengths = np.tile(declared.size, (50_000, 1))
    for axis in range(3):
        group = tied_to(shape, axis)
        longest = max(group, key=lambda a: declared.size[a])
        if axis == group[0]:
            factor = 1 + SD / declared.size[longest] * rng.standard_normal(len(lengths))
            lengths[:, list(group)] *= factor[:, None]
    found = (declared.fill * lengths.prod(axis=1)).std()
    assert declared.volume_sd == pytest.approx(found, rel=4 * 0.0032 + 2e-3)


@pytest.mark.parametrize(
    ("shape", "keys", "valid"),
    [
        ("cylinder", "diameter_m = 0.06", "no height_m"),
        ("cylinder", "size_m = [0.05, 0.05, 0.05]", "diameter_m"),
        ("cylinder", "diameter_m = 6\nheight_m = 8", "<= 0.3"),
        ("sphere", "diameter_m = 0.06\nheight_m = 0.06", "unknown key height_m"),
        ("sphere", "diameter_m = nan", ">= 0.02"),
        ("box", "diameter_m = 0.06", "no size_m"),
        ("ellipsoid", "size_m = [0.05, 0.05]", "3 numbers"),
        ("mesh", "", "no mesh"),
        ("mesh", "mesh = 3", "a text"),
        ("mesh", "mesh = 'block.ply'", ".stl or .obj"),
        ("mesh", "mesh = 'missing.stl'", "missing.stl"),
        ("mesh", "mesh = 'block.stl'", "mesh_unit_m"),  # 80 m
        ("mesh", "mesh = 'block.stl'\nmesh_unit_m = 0.0", ">= 1e-06"),
        ("mesh", "mesh = 'block.stl'\nmesh_unit_m = 0.001\nsize_m = [0.05, 0.05, 0.05]", "unknown key size_m"),
    ],
)
def test_mistakes_are_told_with_the_file(tmp_path, shape, keys, valid):
    path = write(tmp_path, shape, keys)
    with pytest.raises(InvalidInput) as refusal:
        read_declared(path)
    assert valid in str(refusal.value)
    assert str(tmp_path) in str(refusal.value)
    assert len(str(refusal.value).splitlines()) == 1
