"""Inverse kinematics against forward kinematics, over random poses that are known to be reachable."""

import numpy as np
import pytest

from dynamics.arm import Arm
from dynamics.errors import InvalidInput, MotionRefused
from dynamics.kinematics import solve_pose, straight_joints, straight_line, tool_down

HOME = np.radians([0.0, 20.0, 180.0, -110.0, 0.0, -50.0, 90.0])
REACHED = 1e-9  # m and rad, what the solver promises
# m: rounding of the elements of a product of some twenty rotations and lengths below 2
ROUNDING = 1e-14


@pytest.fixture(scope="module")
def arm():
    return Arm.gen3()


@pytest.fixture(scope="module")
def start(arm):
    return solve_pose(arm, tool_down([0.42, 0.0, 0.38], 0.0), HOME)


def error_of(found, wanted):
    """Return distance [m] and angle [rad] between two poses; the angle by the chord, sound near zero."""
    turn = found[:3, :3].T @ wanted[:3, :3]
    axis = [turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]
    angle = np.arctan2(np.linalg.norm(axis) / 2, (np.trace(turn) - 1) / 2)
    return np.linalg.norm(found[:3, 3] - wanted[:3, 3]), angle


def random_positions(arm, rng, count):
    """Return joint positions away from the ends of the limited joints, so that their pose can surely be had."""
    half = np.where(np.isfinite(arm.upper), arm.upper, np.pi)
    return rng.uniform(-0.9, 0.9, (count, arm.nv)) * half


def test_pose_is_reached_within_the_limits(arm):
    rng = np.random.default_rng(1)
    for q in random_positions(arm, rng, 150):
        pose = arm.tool_pose(q)
        found = solve_pose(arm, pose, HOME)
        distance, angle = error_of(arm.tool_pose(found), pose)
        assert distance < REACHED + ROUNDING
        assert angle < REACHED + ROUNDING
        assert arm.within_limits(found)


def test_solution_is_near_where_it_starts(arm):
    rng = np.random.default_rng(2)
    for q in random_positions(arm, rng, 50):
        near = q + rng.uniform(-0.05, 0.05, arm.nv)
        found = solve_pose(arm, arm.tool_pose(q), near)
        # The damped step is the shortest that closes the gap, and q itself is one way to close it.
        assert np.linalg.norm(found - near) < 2 * np.linalg.norm(q - near)


def test_solution_is_where_it_starts_if_nothing_is_to_be_done(arm):
    np.testing.assert_array_equal(solve_pose(arm, arm.tool_pose(HOME), HOME), HOME)


def test_same_question_same_answer(arm):
    poses = [arm.tool_pose(q) for q in random_positions(arm, np.random.default_rng(3), 20)]
    first = [solve_pose(arm, pose, HOME) for pose in poses]
    second = [solve_pose(Arm.gen3(), pose, HOME) for pose in reversed(poses)]
    np.testing.assert_array_equal(first, second[::-1])


@pytest.mark.parametrize("position", [[1.5, 0.0, 0.3], [0.0, 0.0, 2.0], [0.5, 0.0, -1.2]])
def test_out_of_reach_is_refused(arm, position):
    with pytest.raises(MotionRefused, match="out of reach") as refusal:
        solve_pose(arm, tool_down(position, 0.0), HOME)
    assert f"{position[0]:.3f}" in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_limits_are_kept_where_the_nearest_solution_leaves_them(arm):
    # The limited joints stand near their ends, and the pose is one of an arm that has gone past them.
    rng = np.random.default_rng(4)
    limited = np.isfinite(arm.upper)
    found, refused = 0, 0
    for _ in range(60):
        side, free = rng.choice([-1, 1], arm.nv), rng.uniform(-3, 3, arm.nv)
        end = np.where(limited, side * arm.upper * rng.uniform(0.9, 1.0, arm.nv), free)
        beyond = end + np.where(limited, side * rng.uniform(0.0, 0.3, arm.nv), 0.0)
        if arm.within_limits(beyond):
            continue
        try:
            q = solve_pose(arm, arm.tool_pose(beyond), end)
        except MotionRefused:
            refused += 1
            continue
        found += 1
        assert arm.within_limits(q)
        assert max(error_of(arm.tool_pose(q), arm.tool_pose(beyond))) < REACHED + ROUNDING
    assert min(found, refused) > 0


@pytest.mark.parametrize("yaw", [-3.0, -0.7, 0.0, 1.2])
@pytest.mark.parametrize("tilt", [0.0, 0.4])
def test_tool_down_looks_down(yaw, tilt):
    pose = tool_down([0.1, 0.2, 0.3], yaw, tilt)
    np.testing.assert_array_equal(pose[:3, 3], [0.1, 0.2, 0.3])
    np.testing.assert_allclose(pose[:3, :3].T @ pose[:3, :3], np.eye(3), atol=1e-15)
    assert np.linalg.det(pose[:3, :3]) == pytest.approx(1)
    assert -pose[2, 2] == pytest.approx(np.cos(tilt))  # approach against the vertical
    np.testing.assert_allclose(pose[:3, 1], [-np.sin(yaw), np.cos(yaw), 0], atol=1e-15)


