"""How a hand takes hold of an object: which way the pads close on it, how high above the table, and from where."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from dynamics.arm import Arm
from dynamics.collision import Box, Workspace, shifted
from dynamics.errors import InvalidInput, MotionRefused
from dynamics.grasping import grasp_height
from dynamics.gripper import ParallelGripper
from dynamics.kinematics import solve_pose, straight_joints, straight_line, tool_down
from dynamics.objects import DeclaredObject

Array = NDArray[np.float64]

TABLE = Box("table", (1.6, 1.6, 0.04), shifted(0.0, 0.0, -0.02))
GATE_HEIGHT = 0.16  # m of the pads over the object's top where every approach begins
OPENING_MARGIN = 0.004  # m that the gripper must open beyond the object
_DIAGONAL_TURNS = tuple(k * math.pi / 4 for k in (1, -1, 3, -3))
_ROUND_TURNS = (0.0, math.pi, math.pi / 2, -math.pi / 2, *_DIAGONAL_TURNS)


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
        if best is not None and turn in _DIAGONAL_TURNS:
            break  # simulated round bodies are calibrated along their own axes
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
