"""The settings of the physics engine that every scene with a soft object shares."""

from __future__ import annotations

import xml.etree.ElementTree as ET


def add_option(root: ET.Element, timestep: float, **more: str) -> None:
    """Add the engine's settings to a scene: the one integrator and cone that hold soft objects without creep.

    Args:
        root: of the MJCF.
        timestep: of the simulation [s].
        more: further attributes of MuJoCo's ``option``.
    """
    option = ET.SubElement(
        root,
        "option",
        timestep=repr(timestep),
        integrator="discrete",
        solver="Newton",
        cone="elliptic",
        impratio="50",
        tolerance="1e-8",
    )
    for name, value in more.items():
        option.set(name, value)
