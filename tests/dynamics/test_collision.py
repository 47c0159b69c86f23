"""Collision checks against brute force over points of the arm's shapes as MuJoCo places them."""

from functools import cache

import mujoco
import numpy as np
import pytest

from dynamics.arm import Arm
from dynamics.collision import Box, Workspace, shifted
from dynamics.errors import InvalidInput, MotionRefused
from dynamics.kinematics import solve_pose, straight_joints, straight_line, tool_down
from models.robot import gen3_mjcf

HOME = np.radians([0.0, 20.0, 180.0, -110.0, 0.0, -50.0, 90.0])
TABLE = Box("table", (1.6, 1.6, 0.04), shifted(0.0, 0.0, -0.02))
CUBE = Box("cube", (0.056, 0.056, 0.056), shifted(0.5, 0.0, 0.028))
GRID = 0.005  # m between the points that stand for a link
# m: a point of a solid is within half the diagonal of a cell of one of them, so a gap up to here may be none
UNSURE = np.sqrt(3) / 2 * GRID
CAPSULE, CYLINDER, BOX = mujoco.mjtGeom.mjGEOM_CAPSULE, mujoco.mjtGeom.mjGEOM_CYLINDER, mujoco.mjtGeom.mjGEOM_BOX


@pytest.fixture(scope="module")
def arm():
    return Arm.gen3()


@pytest.fixture(scope="module")
def start(arm):
    return solve_pose(arm, tool_down([0.42, 0.0, 0.38], 0.0), HOME)


@pytest.fixture(scope="module")
def world():
    model = mujoco.MjModel.from_xml_string(gen3_mjcf())
    return model, mujoco.MjData(model)


def place(world, q):
    """Put MuJoCo's arm, gripper open, at joint positions."""
    model, data = world
    data.qpos[:] = 0
    data.qpos[: len(q)] = q
    mujoco.mj_kinematics(model, data)


def grid(*half):
    """Return points that fill a box of half edges, faces included, at most GRID apart."""
    axes = [np.linspace(-h, h, max(int(np.ceil(2 * h / GRID)) + 1, 2)) if h > 0 else np.zeros(1) for h in half]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


@cache
def solid(kind, size):
    """Return points of a shape in its own frame, and by how much the shape reaches beyond each of them [m]."""
    if kind == CAPSULE:
        return grid(0.0, 0.0, size[1]), size[0]
    if kind == BOX:
        return grid(*size), 0.0
    assert kind == CYLINDER
    points = grid(size[0], size[0], size[1])
    radius = np.hypot(points[:, 0], points[:, 1])
    points[:, :2] *= np.minimum(1, size[0] / np.maximum(radius, 1e-9))[:, None]
    return points, 0.0


def distance(points, kind, size):
    """Return how far points in a shape's own frame are from it, 0 inside a box or a cylinder [m]."""
    if kind == BOX:
        return np.linalg.norm(np.maximum(np.abs(points) - size, 0), axis=1)
    radius, beyond = np.hypot(points[:, 0], points[:, 1]), np.maximum(np.abs(points[:, 2]) - size[1], 0)
    if kind == CAPSULE:
        return np.hypot(radius, beyond) - size[0]
    return np.hypot(np.maximum(radius - size[0], 0), beyond)


def placed(world, geom):
    """Return points of a shape in the base, and by how much the shape reaches beyond each of them [m]."""
    model, data = world
    points, reach = solid(model.geom_type[geom], tuple(model.geom_size[geom]))
    return points @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom], reach


def gap_to_box(world, box):
    """Return the distance from the placed arm without its base to a box, up to UNSURE too large [m]."""
    model, _ = world
    gap = np.inf
    for geom in set(range(model.ngeom)) - {model.geom("base").id}:
        points, reach = placed(world, geom)
        inside = (points - box.pose[:3, 3]) @ box.pose[:3, :3]
        gap = min(gap, distance(inside, BOX, np.array(box.size) / 2).min() - reach)
    return gap


