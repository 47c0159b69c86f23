"""How far the simulated gripper gives way: a rigid cylinder squeezed by it, ``python -m sim.rigid_block``.

Drive, linkage and pads of the simulated fingers are stiff, not rigid. What the opening changes by per force on a
cylinder that does not give way is their stiffness in series with any object, as on a real gripper. A cylinder, and
not a block with flat faces: those would hold the pads upright, which an object that gives way does not.
"""

from __future__ import annotations

import math
import sys
import xml.etree.ElementTree as ET

import mujoco
import numpy as np

from dynamics.arm import Arm
from dynamics.gripper import ParallelGripper, robotiq_2f85
from dynamics.kinematics import solve_pose, tool_down
from dynamics.objects import DeclaredObject
from sim.bodies import NAME
from sim.contact import TIMESTEP
from sim.scene import scene_mjcf
from sim.truth import TrueObject

PLACE = (0.45, 0.0)  # m
FORCES = (5.0, 15.0, 25.0, 35.0, 45.0)  # N of a pad
HEIGHT = 0.1  # m of the block's axis over the table
HALF_LENGTH = 0.02  # m of the block, across the pads
PRESET = 2e-4  # m that the pads are off the block at first
SETTLE = 0.5  # s
_ELBOW_UP = np.radians([0.0, 20.0, 180.0, -110.0, 0.0, -50.0, 90.0])


def squeeze_rigid_block(width: float = 0.056) -> tuple[float, float]:
    """Return the stiffness of the simulated gripper and its standard deviation [N/m].

    The gripper closes on a block fixed in the world until the pads press with a few forces, and stands; the slope
    of force over opening, by least squares, with the scatter's standard deviation.

    Args:
        width: of the block [m].
    """
    gripper = robotiq_2f85()
    declared = DeclaredObject("block", "box", (width,) * 3, 1e-3, PLACE, 0.0)
    stand_in = TrueObject(declared, (width,) * 3, 0.1, 1e9, 0.0, 0.8, 0.002, "rigid")
    model = mujoco.MjModel.from_xml_string(_with_rigid_block(scene_mjcf(stand_in, gripper), width))
    data = mujoco.MjData(model)
    arm = Arm.gen3()
    depth = gripper.pad_depth(width) - gripper.tool_depth
    stance = solve_pose(arm, tool_down((*PLACE, HEIGHT + depth), 0.0), _ELBOW_UP)
    opened = gripper.crank_angle(gripper.max_opening)
    near = opened - gripper.crank_angle(width + PRESET)
    data.qpos[: arm.nv] = stance
    for name in ("left_crank_joint", "right_crank_joint", "left_pad_joint", "right_pad_joint"):
        data.qpos[model.joint(name).qposadr[0]] = near
    openings, forces = [], []
    command = near
    for wanted in FORCES:
        force = 0.0
        while force < wanted:
            command += 2e-4
            data.ctrl[: arm.nv], data.ctrl[arm.nv] = stance, command
            for _ in range(round(0.02 / TIMESTEP)):
                mujoco.mj_step(model, data)
            force = gripper.pad_force(float(data.actuator_force[arm.nv]), _opening(model, data, gripper))
        for _ in range(round(SETTLE / TIMESTEP)):
            mujoco.mj_step(model, data)
        opening = _opening(model, data, gripper)
        openings.append(opening)
        forces.append(gripper.pad_force(float(data.actuator_force[arm.nv]), opening))
    # Both are exact but for the linkage's small lack of linearity, so the compliance's scatter is its error.
    (compliance, _), covariance = np.polyfit(forces, openings, 1, cov=True)
    stiffness = -1 / float(compliance)
    return stiffness, math.sqrt(float(covariance[0, 0])) * stiffness**2


def _opening(model: mujoco.MjModel, data: mujoco.MjData, gripper: ParallelGripper) -> float:
    """Return the distance of the pads as the cranks tell it [m]."""
    opened = gripper.crank_angle(gripper.max_opening)
    cranks = [float(data.qpos[model.joint(f"{side}_crank_joint").qposadr[0]]) for side in ("left", "right")]
    return sum(gripper.opening(opened - crank) / 2 for crank in cranks)


def _with_rigid_block(mjcf: str, width: float) -> str:
    """Return the scene with a block that is part of the world in place of the object."""
    root = ET.fromstring(mjcf)
    world = root.find("worldbody")
    assert world is not None
    stand_in = world.find(f"body[@name='{NAME}']")
    assert stand_in is not None
    world.remove(stand_in)
    ET.SubElement(
        world,
        "geom",
        name="rigid_block",
        type="cylinder",
        size=f"{width / 2} {HALF_LENGTH}",
        pos=f"{PLACE[0]} {PLACE[1]} {HEIGHT}",
        quat="0.7071067811865476 0 0.7071067811865476 0",
        solref=f"{2 * TIMESTEP} 1",
        solimp="0.9999 0.9999 0.001",
        priority="2",
        contype="1",
        conaffinity="7",
    )
    return ET.tostring(root, encoding="unicode")


def main() -> int:
    """Print the stiffness."""
    stiffness, sd = squeeze_rigid_block()
    sys.stdout.write(f"stiffness of the simulated gripper: {stiffness:.4g} +- {sd:.2g} N/m\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
