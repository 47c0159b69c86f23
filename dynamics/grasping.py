"""Where a parallel gripper from above takes hold of an object: how high above the table its pads close."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from dynamics.errors import InvalidInput
from dynamics.gripper import ParallelGripper
from dynamics.objects import DeclaredObject

TOP_CLEARANCE = 0.002  # m between the object and the cranks above it
PAD_CLEARANCE = 0.004  # m between the fingertips and the table
_STEP = 0.001  # m of height between two that are tried
_EDGE = 0.003  # m from the pads' ends within which a round object is not taken hold of


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


def _profile(declared: DeclaredObject, edge: int) -> Callable[[float], float]:
    """Return the object's half width along the closing direction, over the height above the table."""
    half, middle = declared.size[edge] / 2, declared.size[2] / 2
    if declared.shape in ("sphere", "ellipsoid"):
        return lambda z: half * math.sqrt(max(1 - ((z - middle) / middle) ** 2, 0.0))
    return lambda z: half
