"""The gripper's closed forms against the description that MuJoCo moves."""

import math

import mujoco
import numpy as np
import pytest

from dynamics.errors import InvalidInput
from dynamics.gripper import robotiq_2f85
from models.robot import gen3_mjcf

OPENINGS = np.linspace(0.0, 0.085, 18)
STATED = 1e-9  # m: the description states the length of a crank to 1e-10 m


@pytest.fixture(scope="module")
def gripper():
    return robotiq_2f85()


def pads(opening, gripper):
    """Return the pads' centres and inner faces in the gripper's base, by MuJoCo [m], (2, 3) and (2,)."""
    model = mujoco.MjModel.from_xml_string(gen3_mjcf())
    data = mujoco.MjData(model)
    turned = gripper.crank_angle(gripper.max_opening) - gripper.crank_angle(opening)
    for side in ("left", "right"):
        for joint in ("crank", "pad"):
            data.qpos[model.joint(f"{side}_{joint}_joint").qposadr[0]] = turned
    mujoco.mj_kinematics(model, data)
    base = data.body("gripper_base")
    frame = base.xmat.reshape(3, 3)
    names = ("left_pad", "right_pad")
    centres = np.array([(data.geom(name).xpos - base.xpos) @ frame for name in names])
    # The faces stay parallel: a pad's own axes are those of the base.
    for name in names:
        np.testing.assert_allclose(frame.T @ data.geom(name).xmat.reshape(3, 3), np.eye(3), atol=1e-12)
    half = model.geom("left_pad").size[1]
    return centres, np.abs(centres[:, 1]) - half


def test_opening_and_angle_are_inverse(gripper):
    for opening in OPENINGS:
        angle = gripper.crank_angle(opening)
        assert 2 * (gripper.crank_offset + gripper.crank_length * math.sin(angle)) == pytest.approx(
            opening, abs=1e-15
        )
    angles = [gripper.crank_angle(opening) for opening in OPENINGS]
    assert np.all(np.diff(angles) > 0)


@pytest.mark.parametrize("opening", OPENINGS[::3])
def test_pads_are_where_the_description_puts_them(gripper, opening):
    centres, faces = pads(opening, gripper)
    np.testing.assert_allclose(faces, opening / 2, atol=STATED)
    np.testing.assert_allclose(centres[:, 2], gripper.pad_depth(opening), atol=STATED)
    np.testing.assert_allclose(centres[:, 0], 0, atol=1e-12)


def test_pads_swing_outward_as_they_close(gripper):
    depths = [gripper.pad_depth(opening) for opening in OPENINGS]
    # The crank's end is lowest when the crank points straight ahead, which is at an opening of twice its offset.
    straight = 2 * gripper.crank_offset
    assert straight < 0.02
    closing = [depth for opening, depth in zip(OPENINGS, depths, strict=True) if opening > straight]
    assert np.all(np.diff(closing) < 0)


def test_joint_limits_of_the_description_allow_the_whole_stroke(gripper):
    model = mujoco.MjModel.from_xml_string(gen3_mjcf())
    turned = gripper.crank_angle(gripper.max_opening) - gripper.crank_angle(0.0)
    for side in ("left", "right"):
        low, high = model.joint(f"{side}_crank_joint").range
        assert low <= 0 < turned <= high


def test_sizes_are_those_of_the_description(gripper):
    model = mujoco.MjModel.from_xml_string(gen3_mjcf())
    half = model.geom("left_pad").size
    assert gripper.pad_width == pytest.approx(2 * half[0])
    assert gripper.pad_length == pytest.approx(2 * half[2])
    assert gripper.pad_area == pytest.approx(4 * half[0] * half[2])
    assert gripper.tool_depth == pytest.approx(model.site("tool_frame").pos[2])


def test_published_figures(gripper):
    assert gripper.max_opening == 0.085  # stroke, Robotiq's manual
    assert (gripper.min_speed, gripper.max_speed) == (0.020, 0.150)
    assert gripper.opening_quantum == pytest.approx(0.085 / 227)  # bits 3 to 230 of its position
    assert robotiq_2f85("face").load_spread == "face"


@pytest.mark.parametrize("opening", [1.0, -0.2, math.nan, math.inf])
def test_opening_that_the_cranks_cannot_have(gripper, opening):
    for question in (gripper.crank_angle, gripper.pad_depth):
        with pytest.raises(InvalidInput, match="2f85: opening"):
            question(opening)
