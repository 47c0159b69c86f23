"""The law of contact with a simulated object, scaled so that it is stiff against the object whatever it weighs.

MuJoCo normalises contact stiffness by mass: k = m / (d (1 - d) (T z)^2) with the impedance d, the time constant T
and the damping ratio z. Left at its defaults, a light and stiff object gives way in the contact more than in
itself.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from sim.truth import RIGID_ABOVE, TrueObject

TIMESTEP = 0.002  # s
STIFFER = 300.0  # contact stiffness over the object's own
IMPEDANCES = (0.9, 0.9999)  # the least and the most; the last is the largest that MuJoCo allows
OVERDAMPED = 3.0  # damping ratio; at 1, a surface that slides bounces and loses a tenth of its friction
RUBBED = 20.0  # of flat sides that pads rub along: at 3 they judder, and lose up to a third of their friction


@dataclass(frozen=True)
class ContactLaw:
    """How hard a contact is.

    Attributes:
        time_constant: T [s].
        damping_ratio: z [-].
        impedance: d [-].
        shortfall: by how much it falls short of the wanted stiffness [-], >= 1. For a light and stiff object even
            the largest impedance is too soft at this time step; scaling the object's inverse weight in the contact
            solver by the inverse of this number restores it.
    """

    time_constant: float
    damping_ratio: float
    impedance: float
    shortfall: float


def own_stiffness(truth: TrueObject) -> float:
    """Return the object's stiffness between two large plates, E V / L^2 along its shorter side [N/m].

    For a box this is E A / L; a cylinder, a ball or any other shape has the mean cross-section A = V / L. A body
    stiffer than what is simulated as soft counts as the stiffest of those.
    """
    length = min(truth.size[0], truth.size[1])
    return min(truth.young_modulus, RIGID_ABOVE) * truth.volume / length**2


def contact_law(truth: TrueObject, timestep: float = TIMESTEP, damping_ratio: float = OVERDAMPED) -> ContactLaw:
    """Return the contact that is ``STIFFER`` than the object.

    The time constant is the shortest that the integrator can follow, T = 2 time steps, so that
    d (1 - d) = m / (k (T z)^2). Where that takes an impedance below MuJoCo's range, the time constant is longer;
    where it takes one above, the contact falls short.
    """
    stiffness = STIFFER * own_stiffness(truth)
    share = truth.mass / (stiffness * (2 * timestep * damping_ratio) ** 2)
    impedance = (1 + math.sqrt(max(1 - 4 * share, 0.0))) / 2
    impedance = min(max(impedance, IMPEDANCES[0]), IMPEDANCES[1])
    wanted = math.sqrt(truth.mass / (stiffness * impedance * (1 - impedance))) / damping_ratio
    time_constant = max(wanted, 2 * timestep)
    return ContactLaw(time_constant, damping_ratio, impedance, max((time_constant / wanted) ** 2, 1.0))


def can_be_rubbed(truth: TrueObject) -> bool:
    """Tell whether an object is soft and has flat sides to rub along.

    Bodies that are touched in many points take no damping of ``RUBBED``: the contact solver no longer converges.
    """
    return truth.shape == "box" and not truth.is_rigid
