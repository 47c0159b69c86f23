"""Timed motions against the arm's limits, by finite differences of what is stored."""

import numpy as np
import pytest

from dynamics.arm import Arm
from dynamics.errors import InvalidInput
from dynamics.kinematics import solve_pose, straight_joints, straight_line, tool_down
from dynamics.trajectory import CORNER, JERK_TIME, STEP, Trajectory, time_path

HOME = np.radians([0.0, 20.0, 180.0, -110.0, 0.0, -50.0, 90.0])
# A finite difference of order k is the mean of the k-th derivative over its stretch of time, so where the
# derivative is within a limit it is too; what is left is rounding, 1e-16 rad / (1e-2 s)^3 = 1e-10 rad/s^3 times 8.
ROUNDING = 1e-8
SPEEDS = (0.05, 0.35, 0.6, 1.0)


@pytest.fixture(scope="module")
def arm():
    return Arm.gen3()


@pytest.fixture(scope="module")
def start(arm):
    return solve_pose(arm, tool_down([0.42, 0.0, 0.38], 0.0), HOME)


def differences(trajectory):
    """Return speed, acceleration and jerk of evenly stored positions."""
    step = np.diff(trajectory.time)
    assert np.ptp(step) < 1e-12
    return [np.diff(trajectory.q, order, axis=0) / step[0] ** order for order in (1, 2, 3)]


def assert_within_limits(arm, trajectory, speed):
    limits = (arm.velocity_limit, arm.acceleration_limit, arm.acceleration_limit / JERK_TIME)
    for order, (found, limit) in enumerate(zip(differences(trajectory), limits, strict=True), 1):
        assert np.abs(found / (speed * limit)).max(initial=0.0) <= 1 + ROUNDING, f"derivative {order}"


def random_joint_path(arm, rng, start):
    return straight_joints(start, start + rng.uniform(-1.5, 1.5, arm.nv))


@pytest.mark.parametrize("speed", SPEEDS)
def test_straight_motions_respect_every_limit_and_reach_one(arm, start, speed):
    rng = np.random.default_rng(1)
    for _ in range(20):
        path = random_joint_path(arm, rng, start)
        trajectory = time_path(arm, path, speed)
        assert_within_limits(arm, trajectory, speed)
        # Time-optimal: some limit is used up; a jerk that lasts only moments is averaged by the differences.
        v, a, _ = differences(trajectory)
        used = max(
            np.abs(v / (speed * arm.velocity_limit)).max(), np.abs(a / (speed * arm.acceleration_limit)).max()
        )
        assert used > 0.9


@pytest.mark.parametrize("speed", SPEEDS)
@pytest.mark.parametrize("goal", [[0.42, 0.0, 0.1], [0.6, 0.2, 0.3], [0.3, -0.3, 0.4]])
def test_straight_lines_of_the_tool_respect_every_limit(arm, start, speed, goal):
    # The joints' paths bend here, and bending costs acceleration and jerk of its own.
    path = straight_line(arm, start, tool_down(goal, 0.4))
    trajectory = time_path(arm, path, speed)
    assert_within_limits(arm, trajectory, speed)


@pytest.mark.parametrize("radius", [0.02, 0.1, 0.4])
@pytest.mark.parametrize("speed", [0.3, 1.0])
def test_tight_curves_respect_every_limit(arm, start, radius, speed):
    # Twice round a circle in two joints: what bending alone takes, v^2 / r, decides how fast it can be gone round.
    angle = np.linspace(0, 4 * np.pi, 400)
    path = np.tile(start, (len(angle), 1))
    path[:, 1] += radius * np.sin(angle)
    path[:, 3] += radius * (1 - np.cos(angle))
    trajectory = time_path(arm, path, speed)
    assert_within_limits(arm, trajectory, speed)
    assert distance_to_polyline(trajectory.q[::10], path).max() < 1e-3 * radius


def test_speed_scales_the_duration(arm, start):
    path = straight_joints(start, start + 0.5)
    durations = [time_path(arm, path, speed).duration for speed in SPEEDS]
    assert durations == sorted(durations, reverse=True)
    assert durations[0] > 2 * durations[-1]


def test_starts_and_ends_at_rest_on_the_ends_of_the_path(arm, start):
    rng = np.random.default_rng(2)
    for path in (random_joint_path(arm, rng, start), straight_line(arm, start, tool_down([0.5, 0.1, 0.2], 0.0))):
        trajectory = time_path(arm, path)
        np.testing.assert_array_equal(trajectory.q[0], path[0])
        np.testing.assert_array_equal(trajectory.q[-1], path[-1])
        assert trajectory.time[0] == 0
        assert trajectory.duration == trajectory.time[-1]
        # From rest with the largest jerk J, speed is J t^2 / 2: the mean over the first step is J STEP^2 / 6.
        largest = (arm.acceleration_limit / JERK_TIME) * STEP**2 / 6
        speed = np.abs(differences(trajectory)[0])
        assert np.all(speed[[0, -1]] <= largest * (1 + ROUNDING))


def distance_to_polyline(points, path):
    """Return how far each point is from a polyline, by brute force over its segments."""
    a, b = path[:-1], path[1:]
    edge = b - a
    share = np.einsum("nsj,sj->ns", points[:, None] - a, edge) / np.einsum("sj,sj->s", edge, edge)
    nearest = a + np.clip(share, 0, 1)[..., None] * edge
    return np.linalg.norm(points[:, None] - nearest, axis=2).min(axis=1)


