"""The factor graph of a static payload estimate.

    tau_i = g(q_i) + B(q_i) (gripper + [load] payload) + F_i friction + bias_t(i) + offset_pose(i) + noise

The tool (payload, gripper, friction) is one variable, the bias one a step of its chain or one for all, the offset
one for every pose that both tare and load visited: what the arm's model gets wrong there cancels.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dynamics.arm import Arm
from estimation.graph import LinearGraph, Solution, key
from estimation.payload.estimate import PRIOR_SD
from estimation.payload.holds import StaticReadings

Array = NDArray[np.float64]

BIAS_PRIOR_SD = 100.0  # N m, as broad as harmless
FRICTION_PRIOR_SD = 100.0  # N m, N m s/rad
FREE = 1e3  # N m: an offset left free
# What the tare may find beyond the arm's model where every shared pose has an offset of its own [kg, kg m]: these
# explain the tare as well as any gripper does, and the small difference between a tare pose and its load pose
# times a gripper left wild would count as noise of the payload.
GRIPPER_PRIOR_SD = np.array([2.0, 0.4, 0.4, 0.4])
DEFAULT_EFFORT = 10.0  # N m: what a joint is taken to be built for if the description does not say
SAME_POSE = 0.02  # rad within which two poses are the same
SLOW = 0.01  # rad/s below which Coulomb friction has no certain sign


@dataclass(frozen=True)
class Design:
    """What multiplies what in the graph, for every reading; tare rows before load rows.

    Attributes:
        torque: measured torque less the arm's own [N m], (N, nv).
        tool: matrix of payload, gripper and friction, (N, nv, 8 or 8 + 2 nv).
        total: measured torque, what a gain error scales [N m], (N, nv).
        scale: what the joints are built for [N m], a first idea of how their noises compare, (nv,).
        capacity: mass that the strongest joint holds at full reach [kg].
        step: rank of every reading in time, (N,).
        pose: index of the pose that tare and load share, -1 where only one was there, (N,).
    """

    torque: Array
    tool: Array
    total: Array
    scale: Array
    capacity: float
    step: NDArray[np.int_]
    pose: NDArray[np.int_]

    def __len__(self) -> int:
        return len(self.torque)


def design_readings(arm: Arm, tare: StaticReadings, load: StaticReadings, friction: bool) -> Design:
    """Lay out the matrices of every reading."""
    q = np.concatenate([tare.q, load.q])
    total = np.concatenate([tare.tau, load.tau])
    loaded = np.repeat([0.0, 1.0], [len(tare), len(load)])
    body = np.array([arm.payload_regressor(row) for row in q])
    columns = [loaded[:, None, None] * body, body]
    if friction and tare.dq is not None and load.dq is not None:
        dq = np.concatenate([tare.dq, load.dq])
        columns += [np.tanh(dq / SLOW)[:, :, None] * np.eye(arm.nv), dq[:, :, None] * np.eye(arm.nv)]
    time = np.concatenate([tare.time, load.time])
    order = np.argsort(time, kind="stable") if np.all(np.isfinite(time)) else np.arange(len(q))
    step = np.empty(len(q), int)
    step[order] = np.arange(len(q))
    gravity = np.array([arm.gravity(row) for row in q])
    known = bool(np.all(np.isfinite(arm.effort_limit)))
    scale = arm.effort_limit if known else np.full(arm.nv, DEFAULT_EFFORT)
    weight = float(np.linalg.norm(arm.model.gravity.linear)) * arm.reach
    return Design(
        torque=total - gravity,
        tool=np.concatenate(columns, axis=2),
        total=total,
        scale=scale,
        capacity=float(scale.max()) / weight,
        step=step,
        pose=_shared_poses(tare.q, load.q),
    )


@dataclass(frozen=True)
class Fit:
    """A solved graph.

    Attributes:
        tool: payload, gripper and friction.
        residual: of every reading [N m], (N, nv).
        root: upper triangular R of the tool's (and the gains') information R^T R.
    """

    tool: Array
    residual: Array
    root: Array


def solve(design: Design, sigma: Array, drift: Array, pose_sd: Array, gain_sd: Array | None = None) -> Fit:
    """Build the graph and solve it.

    Args:
        design: of the readings.
        sigma: effective standard deviation of every reading [N m], (N, nv).
        drift: sd of a step of the bias [N m], (nv,); all 0 for a constant bias.
        pose_sd: sd of the offset at a shared pose [N m], (nv,); all 0 for none.
        gain_sd: prior sd of each joint's gain error; with it, these errors are parameters after the tool's, (nv,).
    """
    graph, bias, offset, _ = build(design, sigma, drift, pose_sd, gain_sd)
    solution = graph.solve(last=key("x"))
    return _fit(design, solution, bias, offset)


def build(
    design: Design, sigma: Array, drift: Array, pose_sd: Array, gain_sd: Array | None = None
) -> tuple[LinearGraph, list[int], list[int | None], NDArray[np.int_]]:
    """Return the graph, the keys of every reading's bias and offset, and the order of the readings in its rows.

    Readings that share bias and offset are one factor: that says the same and is solved faster.
    """
    count, joints = design.torque.shape
    tool, eye = key("x"), np.eye(joints)
    matrix = (
        np.concatenate([design.tool, design.total[:, :, None] * eye], axis=2)
        if gain_sd is not None
        else design.tool
    )
    walks, offsets = bool(np.any(drift > 0)), bool(np.any(pose_sd > 0))
    graph = LinearGraph()
    bias = [key("b", int(step)) if walks else key("b") for step in design.step]
    offset = [key("d", int(pose)) if offsets and pose >= 0 else None for pose in design.pose]
    groups: dict[tuple[int, int | None], list[int]] = {}
    for i, keys in enumerate(zip(bias, offset, strict=True)):
        groups.setdefault(keys, []).append(i)
    for (own, shared), members in groups.items():
        stacked = np.tile(eye, (len(members), 1))
        blocks = {tool: matrix[members].reshape(len(members) * joints, -1), own: stacked}
        if shared is not None:
            blocks[shared] = stacked
        graph.add(blocks, design.torque[members].ravel(), sigma[members].ravel())
    gripper = GRIPPER_PRIOR_SD if offsets else PRIOR_SD
    prior = np.concatenate([PRIOR_SD, gripper, np.full(matrix.shape[2] - 8, FRICTION_PRIOR_SD)])
    if gain_sd is not None:
        prior[-joints:] = gain_sd
    graph.add_prior(tool, np.zeros(len(prior)), prior)
    graph.add_prior(key("b"), np.zeros(joints), BIAS_PRIOR_SD)
    if walks:
        sigma_step = np.maximum(drift, 1e-9)
        for step in range(1, count):
            graph.add({key("b", step - 1): -eye, key("b", step): eye}, np.zeros(joints), sigma_step)
    for shared in sorted({k for k in offset if k is not None}):
        graph.add_prior(shared, np.zeros(joints), np.clip(pose_sd, 1e-9, FREE))
    return graph, bias, offset, np.array([i for members in groups.values() for i in members])


def _fit(design: Design, solution: Solution, bias: list[int], offset: list[int | None]) -> Fit:
    tool = solution[key("x")][: design.tool.shape[2]]
    nuisance = np.array([solution[k] for k in bias])
    for i, shared in enumerate(offset):
        if shared is not None:
            nuisance[i] += solution[shared]
    return Fit(tool, design.torque - design.tool @ tool - nuisance, solution.root)


def _shared_poses(tare: Array, load: Array) -> NDArray[np.int_]:
    """Return the number of the pose that both visited, or -1, for every reading."""
    q = np.concatenate([tare, load])
    pose = np.full(len(q), -1)
    for index, row in enumerate(tare):
        if pose[index] < 0:
            near = np.abs(q - row).max(axis=1) < SAME_POSE
            if near[len(tare) :].any():
                pose[near] = index
    return pose
