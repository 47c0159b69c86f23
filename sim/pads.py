"""The shape of the pads where they rub along a soft body: their upper and lower edges are bevelled.

A sharp edge that slides over a corner of a triangle of the body's surface catches it: for as long as the two
overlap by less than the pad is pressed in, the shortest way out, and so the force of contact, is along the pad.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from itertools import product

LENGTH, DEPTH = 0.002, 0.0002  # m of a bevel, along the pad and into it
MESH = "pad"


def bevel(root: ET.Element, pad: ET.Element) -> None:
    """Bevel a pad of an MJCF, a box that closes along y and stands along z.

    Args:
        root: the ``mujoco`` element, with an ``asset``; pads of one size share a mesh.
        pad: the geom.
    """
    asset = root.find("asset")
    assert asset is not None
    width, thickness, height = (float(half) for half in pad.attrib.pop("size").split())
    if asset.find(f"mesh[@name='{MESH}']") is None:
        outline = ((thickness, height - LENGTH), (thickness - DEPTH, height))
        signs = product((-1, 1), repeat=3)
        corners = [(x * width, y * thick, z * high) for x, y, z in signs for thick, high in outline]
        ET.SubElement(asset, "mesh", name=MESH, vertex=" ".join(repr(x) for corner in corners for x in corner))
    pad.set("type", "mesh")
    pad.set("mesh", MESH)
