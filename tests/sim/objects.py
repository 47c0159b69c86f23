"""True objects for the tests of the simulator."""

from dynamics.objects import DeclaredObject
from sim.truth import TrueObject

EDGE = 0.056  # m
CORNERS = [(5e3, 0.004), (5e3, 1.0), (1e6, 0.004), (1e6, 1.0)]  # Pa, kg


def block(young=5e4, mass=0.1, size=(EDGE,) * 3, yaw=0.0, position=(0.42, 0.0), friction=0.8):
    declared = DeclaredObject("block", "box", size, 0.0005, position, yaw)
    return TrueObject(declared, size, mass, young, 0.0, friction, 0.002, "foam")
