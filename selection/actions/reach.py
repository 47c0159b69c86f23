"""How a hand takes hold of an object: which way the pads close on it, how high above the table, and from where."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from dynamics.arm import Arm
from dynamics.collision import Box, Workspace, shifted
from dynamics.errors import InvalidInput, MotionRefused
from dynamics.gripper import ParallelGripper
from dynamics.kinematics import solve_pose, straight_joints, straight_line, tool_down
from dynamics.objects import DeclaredObject

Array = NDArray[np.float64]

TABLE = Box("table", (1.6, 1.6, 0.04), shifted(0.0, 0.0, -0.02))
GATE_HEIGHT = 0.16  # m of the pads over the object's top where every approach begins
OPENING_MARGIN = 0.004  # m that the gripper must open beyond the object
TOP_CLEARANCE = 0.002  # m between the object and the cranks above it
PAD_CLEARANCE = 0.004  # m between the fingertips and the table
_STEP = 0.001  # m of height between two that are tried
_EDGE = 0.003  # m from the pads' ends within which a round object is not taken hold of
_ROUND_TURNS = tuple(k * math.pi / 4 for k in (0, 4, 2, -2, 1, -1, 3, -3))


def closing_edge(gripper: ParallelGripper, declared: DeclaredObject) -> tuple[int, tuple[float, ...]]:
    """Return which horizontal length the pads close on, and the turns of the tool that do so [rad].

    Raises:
        InvalidInput: if the gripper does not open wide enough for either.
    """
    limit = gripper.max_opening - OPENING_MARGIN
    fitting = [edge for edge in (1, 0) if declared.size[edge] + 2 * declared.size_sd <= limit]
    if not fitting:
        raise InvalidInput(
            f"{declared.source}: size_m",
            list(declared.size),
            f"a width or depth of at most {limit - 2 * declared.size_sd:.4f} m: the gripper opens "
            f"{gripper.max_opening} m",
        )
    if declared.shape in ("cylinder", "sphere"):
        return 1, _ROUND_TURNS
    edge = min(fitting, key=lambda e: declared.size[e])
    return edge, (0.0, math.pi, -math.pi) if edge == 1 else (math.pi / 2, -math.pi / 2)


def grasp_height(gripper: ParallelGripper, declared: DeclaredObject, edge: int) -> float:
    """Return the height of the pads' centre over the table to grasp at [m].

    The middle of the object, but not so low that the fingertips touch the table, nor that what rises above the
    pads gets between the cranks, which come together upward.

    Raises:
        InvalidInput: if pads at that height would close on a round object above its widest place, and press it
            out of the hand.
    """
    height, width = declared.size[2], declared.size[edge]
    lowest = max(height / 2, gripper.pad_length / 2 + PAD_CLEARANCE)
    highest = max(lowest, height - gripper.pad_height + TOP_CLEARANCE)
    half_width = _profile(declared, edge)
    reach = gripper.crank_length * math.cos(gripper.crank_angle(width))
    levels = np.linspace(0.0, height, 101)
    wide = np.array([half_width(z) for z in levels])
    for grasp in np.append(np.arange(lowest, highest, _STEP), highest):
        above = levels - (grasp + gripper.pad_height - TOP_CLEARANCE)
        gap = np.maximum(width / 2 * (1 - above / reach), 0.0)
        if np.all((above <= 1e-9) | (wide <= gap)):
            break
    widest = height / 2
    if declared.shape in ("sphere", "ellipsoid") and grasp - widest > gripper.pad_length / 2 - _EDGE:
        raise InvalidInput(
            f"{declared.source}: size_m",
            list(declared.size),
            f"a height whose middle the pads reach: they close {grasp - widest:.3f} m above the widest place",
        )
    return float(grasp)


def free_space(arm: Arm, declared: DeclaredObject, rest: Array) -> Workspace:
    """Return what an empty hand must not touch, table and object, from joint positions known to be free."""
    return Workspace(arm, (TABLE, declared.box()), rest)


def find_grasp(
    gripper: ParallelGripper, space: Workspace, declared: DeclaredObject, rest: Array
) -> tuple[Array, Array]:
    """Return the tool's pose of the grasp, (4, 4), and the joint positions of the gate above it [rad], (nv,).

    Of the ways to close on the object, the one whose gate is nearest; both paths to it are free.

    Args:
        gripper: closes on it.
        space: the arm among table and object.
        declared: the object.
        rest: joint positions from which the arm comes [rad], (nv,).

    Raises:
        InvalidInput: if the object is too large for the gripper, or stands where the arm cannot take hold of it.
    """
    edge, turns = closing_edge(gripper, declared)
    depth = gripper.pad_depth(declared.size[edge]) - gripper.tool_depth
    height = grasp_height(gripper, declared, edge) + depth
    best: tuple[float, Array, Array] | None = None
    problem: MotionRefused | None = None
    for turn in turns:
        grasp = tool_down((*declared.position, height), declared.yaw + turn)
        above = grasp.copy()
        above[2, 3] = declared.size[2] + GATE_HEIGHT + depth
        try:
            gate = solve_pose(space.arm, above, rest)
            space.check(straight_joints(rest, gate))
            space.check(straight_line(space.arm, gate, grasp))
        except MotionRefused as error:
            problem = error
            continue
        cost = float(np.abs(gate - rest).sum())
        if best is None or cost < best[0]:
            best = (cost, grasp, gate)
    if best is None:
        raise InvalidInput(
            f"{declared.source}: position_m",
            list(declared.position),
            f"a place that the arm can reach and grasp at ({problem})",
        )
    return best[1], best[2]


def _profile(declared: DeclaredObject, edge: int) -> Callable[[float], float]:
    """Return the object's half width along the closing direction, over the height above the table."""
    half, middle = declared.size[edge] / 2, declared.size[2] / 2
    if declared.shape in ("sphere", "ellipsoid"):
        return lambda z: half * math.sqrt(max(1 - ((z - middle) / middle) ** 2, 0.0))
    return lambda z: half