def gaps_within(world, pairs):
    """Return the distances of pairs of the placed arm's shapes, up to UNSURE too large [m]."""
    model, data = world
    gaps = []
    for a, b in pairs:
        points, reach = placed(world, a)
        inside = (points - data.geom_xpos[b]) @ data.geom_xmat[b].reshape(3, 3)
        gaps.append(distance(inside, model.geom_type[b], model.geom_size[b]).min() - reach)
    return np.array(gaps)


def random_box(rng):
    pose = tool_down(rng.uniform([-0.2, -0.6, 0.1], [0.8, 0.6, 1.0]), rng.uniform(-3, 3), rng.uniform(-1, 1))
    return Box("box", tuple(rng.uniform(0.02, 0.3, 3)), pose)


def test_boxes_against_brute_force(arm, world):
    rng = np.random.default_rng(1)
    blind = Workspace(arm, (), HOME)
    seen = {True: 0, False: 0}
    while min(seen.values()) < 25:
        q = rng.uniform(-2, 2, arm.nv)
        if not blind.is_free(q):
            continue  # the arm touches itself: nothing to learn about boxes
        box = random_box(rng)
        place(world, q)
        gap = gap_to_box(world, box)
        if 0 < gap <= UNSURE:
            continue
        free = Workspace(arm, (box,), HOME).is_free(q)
        assert free == (gap > 0), f"{gap=}"
        seen[free] += 1


def test_the_arm_against_itself(arm, world):
    model, _ = world
    link = np.minimum(
        model.geom_bodyid, model.body("bracelet_link").id
    )  # the open gripper is one with the bracelet
    pairs = [(a, b) for a in range(model.ngeom) for b in range(model.ngeom) if link[a] < link[b]]
    place(world, HOME)
    pairs = [pair for pair, gap in zip(pairs, gaps_within(world, pairs), strict=True) if gap > 0]  # no neighbours
    blind = Workspace(arm, (), HOME)
    rng = np.random.default_rng(2)
    seen = {True: 0, False: 0}
    for _ in range(200):
        # The arm reaches itself only when it is folded: elbow and wrist far towards their ends.
        q = rng.uniform(-1, 1, arm.nv) * np.where(np.isfinite(arm.upper), arm.upper, np.pi)
        q[[3, 5]] = np.copysign(rng.uniform(0.85, 1.0, 2), rng.normal(size=2)) * arm.upper[[3, 5]]
        place(world, q)
        gap = gaps_within(world, pairs).min()
        if 0 < gap <= UNSURE:
            continue
        assert blind.is_free(q) == (gap > 0)
        seen[gap > 0] += 1
    assert min(seen.values()) >= 10


def test_known_cases(arm, start):
    workspace = Workspace(arm, (TABLE, CUBE), start)
    assert workspace.is_free(start)
    above = solve_pose(arm, tool_down([0.5, 0.0, 0.3], 0.0), start)
    assert workspace.is_free(above)
    # The tool frame is 0.12 m from the flange; the fingertips reach 0.152 m, so 3.2 cm beyond it.
    assert workspace.is_free(solve_pose(arm, tool_down([0.3, 0.0, 0.04], 0.0), start))
    assert not workspace.is_free(solve_pose(arm, tool_down([0.3, 0.0, 0.02], 0.0), start))
    # Around the cube of 56 mm with fingers 85 mm apart, but not 3 cm beside it.
    assert workspace.is_free(solve_pose(arm, tool_down([0.5, 0.0, 0.06], 0.0), start))
    assert not workspace.is_free(solve_pose(arm, tool_down([0.5, 0.03, 0.06], 0.0), start))
    # A cube of 64 mm fits as well, but not turned by 45 degrees, with its diagonal of 90.5 mm between the pads.
    wide = Workspace(arm, (TABLE, Box("wide", (0.064,) * 3, shifted(0.5, 0.0, 0.032))), start)
    assert wide.is_free(solve_pose(arm, tool_down([0.5, 0.0, 0.06], 0.0), start))
    assert not wide.is_free(solve_pose(arm, tool_down([0.5, 0.0, 0.06], np.pi / 4), start))


