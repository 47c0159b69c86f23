"""The cameras of the simulated scene: two that look on, and the one in the arm's vision module."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET

import numpy as np
from numpy.typing import NDArray

from models.robot import COLOUR_CAMERA

Array = NDArray[np.float64]

# Eye and target by how far they lie outward of the object, to its left and over the table [m]: the arm reaches
# towards the cameras, wherever the object stands.
ONLOOKERS = {
    "overview": ((0.75, -1.15, 0.80), (-0.25, -0.05, 0.30)),
    "close": ((0.35, -0.35, 0.20), (0.0, 0.0, 0.06)),
}
WRIST_FIELD = 50.0  # degrees, upright; an assumption of the order of the module's


def add_cameras(root: ET.Element, position: tuple[float, float], vision: bool) -> None:
    """Add ``overview`` and ``close``, and ``wrist`` where there is a vision module, to the MJCF of a scene.

    Args:
        root: the ``mujoco`` element, with the arm.
        position: of the object on the table [m].
        vision: whether the arm has a vision module.
    """
    world = root.find("worldbody")
    assert world is not None
    x, y = position
    distance, side = math.hypot(x, y), math.atan2(y, x)
    turn = np.array([[math.cos(side), -math.sin(side), 0], [math.sin(side), math.cos(side), 0], [0, 0, 1]])
    for name, (eye, target) in ONLOOKERS.items():
        at, to = (turn @ (np.array(point) + np.array([distance, 0.0, 0.0])) for point in (eye, target))
        ET.SubElement(world, "camera", name=name, pos=_text(at), xyaxes=_text(_axes(at, to)))
    flange = world.find(".//body[@name='gripper_base']")
    if vision and flange is not None:
        # A camera of MuJoCo's looks along its -z.
        place = _text(np.array(COLOUR_CAMERA))
        ET.SubElement(flange, "camera", name="wrist", pos=place, quat="0 1 0 0", fovy=repr(WRIST_FIELD))


def _axes(eye: Array, target: Array) -> Array:
    """Return the x axis (right) and the y axis (up) of a camera that looks at a target, (6,)."""
    back = eye - target
    right = np.cross([0.0, 0.0, 1.0], back)
    return np.concatenate([right / np.linalg.norm(right), np.cross(back, right)])


def _text(numbers: Array) -> str:
    return " ".join(repr(float(number)) for number in numbers)