def test_stays_on_the_path(arm, start):
    path = random_joint_path(arm, np.random.default_rng(3), start)
    assert distance_to_polyline(time_path(arm, path).q, path).max() < 1e-12
    for goal in ([0.42, 0.0, 0.1], [0.3, -0.3, 0.4]):
        path = straight_line(arm, start, tool_down(goal, 0.0))
        trajectory = time_path(arm, path)
        assert distance_to_polyline(trajectory.q, path).max() < CORNER
        # Between its points the smooth path is nearer to the tool's line than the polyline is, which leaves it
        # by up to curvature x (1 cm)^2 / 8, some 0.02 mm at the arm's own radii.
        ends = [arm.tool_pose(q)[:3, 3] for q in path[[0, -1]]]
        way = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
        for q in trajectory.q[::5]:
            off = arm.tool_pose(q)[:3, 3] - ends[0]
            assert np.linalg.norm(off - (off @ way) * way) < 2e-5


def test_moves_on_along_the_path(arm, start):
    path = random_joint_path(arm, np.random.default_rng(4), start)
    along = time_path(arm, path).q @ (path[-1] - path[0])
    assert np.all(np.diff(along) > -1e-12)


def test_position_is_what_is_stored_and_linear_in_between(arm, start):
    trajectory = time_path(arm, straight_joints(start, start + 0.3))
    for i in (0, 3, len(trajectory.time) - 1):
        np.testing.assert_allclose(trajectory.position(trajectory.time[i]), trajectory.q[i], atol=1e-14)
    middle = (trajectory.time[4] + trajectory.time[5]) / 2
    np.testing.assert_allclose(trajectory.position(middle), trajectory.q[4:6].mean(axis=0), atol=1e-14)
    np.testing.assert_array_equal(trajectory.position(trajectory.duration + 1), trajectory.q[-1])


def test_path_without_motion(arm, start):
    for path in (start[None], np.array([start] * 5)):
        trajectory = time_path(arm, path)
        assert trajectory.duration > 0
        assert np.all(trajectory.q == start)


def test_repeated_points_change_nothing(arm, start):
    path = straight_joints(start, start + 0.3)
    once, twice = time_path(arm, path), time_path(arm, np.repeat(path, 2, axis=0))
    np.testing.assert_allclose(twice.q, once.q, atol=1e-9)


def test_same_path_same_trajectory(arm, start):
    path = straight_line(arm, start, tool_down([0.5, 0.1, 0.2], 0.3))
    first, second = time_path(arm, path), time_path(arm, path)
    assert np.array_equal(first.q, second.q)
    assert np.array_equal(first.time, second.time)


def test_corner_is_refused(arm, start):
    there, aside = start + 0.4, start + np.array([0.4, -0.4] * 3 + [0.4])
    path = np.vstack([straight_joints(start, there), straight_joints(there, aside)[1:]])
    # A corner of a right angle in a path with steps of 0.02 rad is cut by less than CORNER and slowed down for.
    assert_within_limits(arm, time_path(arm, path, 1.0), 1.0)
    with pytest.raises(InvalidInput, match="corner near point"):
        time_path(arm, np.array([start, there, aside]))


@pytest.mark.parametrize("speed", [0.0, -0.1, 1.0001, np.nan, np.inf])
def test_speed_out_of_range(arm, start, speed):
    with pytest.raises(InvalidInput, match="speed"):
        time_path(arm, straight_joints(start, start + 0.1), speed)


def test_path_that_is_none(arm, start):
    broken = straight_joints(start, start + 0.1)
    broken[2, 3] = np.nan
    for path in (start, np.zeros((0, arm.nv)), np.zeros((3, arm.nv - 1)), np.zeros((2, 2, arm.nv)), broken):
        with pytest.raises(InvalidInput, match="motion: path"):
            time_path(arm, path)


@pytest.mark.parametrize(
    ("time", "q"),
    [
        ([0.0, 1.0], np.zeros(2)),
        ([], np.zeros((0, 7))),
        ([0.0, 1.0], np.full((2, 7), np.inf)),
        ([0.0], np.zeros((2, 7))),
        ([0.0, np.nan], np.zeros((2, 7))),
        ([0.0, 0.0], np.zeros((2, 7))),
        ([0.5, 1.0], np.zeros((2, 7))),
        ([0.0, 2.0, 1.0], np.zeros((3, 7))),
    ],
)
def test_no_trajectory(time, q):
    with pytest.raises(InvalidInput, match="trajectory"):
        Trajectory(np.array(time), q)


def test_positions_at_several_times_are_those_at_each(arm, start):
    trajectory = time_path(arm, random_joint_path(arm, np.random.default_rng(4), start), 0.6)
    times = np.concatenate([trajectory.time, np.random.default_rng(5).uniform(0, 1.1 * trajectory.duration, 200)])
    np.testing.assert_array_equal(trajectory.positions(times), [trajectory.position(t) for t in times])
    still = Trajectory(np.zeros(1), start[None])
    np.testing.assert_array_equal(still.positions(times), [still.position(t) for t in times])
