"""The law of contact with a simulated object, scaled so that it is stiff against the object whatever it weighs.

MuJoCo normalises contact stiffness by mass: k = m / (d (1 - d) (T z)^2) with the impedance d, the time constant T
and the damping ratio z. Left at its defaults, a light and stiff object gives way in the contact more than in
itself.
"""

from __future__ import annotations

import math

from sim.truth import RIGID_ABOVE, TrueObject

TIMESTEP = 0.002  # s
STIFFER = 300.0  # contact stiffness over the object's own
IMPEDANCES = (0.9, 0.9999)  # the least and the most; the last is the largest that MuJoCo allows
OVERDAMPED = 3.0  # damping ratio; at 1, a surface that slides bounces and loses a tenth of its friction


def own_stiffness(truth: TrueObject) -> float:
    """Return the object's stiffness between two large plates, E V / L^2 along its shorter side [N/m].

    For a box this is E A / L; a cylinder, a ball or any other shape has the mean cross-section A = V / L. A body
    stiffer than what is simulated as soft counts as the stiffest of those.
    """
    length = min(truth.size[0], truth.size[1])
    return min(truth.young_modulus, RIGID_ABOVE) * truth.volume / length**2


def contact_law(truth: TrueObject, timestep: float = TIMESTEP) -> tuple[float, float]:
    """Return the contact's time constant [s] and impedance [-] that make it ``STIFFER`` than the object.

    The time constant is the shortest that the integrator can follow, T = 2 time steps, and the damping ratio
    ``OVERDAMPED``, so that d (1 - d) = m / (k (T z)^2). Where that takes an impedance outside of MuJoCo's range,
    the time constant is longer, or the contact too soft.
    """
    stiffness = STIFFER * own_stiffness(truth)
    time_constant = 2 * timestep
    share = truth.mass / (stiffness * (time_constant * OVERDAMPED) ** 2)
    impedance = (1 + math.sqrt(max(1 - 4 * share, 0.0))) / 2
    impedance = min(max(impedance, IMPEDANCES[0]), IMPEDANCES[1])
    wanted = math.sqrt(truth.mass / (stiffness * impedance * (1 - impedance)))  # T z
    return max(wanted / OVERDAMPED, time_constant), impedance


def contact_saturation(truth: TrueObject, timestep: float = TIMESTEP) -> float:
    """Return by how much the stiffest contact falls short of the wanted one, >= 1 where it does.

    For a light and stiff object even the largest impedance is too soft at this time step; scaling the object's
    inverse weight in the contact solver by the inverse of this number restores the ratio.
    """
    time_constant, impedance = contact_law(truth, timestep)
    reached = truth.mass / (impedance * (1 - impedance) * (time_constant * OVERDAMPED) ** 2)
    return STIFFER * own_stiffness(truth) / reached
