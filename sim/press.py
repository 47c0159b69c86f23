"""Press a simulated object between pads on the bench: what its few cells make of its modulus.

The factor of an object is the modulus that its squeeze shows, by the theory of `dynamics.compression` for pads,
over the one it was given:

    F(e) ~ factor E A h(e - e0),

fitted over strains up to ``DEPTH`` with a free onset e0, as a squeeze of the hand is read.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from dynamics.bench import Stroke
from dynamics.compression import geometry_of
from dynamics.gripper import robotiq_2f85
from sim.bench import Bench
from sim.truth import TrueObject

DEPTH = 0.10  # strain
SPEED = 0.02  # m/s of closing, both pads together
YOUNG, MASS = 5e4, 0.1  # Pa, kg; the factor is that of all of them
_ONSETS = np.linspace(-0.01, 0.03, 81)


def press(truth: TrueObject, axis: int) -> float:
    """Return the factor of an object's modulus in the fidelity ``indentation`` without calibration [-].

    Args:
        truth: the object; its modulus and mass do not matter.
        axis: that the pads close along, 0 or 1.

    Raises:
        BenchError: if the physics engine warned.
    """
    sample = replace(truth, young_modulus=YOUNG, mass=MASS, yield_strain=0.0)
    bench = Bench(sample, "pads", fidelity="indentation", edge=axis, factor=1.0)
    pressed = bench.press(Stroke(SPEED, (1 - DEPTH) * bench.width, dwell=0.0))
    loading = pressed.rows("compress")
    strain, force = 1 - pressed.opening[loading] / bench.width, pressed.force[loading]
    touching = strain > 0
    strain, force = strain[touching], force[touching]
    geometry = geometry_of(
        truth.shape,
        (bench.width, truth.size[1 - axis], truth.size[2]),
        robotiq_2f85("pad"),
        poisson=truth.poisson,
        fill=truth.declared.fill,
    )
    fits = []
    for onset in _ONSETS:
        law = YOUNG * geometry.area * geometry.law_of(strain - onset)
        factor = float(law @ force / (law @ law))
        fits.append((float(np.sum((force - factor * law) ** 2)), factor))
    return min(fits)[1]
