"""The simulated world: its contact law against the published measurements, and that every corner of it runs."""

import mujoco
import numpy as np
import pytest

from dynamics.errors import InvalidInput
from dynamics.gripper import robotiq_2f85
from models.robot import gen3_mjcf
from sim.contact import OVERDAMPED, RUBBED, TIMESTEP, contact_law
from sim.scene import TABLE_SIZE, scene_mjcf
from tests.sim.objects import CORNERS, EDGE, block

GRID = [(young, mass) for young in (5e3, 1e4, 1e5, 1e6) for mass in (0.004, 0.02, 0.1, 0.3, 1.0)]
STIFFER = 300.0  # contact over object, for which elasticity was measured to come out right to 1 %
STRONGEST = 0.9999  # the largest impedance that MuJoCo allows
GRAVITY = 9.81


@pytest.mark.parametrize(("young", "mass"), GRID)
@pytest.mark.parametrize("size", [(EDGE,) * 3, (0.04, 0.06, 0.08), (0.03, 0.05, 0.12)])
@pytest.mark.parametrize("damping", [OVERDAMPED, RUBBED])
def test_contact_is_so_much_stiffer_than_the_object(young, mass, size, damping):
    truth = block(young, mass, size)
    law = contact_law(truth, damping_ratio=damping)
    assert law.damping_ratio == damping
    time, impedance = law.time_constant, law.impedance
    assert time >= 2 * TIMESTEP  # below it contacts are garbage
    assert 0.9 <= impedance <= STRONGEST
    contact = mass / (impedance * (1 - impedance) * (time * damping) ** 2)  # MuJoCo's, by its manual
    length, width, height = size
    own = young * max(width * height / length, length * height / width)  # the stiffer of the ways to grasp it
    # What the law misses is what is made up for on the object's weight in the contact solver, and it misses only
    # where the contact cannot be any stiffer.
    assert contact * law.shortfall == pytest.approx(STIFFER * own, rel=1e-9)
    if law.shortfall > 1 + 1e-9:
        assert (time, impedance) == (2 * TIMESTEP, STRONGEST)


def test_saturation_begins_where_it_was_measured():
    # R E L > m / (d (1 - d) (2 dt z)^2)
    assert contact_law(block(1e6, 0.004)).shortfall == pytest.approx(
        STIFFER * 1e6 * EDGE * (2 * TIMESTEP * OVERDAMPED) ** 2 * STRONGEST * (1 - STRONGEST) / 0.004, rel=1e-3
    )
    for young, mass in ((1e6, 0.3), (1e5, 0.03), (5e3, 0.004), (1e6, 1.0)):
        assert contact_law(block(young, mass)).shortfall == pytest.approx(1.0)


def stood(truth, seconds=0.3, fidelity="uniform"):
    """Return model and data after the object has stood on the table for a while; a warning fails the test."""
    model = mujoco.MjModel.from_xml_string(scene_mjcf(truth, robotiq_2f85(), fidelity=fidelity))
    data = mujoco.MjData(model)
    for _ in range(round(seconds / TIMESTEP)):
        mujoco.mj_step(model, data)
    assert not any(warning.number for warning in data.warning)
    assert data.time == pytest.approx(seconds)  # MuJoCo resets itself when it diverges
    return model, data


def corners(model, data):
    """Return the vertices of the soft object [m], (N, 3)."""
    return data.flexvert_xpos.reshape(-1, 3)


def mass_of_object(model):
    return model.body_mass[np.unique(model.flex_nodebodyid)].sum()


