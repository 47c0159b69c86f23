"""A curve whose strain has errors as well: where the opening was renewed late, each strain is a guess of its own.

    minimise  sum_i (stress_i - f(x_i))^2 / sd_stress^2 + (strain_i - x_i)^2 / sd_strain^2

over the curve f and the true strains x (orthogonal distance regression, Boggs and Rogers, 1990), with sd_strain
such that the residuals in contact are as large as it says. Regressing on the strain as read would flatten the slope.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from estimation.stiffness_fit import ONSET, Fit, Prior, Readings, refine

Array = NDArray[np.float64]

ROUNDS = 12
START_SD = 0.02  # of the strain


def refine_with_strain(readings: Readings, start: Array, prior: Prior) -> tuple[Readings, Fit, float]:
    """Return the readings with their true strains and full noise, the curve, and the strain's standard deviation.

    Args:
        readings: with the noise of the stress alone.
        start: parameters to start at, (5 + k,).
        prior: of the parameters.
    """
    sd_strain, x = START_SD, readings.true_strain
    free = int((prior.sd > 0).sum())
    fit, both = None, readings
    for _ in range(ROUNDS):
        slope = -both.predict(start)[1][:, ONSET]
        both = replace(readings, sd=np.hypot(readings.sd, slope * sd_strain), true_strain=x)
        fit = refine(both, start, prior, scale_known=True)
        start = fit.parameters
        predicted, jacobian = both.predict(start)
        slope, residual = -jacobian[:, ONSET], readings.stress - predicted
        touching = (slope > 0) * fit.weights
        excess = float(np.sum(touching * (residual / both.sd) ** 2)) / max(float(touching.sum()) - free + 1, 1.0)
        sd_strain = float(np.clip(sd_strain * math.sqrt(excess), 1e-4, 0.1))
        # The foot of each reading on its tangent.
        x = readings.strain + slope * sd_strain**2 * residual / (readings.sd**2 + (slope * sd_strain) ** 2)
    assert fit is not None  # there is at least one round
    return both, fit, sd_strain
