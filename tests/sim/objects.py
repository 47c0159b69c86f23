"""True objects for the tests of the simulator."""

import numpy as np

from dynamics.mesh import Mesh
from dynamics.objects import DeclaredObject
from models.rounded_block import rounded_block
from sim.truth import TrueObject

EDGE = 0.056  # m
CORNERS = [(5e3, 0.004), (5e3, 1.0), (1e6, 0.004), (1e6, 1.0)]  # Pa, kg
SIZES = {
    "box": (0.05, 0.06, 0.07),
    "cylinder": (0.06, 0.06, 0.08),
    "sphere": (0.06, 0.06, 0.06),
    "ellipsoid": (0.08, 0.06, 0.05),
    "mesh": (0.08, 0.056, 0.036),
}


def block(young=5e4, mass=0.1, size=(EDGE,) * 3, yaw=0.0, position=(0.42, 0.0), friction=0.8):
    return thing("box", young, mass, size, yaw, position, friction)


def thing(
    shape,
    young=5e4,
    mass=0.1,
    size=None,
    yaw=0.0,
    position=(0.42, 0.0),
    friction=0.8,
    poisson=0.0,
    yield_strain=0.0,
):
    size = size or SIZES[shape]
    mesh = soap(size) if shape == "mesh" else None
    declared = DeclaredObject("block", shape, size, 0.0005, position, yaw, mesh=mesh)
    return TrueObject(declared, size, mass, young, poisson, friction, 0.002, "foam", yield_strain=yield_strain)


def soap(size, steps=6):
    """Return the mesh of a rounded block."""
    corners = np.array(rounded_block(size, steps)).reshape(-1, 3)
    points, which = np.unique(np.round(corners, 12), axis=0, return_inverse=True)
    return Mesh(points, which.reshape(-1, 3))
