"""Simulated objects of every shape: they stand, weigh and give way as what they are, and no warning is raised."""

import math

import mujoco
import numpy as np
import pytest

from dynamics.bench import Stroke
from dynamics.gripper import robotiq_2f85
from dynamics.shapes import SHAPES
from sim.bench import Bench
from sim.bodies import FIDELITIES, object_bodies, object_pose, prepare, surface
from sim.contact import TIMESTEP
from sim.scene import scene_mjcf
from tests.sim.objects import CORNERS, SIZES, thing

GRAVITY = 9.81


def stood(truth, seconds=0.3, fidelity="uniform"):
    """Return model and data after the object has stood on the table for a while; a warning fails the test."""
    model = mujoco.MjModel.from_xml_string(scene_mjcf(truth, robotiq_2f85(), fidelity=fidelity))
    prepare(model, truth)
    data = mujoco.MjData(model)
    for _ in range(round(seconds / TIMESTEP)):
        mujoco.mj_step(model, data)
    assert not any(warning.number for warning in data.warning)
    assert data.time == pytest.approx(seconds)  # MuJoCo resets itself when it diverges
    return model, data


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize(("young", "mass"), CORNERS)
def test_every_corner_stands_where_it_was_put(shape, young, mass):
    truth = thing(shape, young, mass, yaw=0.7, position=(0.5, 0.1), poisson=0.45)
    model, data = stood(truth, fidelity="indentation" if mass > 0.1 else "uniform")
    assert model.body_mass[object_bodies(model)].sum() == pytest.approx(mass, rel=1e-9)
    x, y, z = object_pose(model, data)
    # A body sags by what its weight over its mean section would compress it, a few times over for round ones and
    # large strains; 5 kPa and 1 kg lie flat.
    sag = mass * GRAVITY * truth.size[2] / (young * truth.volume / truth.size[2])
    assert (x, y) == pytest.approx((0.5, 0.1), abs=2e-3 + sag / 2)
    height = truth.size[2] / 2
    assert height - 3 * sag - 3e-4 < z < height + 3e-4
    assert z > 0


@pytest.mark.parametrize("fidelity", FIDELITIES)
@pytest.mark.parametrize("shape", SHAPES)
def test_surface_is_the_shape(shape, fidelity):
    truth = thing(shape)
    mesh = surface(truth, fidelity)
    np.testing.assert_allclose(mesh.extents, SIZES[shape], rtol=1e-12)
    # Points on the surface, flat triangles between: a little inside, (2 pi / 24)^2 / 6 = 1 % each way.
    assert 0.96 * truth.volume < mesh.volume <= truth.volume * (1 + 1e-9)
    if shape in ("sphere", "ellipsoid"):
        out = np.linalg.norm(2 * mesh.points / SIZES[shape], axis=1) - 1
        if fidelity == "uniform":  # the rims of flats stand out: by 1 - cos of the 2 pi / 24 to the next points
            assert out.min() > -1e-12
            assert out.max() < 0.035
        else:
            foot = np.abs(mesh.points[:, 2]) > SIZES[shape][2] / 2 * (1 - 1e-9)
            np.testing.assert_allclose(out[~foot], 0.0, atol=1e-12)
            np.testing.assert_allclose(out[foot], 0.0, atol=1e-3)
    for axis in range(3):  # the ends of the axes, where pads and table meet it, are points of it
        reach = mesh.points[np.argmax(mesh.points[:, axis])]
        assert reach[axis] == pytest.approx(SIZES[shape][axis] / 2)