def test_path_into_the_table_names_both_and_how_far(arm, start):
    workspace = Workspace(arm, (TABLE, CUBE), start)
    down = straight_line(arm, start, tool_down([0.42, 0.2, 0.005], 0.0))
    with pytest.raises(MotionRefused) as refusal:
        workspace.check(down)
    text = str(refusal.value)
    assert "table" in text
    assert "pad" in text or "fingertip" in text
    share = int(text.split(" %")[0].split()[-1])
    heights = [arm.tool_pose(q)[2, 3] for q in down]
    reached = np.interp(share / 100, np.linspace(0, 1, len(down)), heights)
    assert 0.02 < reached < 0.06  # the tips are 3.2 cm beyond the tool frame; a step of the path is 1 cm
    workspace.check(down[:5])


def test_path_through_the_cube_is_refused_though_its_ends_are_free(arm, start):
    workspace = Workspace(arm, (TABLE, CUBE), start)
    left, right = (solve_pose(arm, tool_down([0.5, y, 0.08], 0.0), start) for y in (-0.2, 0.2))
    assert workspace.is_free(left)
    assert workspace.is_free(right)
    with pytest.raises(MotionRefused, match="cube"):
        workspace.check(np.array([left, right]))
    Workspace(arm, (TABLE,), start).check(np.array([left, right]))


def test_a_path_of_one_point_is_checked(arm, start):
    workspace = Workspace(arm, (TABLE,), start)
    inside = solve_pose(arm, tool_down([0.42, 0.0, 0.0], 0.0), start)
    workspace.check(start[None])
    with pytest.raises(MotionRefused, match="table"):
        workspace.check(inside[None])


def test_carried_box(arm, start):
    # 10 cm below the tool frame (whose z looks down), 4 cm thick: it meets the table when the tool is below 12 cm.
    carried = Box("carried", (0.04, 0.04, 0.04), shifted(0.0, 0.0, 0.10))
    laden, empty = Workspace(arm, (TABLE,), start, carried), Workspace(arm, (TABLE,), start)
    for height, free in ((0.13, True), (0.121, True), (0.119, False)):
        q = solve_pose(arm, tool_down([0.42, 0.0, height], 0.3), start)
        assert laden.is_free(q) is free
        assert empty.is_free(q)
    with pytest.raises(MotionRefused, match="carried") as refusal:
        laden.check(straight_line(arm, start, tool_down([0.42, 0.0, 0.1], 0.0)))
    assert "table" in str(refusal.value)


def test_carried_box_swings_with_the_tool(arm, start):
    carried = Box("carried", (0.3, 0.02, 0.02), shifted(0.0, 0.0, 0.0))
    post = Box("post", (0.02, 0.02, 0.2), shifted(0.54, 0.0, 0.38))
    along, across = (solve_pose(arm, tool_down([0.42, 0.0, 0.38], yaw), start) for yaw in (0.0, np.pi / 2))
    laden = Workspace(arm, (post,), start, carried)
    assert not laden.is_free(along)
    assert laden.is_free(across)


def test_a_carried_box_does_not_meet_itself(arm, start):
    carried = Box("cube", (0.05, 0.05, 0.05), shifted(0.0, 0.0, 0.0))
    there = Box("cube", (0.05, 0.05, 0.05), shifted(*arm.tool_pose(start)[:3, 3] + [0.0, 0.0, -0.01]))
    assert Workspace(arm, (Box("far", (0.1, 0.1, 0.1), shifted(0, 0, 2)),), start, carried).is_free(start)
    assert not Workspace(arm, (Box("other", there.size, there.pose),), start, carried).is_free(start)


def test_bad_input(arm, start):
    workspace = Workspace(arm, (TABLE,), start)
    broken = straight_joints(start, start + 0.1)
    broken[1, 2] = np.nan
    for path in (broken, np.zeros((2, arm.nv - 1)), start, np.zeros((0, arm.nv))):
        with pytest.raises(InvalidInput):
            workspace.check(path)


def test_an_arm_without_shapes_is_refused(start):
    bare = Arm(Arm.gen3().model, "tool_frame")
    with pytest.raises(MotionRefused, match="no collision shapes"):
        Workspace(bare, (TABLE,), start)
