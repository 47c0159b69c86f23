"""The bench as MJCF: two driven plates, pads or larger than the object, and an object between them.

There is no gravity and no table, so that nothing but the plates loads the object.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from dataclasses import dataclass

import numpy as np

from dynamics.bench import Plates
from dynamics.gripper import robotiq_2f85
from sim.bodies import Fidelity, add_object
from sim.engine import add_option
from sim.truth import TrueObject

SIDES = ("left", "right")
PLATE_MASS = 0.5  # kg
PLATE_THICKNESS = 0.01  # m
MAX_STRAIN = 0.5  # of the object, at which the plates meet a stop
_MARGIN = 1.5  # size of full plates over the object's largest edge: they stay larger when it bulges


@dataclass(frozen=True)
class Layout:
    """Where the plates are.

    Attributes:
        edge: axis of the object that they close along.
        width: true extent of the object along it [m].
        face: extents of a plate's face across the closing direction and along the vertical [m].
        start: distance of a plate's face from the middle where the plates begin [m].
        above: height of the plates' middle over the object's [m].
    """

    edge: int
    width: float
    face: tuple[float, float]
    start: float
    above: float = 0.0


def layout_of(truth: TrueObject, plates: Plates, edge: int, gap: float, above: float = 0.0) -> Layout:
    """Return the layout for an object.

    Args:
        truth: the object.
        plates: ``pads`` of the 2F-85's size, or ``full`` ones that cover every face.
        edge: axis to close along.
        gap: from a plate to the object at the start [m].
        above: height of the plates' middle over the object's [m].
    """
    if plates == "pads":
        gripper = robotiq_2f85()
        face = (gripper.pad_width, gripper.pad_length)
    else:
        face = (_MARGIN * max(truth.size),) * 2
    return Layout(edge, truth.size[edge], face, truth.size[edge] / 2 + gap, above)


def bench_mjcf(
    truth: TrueObject, layout: Layout, fidelity: Fidelity, timestep: float, factor: float | None = None
) -> str:
    """Return the MJCF of the bench; a compiled model needs `sim.bodies.prepare`.

    Its sensors are the contact forces on the left and the right plate, each ``found, fx, fy, fz`` in the world's
    axes [N]. Its actuators are position drives, whose gains are to be set.
    """
    root = ET.Element("mujoco", model="bench")
    ET.SubElement(root, "compiler", angle="radian")
    # Where flat faces meet in single points, Newton's method may stop at wrong forces; conjugate gradients do not.
    solver = {"solver": "CG", "iterations": "1000", "tolerance": "1e-10"} if truth.shape == "mesh" else {}
    add_option(root, timestep, gravity="0 0 0", **solver)
    visual = ET.SubElement(root, "visual")
    ET.SubElement(visual, "global", offwidth="1280", offheight="960")
    world = ET.SubElement(root, "worldbody")
    ET.SubElement(world, "light", pos="0.3 -1 2", dir="0.1 0.5 -1", diffuse="0.5 0.5 0.5")
    ET.SubElement(world, "camera", name="overview", pos="0.22 -0.12 0.12", xyaxes="0.5 0.87 0 -0.35 0.2 0.91")
    add_object(root, truth, fidelity, np.eye(4), timestep, factor)
    drives = ET.SubElement(root, "actuator")
    sensors = ET.SubElement(root, "sensor")
    for side, sign in zip(SIDES, (1.0, -1.0), strict=True):
        world.append(_plate(layout, side, sign, timestep))
        ET.SubElement(drives, "position", name=side, joint=side, kp="1", kv="1")
        ET.SubElement(sensors, "contact", geom1=side, data="found force", reduce="netforce")
    return ET.tostring(root, encoding="unicode")


def _plate(layout: Layout, side: str, sign: float, timestep: float) -> ET.Element:
    """Return a plate that slides towards the middle from one side."""
    vertical = 2 if layout.edge != 2 else 1
    half = [layout.face[0] / 2] * 3
    half[layout.edge] = PLATE_THICKNESS / 2
    half[vertical] = layout.face[1] / 2
    place, towards = [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]
    place[layout.edge] = sign * (layout.start + PLATE_THICKNESS / 2)
    place[vertical] += layout.above
    towards[layout.edge] = -sign
    plate = ET.Element("body", name=side, pos=_text(place))
    inertia = PLATE_MASS * max(layout.face) ** 2 / 12
    ET.SubElement(plate, "inertial", pos="0 0 0", mass=repr(PLATE_MASS), diaginertia=_text([inertia] * 3))
    stop = layout.start - (1 - MAX_STRAIN) * layout.width / 2
    ET.SubElement(
        plate,
        "joint",
        name=side,
        type="slide",
        axis=_text(towards),
        range=_text([-1.0, stop]),
        limited="true",
        solreflimit=f"{2 * timestep} 1",
        solimplimit="0.99 0.99 0.001",
    )
    # Plates meet the object alone, not each other.
    ET.SubElement(
        plate,
        "geom",
        name=side,
        type="box",
        size=_text(half),
        contype="2",
        conaffinity="1",
        rgba="0.4 0.45 0.5 0.6",
    )
    return plate


def damping_of(stiffness: float) -> float:
    """Return the damping with which a drive of a stiffness moves a plate without overshoot [N s/m]."""
    return 2 * math.sqrt(stiffness * PLATE_MASS)


def _text(numbers: list[float]) -> str:
    return " ".join(map(repr, numbers))
