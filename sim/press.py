"""Press a simulated object between pads on the bench: what its few cells make of its modulus.

The factor of an object is the modulus that its squeeze shows, by the theory of `dynamics.compression` for pads,
over the one it was given:

    F(e) ~ factor E A h(e - e0),

fitted over a range of strains with a free onset e0, as a squeeze of the hand is read.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from dynamics.bench import Stroke
from dynamics.compression import LARGEST, Geometry, geometry_of
from dynamics.gripper import robotiq_2f85
from sim.bench import Bench
from sim.truth import TrueObject

Array = NDArray[np.float64]

DEEPEST = 0.32  # strain to which objects are pressed
SPEED = 0.02  # m/s of closing, both pads together
YOUNG, MASS = 5e4, 0.1  # Pa, kg; the factor is that of all of them
_ONSETS = 401  # tried
_EARLIEST, _LATEST = -0.2, 0.5  # share of the largest strain: earlier ones would take any law for a straight line
_LEAST_READINGS = 8


@dataclass(frozen=True)
class Pressing:
    """What an object without calibration showed.

    Attributes:
        strain: compression over the free width [-], (N,), rising.
        load: force over its modulus [m^2], (N,).
        geometry: of object and pads, by theory.
    """

    strain: Array
    load: Array
    geometry: Geometry

    def factor(self, low: float, high: float) -> float:
        """Return the factor that a fit over a range of strains shows [-]."""
        inside = (self.strain > low) & (self.strain <= high)
        if int(inside.sum()) < _LEAST_READINGS:
            inside = np.zeros(len(self.strain), dtype=np.bool_)
            inside[np.flatnonzero(self.strain > low)[:_LEAST_READINGS]] = True
        strain, load = self.strain[inside], self.load[inside]
        onsets = high * np.linspace(_EARLIEST, _LATEST, _ONSETS)
        laws = self.geometry.area * self.geometry.law_of(strain - onsets[:, None])
        factors = laws @ load / np.maximum(np.einsum("ij,ij->i", laws, laws), 1e-300)
        errors = np.sum((load - factors[:, None] * laws) ** 2, axis=1)
        return float(factors[int(np.argmin(errors))])


def press(truth: TrueObject, axis: int, above: float = 0.0) -> Pressing:
    """Press an object in the fidelity ``indentation`` without calibration.

    Args:
        truth: the object; its modulus and mass do not matter.
        axis: that the pads close along, 0 or 1.
        above: height of the pads' middle over the object's [m].

    Raises:
        BenchError: if the physics engine warned.
    """
    sample = replace(truth, young_modulus=YOUNG, mass=MASS, yield_strain=0.0)
    bench = Bench(sample, "pads", fidelity="indentation", edge=axis, factor=1.0, above=above)
    pressed = bench.press(Stroke(SPEED, (1 - DEEPEST) * bench.width, dwell=0.0))
    loading = pressed.rows("compress")
    strain, force = 1 - pressed.opening[loading] / bench.width, pressed.force[loading]
    return Pressing(strain, force / YOUNG, under_pads(truth, axis))


def under_pads(truth: TrueObject, axis: int) -> Geometry:
    """Return the geometry of an object under the pads of the 2F-85, however wide it is."""
    return geometry_of(
        truth.shape,
        (truth.size[axis], truth.size[1 - axis], truth.size[2]),
        replace(robotiq_2f85("pad"), max_opening=LARGEST),
        poisson=truth.poisson,
        fill=truth.declared.fill,
    )
