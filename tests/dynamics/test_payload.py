"""The payload's regressors against Pinocchio's own dynamics of an arm that carries the body."""

import numpy as np
import pinocchio as pin
import pytest

from dynamics.arm import Arm
from dynamics.errors import InvalidInput, UnknownName
from dynamics.named import ROBOTS, example_description
from dynamics.payload import (
    from_log_cholesky,
    inertia_parameters,
    is_physical,
    log_cholesky_jacobian,
    pseudo_inertia,
    to_log_cholesky,
)
from models.robot import gen3_mjcf

MASS, CENTER = 1.7, np.array([0.03, -0.05, 0.08])
SPREAD = np.array([[0.02, 0.001, -0.002], [0.001, 0.03, 0.003], [-0.002, 0.003, 0.025]])
BODY = inertia_parameters(MASS, CENTER, SPREAD)


@pytest.fixture(scope="module", params=ROBOTS)
def arm(request):
    return Arm.named(request.param)


def loaded(arm: Arm) -> pin.Model:
    """The same arm with the body welded to its last joint: an independent way to the same torque."""
    model = arm.model.copy()
    frame = model.frames[model.getFrameId(arm.tool_frame)]
    model.appendBodyToJoint(frame.parentJoint, pin.Inertia(MASS, CENTER, SPREAD), frame.placement)
    return model


def test_static_regressor_equals_the_gravity_of_a_loaded_model(arm):
    model = loaded(arm)
    data = model.createData()
    rng = np.random.default_rng(0)
    for _ in range(50):
        q = rng.uniform(-3, 3, arm.nv)
        expected = pin.rnea(model, data, arm.configuration(q), np.zeros(arm.nv), np.zeros(arm.nv))
        found = arm.gravity(q) + arm.payload_regressor(q) @ BODY[:4]
        np.testing.assert_allclose(found, expected, atol=1e-9, rtol=0)


def test_dynamic_regressor_equals_the_dynamics_of_a_loaded_model(arm):
    model = loaded(arm)
    data = model.createData()
    rng = np.random.default_rng(1)
    for _ in range(50):
        q, dq, ddq = rng.uniform(-3, 3, arm.nv), rng.normal(size=arm.nv), 3 * rng.normal(size=arm.nv)
        expected = pin.rnea(model, data, arm.configuration(q), dq, ddq)
        found = arm.inverse_dynamics(q, dq, ddq) + arm.payload_regressor(q, dq, ddq) @ BODY
        np.testing.assert_allclose(found, expected, atol=1e-9, rtol=0)


def test_dynamic_regressor_at_rest_is_the_static_one(arm):
    q, still = np.linspace(-1, 1, arm.nv), np.zeros(arm.nv)
    moving = arm.payload_regressor(q, still, still)
    np.testing.assert_allclose(moving[:, :4], arm.payload_regressor(q), atol=1e-12)
    np.testing.assert_allclose(moving[:, 4:], 0, atol=1e-12)


def test_fingers_are_locked():
    assert Arm.named("panda").nv == 7


def test_files_say_what_names_say(tmp_path):
    """The same arm from its MJCF file, and another from its URDF, with the fingers locked on the way."""
    path = tmp_path / "gen3.xml"
    path.write_text(gen3_mjcf())
    q = np.linspace(-1, 1, 7)
    from_file = Arm.from_mjcf(path, "tool_frame")
    np.testing.assert_allclose(from_file.gravity(q), Arm.gen3().gravity(q), atol=1e-12)
    np.testing.assert_allclose(from_file.payload_regressor(q), Arm.gen3().payload_regressor(q), atol=1e-12)
    urdf, frame = example_description("panda")
    np.testing.assert_array_equal(Arm.from_urdf(urdf, frame).gravity(q), Arm.named("panda").gravity(q))
    with pytest.raises(UnknownName, match="tool_frame"):
        Arm.from_mjcf(path, "nowhere")


def test_unknown_robot_lists_the_known_ones():
    with pytest.raises(UnknownName, match="ur10"):
        Arm.named("hal")


def test_half_a_motion_is_refused(arm):
    with pytest.raises(InvalidInput, match="both, or neither"):
        arm.payload_regressor(np.zeros(arm.nv), np.zeros(arm.nv))


def test_log_cholesky_round_trip_and_body():
    np.testing.assert_allclose(from_log_cholesky(to_log_cholesky(BODY)), BODY, atol=1e-14)
    rng = np.random.default_rng(2)
    for _ in range(100):
        assert is_physical(from_log_cholesky(rng.normal(size=10)))


def test_log_cholesky_jacobian_is_the_derivative():
    at, step = np.linspace(-0.5, 0.5, 10), 1e-6
    numeric = np.column_stack(
        [(from_log_cholesky(at + step * e) - from_log_cholesky(at - step * e)) / (2 * step) for e in np.eye(10)]
    )
    np.testing.assert_allclose(log_cholesky_jacobian(at), numeric, atol=1e-8)


def test_pseudo_inertia_is_the_second_moment_of_points():
    points = np.random.default_rng(3).normal(size=(40, 3))
    inertia = sum(p @ p * np.eye(3) - np.outer(p, p) for p in points) / 40
    center = points.mean(axis=0)
    about_center = inertia + np.outer(center, center) - center @ center * np.eye(3)
    homogeneous = np.column_stack([points, np.ones(40)])
    np.testing.assert_allclose(
        pseudo_inertia(inertia_parameters(1.0, center, about_center)), homogeneous.T @ homogeneous / 40, atol=1e-12
    )


def test_impossible_body_is_refused():
    thin = BODY.copy()
    thin[4:] = [0.1, 0, 0.1, 0, 0, 10.0]  # breaks the triangle inequality of moments
    assert not is_physical(thin)
    with pytest.raises(InvalidInput, match="positive definite"):
        to_log_cholesky(thin)
