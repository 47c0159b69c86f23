"""The one description means the same to Pinocchio and to MuJoCo."""

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from models.robot import REVISIONS, as_file, gen3_mjcf

VARIANTS = [(r, v, g) for r in REVISIONS for v in (True, False) for g in ("2f85", None)]
# kg: totals of the maker's files (base included), and Kinova's 0.925 kg for the gripper
ARM_MASS = {
    ("V12", True): 8.1885,
    ("V12", False): 8.05,
    ("BRAKES", True): 8.44433795,
    ("BRAKES", False): 8.32505838,
}


@pytest.mark.parametrize(("revision", "vision", "gripper"), VARIANTS)
def test_engines_agree(revision, vision, gripper):
    mjcf = gen3_mjcf(revision, vision, gripper)
    with as_file(mjcf) as path:
        model = pin.buildModelFromMJCF(str(path))
    data = model.createData()
    world = mujoco.MjModel.from_xml_string(mjcf)
    state = mujoco.MjData(world)
    site = mujoco.mj_name2id(world, mujoco.mjtObj.mjOBJ_SITE, "tool_frame")
    frame = model.getFrameId("tool_frame")
    rng = np.random.default_rng(1)
    for _ in range(200):
        q = rng.uniform(-np.pi, np.pi, model.nv)
        v, a = rng.normal(size=(2, model.nv))
        state.qpos[:], state.qvel[:], state.qacc[:] = q, v, a
        mujoco.mj_fwdPosition(world, state)
        mujoco.mj_fwdVelocity(world, state)
        torque = np.zeros(model.nv)
        mujoco.mj_rne(world, state, 1, torque)
        torque += world.dof_armature * a
        np.testing.assert_allclose(pin.rnea(model, data, q, v, a), torque, atol=1e-9, rtol=0)
        state.qvel[:] = 0
        mujoco.mj_fwdVelocity(world, state)
        mujoco.mj_rne(world, state, 0, torque)
        np.testing.assert_allclose(pin.computeGeneralizedGravity(model, data, q), torque, atol=1e-9, rtol=0)
        mass = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(world, state, mass)
        upper = np.triu(pin.crba(model, data, q))
        np.testing.assert_allclose(upper + np.triu(upper, 1).T, mass, atol=1e-9, rtol=0)
        pin.framesForwardKinematics(model, data, q)
        pose = data.oMf[frame]
        np.testing.assert_allclose(pose.translation, state.site_xpos[site], atol=1e-12, rtol=0)
        np.testing.assert_allclose(pose.rotation, state.site_xmat[site].reshape(3, 3), atol=1e-12, rtol=0)


@pytest.mark.parametrize(("revision", "vision", "gripper"), VARIANTS)
def test_mass_is_the_published_one(revision, vision, gripper):
    world = mujoco.MjModel.from_xml_string(gen3_mjcf(revision, vision, gripper))
    expected = ARM_MASS[revision, vision] + (0.925 if gripper else 0.0)
    assert world.body_mass.sum() == pytest.approx(expected, abs=1e-8)


def test_every_body_states_its_inertial():
    # Pinocchio derives other masses from shapes than MuJoCo does, so none may be left to them.
    import xml.etree.ElementTree as ET

    root = ET.fromstring(gen3_mjcf())
    assert all(body.find("inertial") is not None for body in root.iter("body"))


def test_bracelet_centre_of_mass_is_on_the_side_of_the_camera():
    world = mujoco.MjModel.from_xml_string(gen3_mjcf())
    bracelet = mujoco.mj_name2id(world, mujoco.mjtObj.mjOBJ_BODY, "bracelet_link")
    camera = mujoco.mj_name2id(world, mujoco.mjtObj.mjOBJ_GEOM, "vision_module")
    assert world.body_ipos[bracelet][1] < -0.01
    assert world.geom_pos[camera][1] < 0


@pytest.mark.parametrize("wrong", [("V13", True, None), ("V12", True, "3f")])
def test_unknown_variant(wrong):
    with pytest.raises(ValueError, match="valid are"):
        gen3_mjcf(*wrong)
