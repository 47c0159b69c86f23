"""The simulated world as MJCF: the one robot description, a table, an object, and what drives the joints.

The settings were found by measurement on MuJoCo 4.0: the ``discrete`` integrator is the one that integrates
soft-body elasticity implicitly; what the object is made of stands in `sim.bodies`.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET

from dynamics.errors import InvalidInput
from dynamics.gripper import ParallelGripper
from models.robot import Revision, gen3_mjcf
from sim.bodies import Fidelity, add_object
from sim.cameras import add_cameras
from sim.contact import OVERDAMPED, RUBBED, TIMESTEP, can_be_rubbed
from sim.engine import add_option
from sim.pads import bevel
from sim.truth import TrueObject

TABLE_SIZE = (1.2, 1.6, 0.04)  # m, full lengths; its top is at z = 0, the arm's mounting face
TABLE_MIDDLE = (0.3, 0.0)  # m, from the arm's base
ARM_GAINS = {"large": (2000.0, 100.0, 105.0), "small": (500.0, 50.0, 52.0)}  # N m/rad, N m s/rad, N m
GRIPPER_STIFFNESS = 1000.0  # N m/rad, of the drive that holds the fingers where they are
GRIPPER_DAMPING = 10.0  # N m s/rad
MAX_GRIP_FORCE = 70.0  # N


def scene_mjcf(
    truth: TrueObject,
    gripper: ParallelGripper,
    revision: Revision = "V12",
    vision: bool = True,
    fidelity: Fidelity = "uniform",
) -> str:
    """Return the MJCF of the robot at its table with an object on it; a compiled model needs `sim.bodies.prepare`.

    Args:
        truth: the object.
        gripper: gives the lever of the grip force.
        revision, vision: which arm.
        fidelity: how the object deforms, see `sim.bodies`.

    Raises:
        InvalidInput: if the object would not stand on the table.
    """
    _check_on_table(truth)
    root = ET.fromstring(gen3_mjcf(revision, vision, "2f85"))
    root.set("model", "palpate")
    add_option(root, TIMESTEP)
    _add_looks(root)
    world = _child(root, "worldbody")
    _add_table(world)
    add_object(root, truth, fidelity, damping_ratio=RUBBED if can_be_rubbed(truth) else OVERDAMPED)
    add_cameras(root, truth.declared.position, vision)
    base = _child(world, "body[@name='base_link']")
    for body in base.iter("body"):
        # The controller knows the weight of arm and gripper; what compensates it counts as the joints' torque.
        body.set("gravcomp", "1")
    for joint in base.iter("joint"):
        if joint.get("name", "").startswith("joint_"):
            joint.set("actuatorgravcomp", "true")
    for name in ("left_pad", "right_pad"):
        pad = _child(base, f".//geom[@name='{name}']")
        pad.set("friction", f"{truth.friction} 0.005 0.0001")
        if can_be_rubbed(truth) and fidelity == "uniform":  # pads that sink in do so over their whole face
            bevel(root, pad)
    _add_drives(root, gripper)
    return ET.tostring(root, encoding="unicode")


def _check_on_table(truth: TrueObject) -> None:
    known = truth.declared
    reach = math.hypot(*truth.size[:2]) / 2
    for place, middle, length in zip(known.position, TABLE_MIDDLE, TABLE_SIZE, strict=False):
        if abs(place - middle) + reach > length / 2:
            (x, _), (a, b, _) = TABLE_MIDDLE, TABLE_SIZE
            valid = f"x {x - a / 2 + reach:.3f} to {x + a / 2 - reach:.3f} m, y within {b / 2 - reach:.3f} m of 0"
            raise InvalidInput(f"{known.source}: position_m", list(known.position), f"on the table: {valid}")


def _add_drives(root: ET.Element, gripper: ParallelGripper) -> None:
    tendons = ET.SubElement(root, "tendon")
    grasp = ET.SubElement(tendons, "fixed", name="grasp")
    for side in ("left", "right"):
        ET.SubElement(grasp, "joint", joint=f"{side}_crank_joint", coef="0.5")
    drives = ET.SubElement(root, "actuator")
    for number in range(1, 8):
        stiffness, damping, limit = ARM_GAINS["large" if number <= 4 else "small"]
        ET.SubElement(
            drives,
            "position",
            name=f"joint_{number}",
            joint=f"joint_{number}",
            kp=repr(stiffness),
            kv=repr(damping),
            forcerange=f"-{limit} {limit}",
        )
    limit = 2 * MAX_GRIP_FORCE * gripper.crank_length
    ET.SubElement(
        drives,
        "position",
        name="grasp",
        tendon="grasp",
        kp=repr(GRIPPER_STIFFNESS),
        kv=repr(GRIPPER_DAMPING),
        forcerange=f"-{limit} {limit}",
    )


def _add_table(world: ET.Element) -> None:
    x, y, z = TABLE_SIZE
    ET.SubElement(
        world,
        "geom",
        name="table",
        type="box",
        size=f"{x / 2} {y / 2} {z / 2}",
        pos=f"{TABLE_MIDDLE[0]} {TABLE_MIDDLE[1]} {-z / 2}",
        rgba="0.62 0.66 0.7 1",
        contype="1",
        conaffinity="7",
    )


def _add_looks(root: ET.Element) -> None:
    visual = ET.SubElement(root, "visual")
    ET.SubElement(visual, "global", offwidth="1280", offheight="960")
    ET.SubElement(visual, "headlight", ambient="0.45 0.45 0.45", diffuse="0.45 0.45 0.45")
    asset = ET.SubElement(root, "asset")
    ET.SubElement(
        asset,
        "texture",
        type="skybox",
        builtin="gradient",
        rgb1="0.96 0.97 0.98",
        rgb2="0.75 0.8 0.86",
        width="64",
        height="384",
    )
    world = _child(root, "worldbody")
    ET.SubElement(world, "light", pos="0.3 -1 2", dir="0.1 0.5 -1", diffuse="0.5 0.5 0.5")


def _child(parent: ET.Element, path: str) -> ET.Element:
    child = parent.find(path)
    assert child is not None, path
    return child