@pytest.mark.parametrize("goal", [([0.42, 0.0, 0.1], 0.0), ([0.55, 0.2, 0.3], 0.8), ([0.35, -0.2, 0.4], -0.6)])
def test_straight_line(arm, start, goal):
    wanted = tool_down(*goal)
    path = straight_line(arm, start, wanted)
    poses = np.array([arm.tool_pose(q) for q in path])
    np.testing.assert_array_equal(path[0], start)
    distance, angle = error_of(poses[-1], wanted)
    assert distance < 2 * REACHED  # the last of several solutions, each within REACHED
    assert angle < 2 * REACHED
    assert all(arm.within_limits(q) for q in path)
    # Straight: every position on the line between the ends, in order and evenly.
    first, way = poses[0, :3, 3], wanted[:3, 3] - poses[0, :3, 3]
    share = (poses[:, :3, 3] - first) @ way / (way @ way)
    np.testing.assert_allclose(share, np.linspace(0, 1, len(path)), atol=2 * REACHED / np.linalg.norm(way))
    off = poses[:, :3, 3] - first - share[:, None] * way
    assert np.linalg.norm(off, axis=1).max() < 2 * REACHED
    # Rotation: about one axis at a constant rate, so angles from the start and to the end add up.
    whole = error_of(poses[0], wanted)[1]
    for part, pose in zip(share, poses, strict=True):
        assert error_of(poses[0], pose)[1] == pytest.approx(part * whole, abs=4 * REACHED)
        assert error_of(pose, wanted)[1] == pytest.approx((1 - part) * whole, abs=4 * REACHED)


def test_straight_line_is_straight_between_its_poses(arm, start):
    path = straight_line(arm, start, tool_down([0.42, 0.0, 0.1], 0.0))
    middles = np.array([arm.tool_pose(q)[:3, 3] for q in (path[:-1] + path[1:]) / 2])
    # A chord of 1 cm leaves a circle of radius r by (1 cm)^2 / (8 r): 0.1 mm down to radii of 12 cm.
    assert np.abs(middles[:, :2] - [0.42, 0.0]).max() < 1e-4


def test_straight_line_of_no_length(arm, start):
    path = straight_line(arm, start, arm.tool_pose(start))
    assert len(path) >= 1
    np.testing.assert_allclose(path, np.broadcast_to(start, path.shape), atol=1e-9)


def test_straight_line_out_of_reach_is_refused(arm, start):
    with pytest.raises(MotionRefused, match="cannot go straight") as refusal:
        straight_line(arm, start, tool_down([1.4, 0.0, 0.3], 0.0))
    assert "%" in str(refusal.value)


def test_straight_line_never_jumps(arm, start):
    rng = np.random.default_rng(5)
    went = 0
    for _ in range(40):
        goal = tool_down(rng.uniform([0.2, -0.5, 0.05], [0.8, 0.5, 0.6]), rng.uniform(-3, 3))
        try:
            path = straight_line(arm, start, goal)
        except MotionRefused:
            continue
        went += 1
        assert np.abs(np.diff(path, axis=0)).max() <= 0.25
    assert went > 10


def test_straight_joints():
    start, end = np.array([0.0, 1.0]), np.array([0.3, 0.9])
    path = straight_joints(start, end, step=0.02)
    np.testing.assert_array_equal(path[[0, -1]], [start, end])
    assert np.abs(np.diff(path, axis=0)).max() <= 0.02 * (1 + 1e-9)
    np.testing.assert_allclose(np.diff(path, 2, axis=0), 0, atol=1e-15)
    np.testing.assert_array_equal(straight_joints(start, start), [start, start])


def test_bad_input(arm, start):
    good = tool_down([0.42, 0.0, 0.38], 0.0)
    mirrored, nan, scaled = good * [1, -1, 1, 1], good.copy(), good.copy()
    nan[0, 3], scaled[:3, :3] = np.nan, 2 * good[:3, :3]
    for pose in (good[:3, :3], nan, scaled, mirrored, 2 * good):
        with pytest.raises(InvalidInput, match="tool pose"):
            solve_pose(arm, pose, start)
        with pytest.raises(InvalidInput, match="tool pose"):
            straight_line(arm, start, pose)
    for q in (start[:-1], start * np.nan, start[None]):
        with pytest.raises(InvalidInput, match="joint positions"):
            solve_pose(arm, good, q)
        with pytest.raises(InvalidInput, match="joint positions"):
            straight_line(arm, q, good)
        with pytest.raises(InvalidInput, match="straight motion"):
            straight_joints(start, q)
    for step in (0.0, -1.0, np.nan):
        with pytest.raises(InvalidInput, match="step"):
            straight_joints(start, start + 1, step)
