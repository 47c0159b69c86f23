"""Sizes known length by length: lengths that are one are learned together, and the volume follows."""

import math

import numpy as np
import pytest

from dynamics.objects import read_declared
from estimation.measurement import Measurement
from estimation.reestimation import mesh_of, write_mesh
from estimation.size import SizeEstimate
from models import objects
from tests.sim.objects import thing


def test_a_measured_diameter_is_that_of_the_whole_ball():
    size = SizeEstimate.declared(thing("sphere").declared).with_edge(1, Measurement("width", 0.061, 0.0005, "m"))
    np.testing.assert_allclose(size.mean, (0.0605,) * 3)
    np.testing.assert_allclose(size.sd, (0.0005 / math.sqrt(2),) * 3)
    volume = size.volume()
    assert volume.mean == pytest.approx(math.pi / 6 * 0.0605**3)
    assert volume.sd / volume.mean == pytest.approx(3 * size.sd[0] / 0.0605)


def test_a_cylinders_height_stays_as_declared():
    size = SizeEstimate.declared(thing("cylinder").declared).with_edge(0, Measurement("width", 0.059, 0.001, "m"))
    assert size.mean[0] == size.mean[1] == pytest.approx((0.06 * 4 + 0.059) / 5)
    assert (size.mean[2], size.sd[2]) == (0.08, 0.0005)


def test_a_mesh_is_scaled_as_a_whole():
    before = SizeEstimate.declared(thing("mesh").declared)
    assert before.volume().sd == pytest.approx(thing("mesh").declared.volume_sd)
    after = before.with_edge(1, Measurement("width", 0.056 * 1.01, 1e-6, "m"))
    np.testing.assert_allclose(np.array(after.mean) / before.mean, 1.01, rtol=1e-4)
    assert after.volume().mean == pytest.approx(before.volume().mean * 1.01**3, rel=1e-4)
    assert after.volume().sd < before.volume().sd / 10


def test_edges_of_a_block_are_their_own():
    size = SizeEstimate.declared(thing("box").declared).with_edge(1, Measurement("width", 0.07, 1e-6, "m"))
    np.testing.assert_allclose(size.mean, (0.05, 0.07, 0.07), rtol=1e-4)


def test_a_mesh_kept_with_a_run_is_found_again(tmp_path):
    source = objects.locate("soap-bar")
    kept = mesh_of(source)["object_mesh"]
    copy = tmp_path / "object.toml"
    copy.write_text(source.read_text())
    write_mesh(tmp_path, kept)
    assert read_declared(copy).volume == read_declared(source).volume
    assert mesh_of(objects.locate("soft-cube")) == {}


@pytest.mark.parametrize("name", ["../out.stl", "/tmp/out.stl", "", "."])
def test_a_kept_mesh_is_written_nowhere_else(tmp_path, name):
    folder = tmp_path / "inner"
    folder.mkdir()
    write_mesh(folder, {"name": name, "content": "AAAA"})
    assert not (tmp_path / "out.stl").exists()
    assert not list(folder.iterdir())


@pytest.mark.parametrize("mesh", [{}, {"name": 3, "content": "AAAA"}, {"name": "a.stl", "content": "!"}])
def test_a_damaged_kept_mesh_is_left_out(tmp_path, mesh):
    write_mesh(tmp_path, mesh)
    assert not list(tmp_path.iterdir())
