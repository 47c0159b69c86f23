"""The shape of the pads: slabs whose upper and lower edges are bevelled, as those of a real gripper are.

A sharp edge that passes a corner of an object's surface catches it: for as long as the edge overlaps the surface by
less than it is pressed in, the shortest way out is along the pad, and so is the force.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Sequence

LENGTH, DEPTH = 0.002, 0.0002  # m of a bevel, along the pad and into it
MESH = "pad"


def bevel(root: ET.Element, geom: ET.Element, half: Sequence[float], closing: int, along: int) -> None:
    """Turn a box of an MJCF into a pad.

    Args:
        root: the ``mujoco`` element; several pads of one shape share a mesh.
        geom: the box.
        half: its half lengths [m], (3,).
        closing, along: axes of the geom, that pads close along and that runs between the bevelled edges.
    """
    asset = root.find("asset")
    if asset is None:
        asset = ET.SubElement(root, "asset")
    if asset.find(f"mesh[@name='{MESH}']") is None:
        vertices = " ".join(repr(x) for corner in _corners(half, closing, along) for x in corner)
        ET.SubElement(asset, "mesh", name=MESH, vertex=vertices)
    geom.attrib.pop("size", None)
    geom.set("type", "mesh")
    geom.set("mesh", MESH)


def _corners(half: Sequence[float], closing: int, along: int) -> list[list[float]]:
    thick, long = half[closing], half[along]
    outline = [(thick, long - LENGTH), (thick - DEPTH, long)]
    across = 3 - closing - along
    corners = []
    for x in (-1, 1):
        for y in (-1, 1):
            for z in (-1, 1):
                for depth, height in outline:
                    corner = [0.0, 0.0, 0.0]
                    corner[across], corner[closing], corner[along] = x * half[across], y * depth, z * height
                    corners.append(corner)
    return corners