@pytest.mark.parametrize(("shape", "turns"), [("sphere", range(8)), ("ellipsoid", range(0, 8, 2))])
def test_round_bodies_of_one_cell_are_flat_where_pads_and_table_touch_them(shape, turns):
    points = surface(thing(shape)).points / SIZES[shape]
    sides = [(math.cos(turn * math.pi / 4), math.sin(turn * math.pi / 4), 0.0) for turn in turns]
    for towards in (*sides, (0.0, 0.0, -1.0)):
        touched = points[points @ towards > 0.5 - 1e-9]
        # A patch, not a point or a line: a quarter of the radius from its middle both ways.
        spread = np.linalg.svd(touched - touched.mean(axis=0), compute_uv=False)
        assert np.linalg.norm(touched - np.array(towards) / 2, axis=1).max() == pytest.approx(0.129, abs=0.001)
        assert spread[1] > 0.1


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize(("young", "mass"), [(5e3, 0.004), (5e4, 0.2), (1e6, 0.004), (1e6, 1.0)])
def test_evenly_strained_body_has_its_youngs_modulus(shape, young, mass):
    """F = E (V / L) e, less 0.7 % for two contacts, 0.4 % for the skin, 1 % for contact of the stiff and light."""
    truth = thing(shape, young, mass, poisson=0.3)
    slope = Bench(truth, edge=1).press(Stroke(0.02, 0.9 * truth.size[1])).stiffness(0.02, 0.09)
    assert slope * truth.size[1] ** 2 / truth.volume == pytest.approx(young, rel=0.03)


@pytest.mark.parametrize("size", [(0.08, 0.04, 0.05), (0.03, 0.03, 0.12), (0.3, 0.05, 0.04), (0.02, 0.02, 0.02)])
def test_long_and_small_boxes_are_held_whole_by_the_pads(size):
    slope = Bench(thing("box", size=size), edge=1).press(Stroke(0.02, 0.9 * size[1])).stiffness(0.02, 0.09)
    assert slope * size[1] / (5e4 * size[0] * size[2]) == pytest.approx(1.0, rel=0.03)


def test_plastic_body_does_not_spring_back():
    """Pressed to 10 % it keeps what exceeds the yield strain; an elastic one pushes until it is let go."""
    for yield_strain, kept in ((0.0, 0.0), (0.03, 0.05)):
        bench = Bench(thing("box", yield_strain=yield_strain), edge=1)
        pressed = bench.press(Stroke(0.02, 0.9 * bench.width))
        strain, force = 1 - pressed.opening / bench.width, pressed.force
        back = np.arange(len(strain)) >= pressed.rows("release").start
        left = strain[back & (force > 0.02 * force.max())].min()
        assert left == pytest.approx(kept, abs=0.025)
        # Yield at e_y (von Mises, of the deviator 2/3 e of a body that does not bulge): the force stays below.
        if yield_strain:
            assert force.max() < 0.75 * 5e4 * 0.05 * 0.07 * strain.max()


@pytest.mark.parametrize("shape", SHAPES)
def test_a_body_stiffer_than_soft_ones_is_rigid(shape):
    truth = thing(shape, 2e11, 0.5, position=(0.5, 0.0))
    model, data = stood(truth, 0.5)
    assert model.nflex == 0
    assert model.body("object").mass[0] == pytest.approx(0.5)
    x, y, z = object_pose(model, data)
    assert (x, y) == pytest.approx((0.5, 0.0), abs=1e-3)
    assert z == pytest.approx(truth.size[2] / 2, abs=2e-4)
    assert np.abs(data.qvel[-6:]).max() < 1e-2


@pytest.mark.parametrize("fidelity", FIDELITIES)
@pytest.mark.parametrize("yaw", [0.0, 0.7, -2.1])
def test_cells_lie_along_the_body_however_it_is_turned(fidelity, yaw):
    """Cells along the world's axes would be larger around a turned body, partly empty, and stiffer."""
    truth = thing("box", yaw=yaw, position=(0.5, 0.1))
    model = mujoco.MjModel.from_xml_string(scene_mjcf(truth, robotiq_2f85(), fidelity=fidelity))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    nodes = data.xpos[object_bodies(model)] - (0.5, 0.1, truth.size[2] / 2)
    along = nodes[:, :2] @ np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
    np.testing.assert_allclose(np.ptp(along, axis=0), truth.size[:2], rtol=0.01)
