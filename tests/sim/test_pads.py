"""Pads with bevelled edges: the shape that they are, and for whom."""

import mujoco
import numpy as np
import pytest

from dynamics.gripper import robotiq_2f85
from sim.contact import OVERDAMPED, RUBBED
from sim.pads import DEPTH, LENGTH, MESH
from sim.scene import scene_mjcf
from tests.sim.objects import thing


def scene(truth, fidelity="uniform"):
    return mujoco.MjModel.from_xml_string(scene_mjcf(truth, robotiq_2f85(), fidelity=fidelity))


def corners(model, name):
    """Return the corners of a pad about the middle that its body knows, in axes of the body [m], (N, 3)."""
    geom = model.geom(name)
    mesh = model.mesh(MESH)
    vertices = model.mesh_vert[mesh.vertadr[0] : mesh.vertadr[0] + mesh.vertnum[0]]
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, geom.quat)
    return vertices @ turn.reshape(3, 3).T


def test_bevelled_pad_is_the_box_but_for_its_upper_and_lower_edges():
    model, boxes = scene(thing("box", 5e4)), scene(thing("sphere", 5e4))
    for name in ("left_pad", "right_pad"):
        box = boxes.geom(name)
        assert box.type == mujoco.mjtGeom.mjGEOM_BOX
        np.testing.assert_allclose(model.geom(name).pos, box.pos, atol=1e-9)
        points = corners(model, name)
        x, y, z = (np.abs(points[:, axis]) for axis in range(3))
        np.testing.assert_allclose((x.max(), y.max(), z.max()), box.size, rtol=1e-5)
        ends = z > box.size[2] - 1e-6
        assert ends.sum() == len(points) / 2
        np.testing.assert_allclose(y[ends], box.size[1] - DEPTH, rtol=1e-4)
        np.testing.assert_allclose(z[~ends], box.size[2] - LENGTH, rtol=1e-4)
    assert model.body("left_pad").mass == boxes.body("left_pad").mass


@pytest.mark.parametrize(
    ("shape", "young", "rubbed"), [("box", 1e6, True), ("box", 2e9, False), ("mesh", 5e4, False)]
)
def test_soft_boxes_alone_are_rubbed(shape, young, rubbed):
    model = scene(thing(shape, young))
    assert (model.geom("left_pad").type == mujoco.mjtGeom.mjGEOM_MESH) == rubbed
    damping = model.flex_solref[0, 1] if model.nflex else model.geom("object").solref[1]
    assert damping == (RUBBED if rubbed else OVERDAMPED)


def test_pads_that_sink_in_are_boxes():
    model = scene(thing("box", 5e4), "indentation")
    assert model.geom("left_pad").type == mujoco.mjtGeom.mjGEOM_BOX
    assert model.flex_solref[0, 1] == RUBBED