@pytest.mark.parametrize(("young", "mass"), CORNERS)
@pytest.mark.parametrize(
    ("size", "yaw"), [((EDGE,) * 3, 0.0), ((0.04, 0.06, 0.08), 0.7), ((0.12, 0.03, 0.03), -2.5)]
)
def test_every_corner_compiles_and_stands(young, mass, size, yaw):
    truth = block(young, mass, size, yaw, position=(0.5, 0.1))
    model, data = stood(truth)
    assert mass_of_object(model) == pytest.approx(mass, rel=1e-9)
    points = corners(model, data)
    # It sags under its weight: the top by rho g h^2 / (2 E), and its base bulges no more than that (nu = 0); the
    # contact gives way by 1/300 of what the weight would do to the object; it hovers on a skin of 0.1 mm.
    sag = mass * GRAVITY * size[2] / (2 * young * size[0] * size[1])
    slack = 3e-4 + 0.02 * sag
    assert -slack < points[:, 2].min() < slack
    # Large strains are beyond the linear formula, and only bounded here.
    lowest = size[2] - (sag + slack if sag < 0.05 * size[2] else 4 * sag)
    assert lowest - slack < points[:, 2].max() < size[2] + slack
    assert points[:, :2].mean(axis=0) == pytest.approx([0.5, 0.1], abs=2e-3)


@pytest.mark.parametrize(
    ("size", "yaw"), [((EDGE,) * 3, 0.0), ((0.04, 0.06, 0.08), 0.7), ((0.12, 0.03, 0.03), -2.5)]
)
def test_size_place_and_turn_are_the_true_ones(size, yaw):
    truth = block(5e5, 0.1, size, yaw, position=(0.5, -0.1))
    model = mujoco.MjModel.from_xml_string(scene_mjcf(truth, robotiq_2f85()))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    pose = truth.declared.pose()
    own = (corners(model, data) - pose[:3, 3]) @ pose[:3, :3]
    # Vertices carry a skin of 0.1 mm, so the outer faces are those of the object; it starts 0.1 mm too high.
    np.testing.assert_allclose(np.ptp(own, axis=0) + 2e-4, size, atol=1e-9)
    np.testing.assert_allclose(own.mean(axis=0), [0, 0, 1e-4], atol=1e-9)


@pytest.mark.parametrize("fidelity", ["uniform", "indentation"])
@pytest.mark.parametrize("revision", ["V12", "BRAKES"])
def test_the_robot_in_the_scene_is_the_described_one(fidelity, revision):
    truth = block(5e4, 0.1)
    model = mujoco.MjModel.from_xml_string(scene_mjcf(truth, robotiq_2f85(), revision, fidelity=fidelity))
    alone = mujoco.MjModel.from_xml_string(gen3_mjcf(revision))
    for number in range(1, alone.nbody):
        body = model.body(alone.body(number).name)
        for field in ("mass", "inertia", "ipos", "iquat", "pos", "quat"):
            np.testing.assert_array_equal(getattr(body, field), getattr(alone.body(number), field))
    assert mass_of_object(model) == pytest.approx(0.1, rel=1e-9)


def test_indentation_stands_too():
    stood(block(5e4, 0.1), fidelity="indentation")


def test_friction_is_the_true_one():
    model = mujoco.MjModel.from_xml_string(scene_mjcf(block(friction=0.37), robotiq_2f85()))
    assert model.flex_friction[0][0] == pytest.approx(0.37)
    for pad in ("left_pad", "right_pad"):
        assert model.geom(pad).friction[0] == pytest.approx(0.37)


def test_table_top_is_the_plane_the_object_stands_on():
    model = mujoco.MjModel.from_xml_string(scene_mjcf(block(), robotiq_2f85()))
    table = model.geom("table")
    assert table.pos[2] + table.size[2] == pytest.approx(0.0)
    np.testing.assert_allclose(2 * table.size, TABLE_SIZE)


@pytest.mark.parametrize("position", [(-0.28, 0.0), (0.88, 0.0), (0.3, 0.78), (0.3, -0.78)])
def test_what_would_not_stand_on_the_table_is_refused(position):
    with pytest.raises(InvalidInput, match=r"position_m.*on the table"):
        scene_mjcf(block(position=position), robotiq_2f85())
