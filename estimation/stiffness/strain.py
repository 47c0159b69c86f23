"""A curve whose strain has errors as well: where the opening was renewed late, each strain is a guess of its own.

    minimise  sum_i (stress_i - f(x_i))^2 / sd_stress^2 + (strain_i - x_i)^2 / sd_strain^2

over the curve f and the true strains x (orthogonal distance regression, Boggs and Rogers, 1990), with sd_strain
such that the residuals in contact are as large as it says. Regressing on the strain as read would flatten the
slope.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from estimation.stiffness.fit import ONSET, Fit, Prior, Readings, refine

Array = NDArray[np.float64]

ROUNDS = 12
START_SD = 0.02  # of the strain
SD_RANGE = (1e-4, 0.1)


def refine_with_strain(readings: Readings, start: Array, prior: Prior) -> tuple[Readings, Fit]:
    """Return the readings with their true strains and the strain's standard deviation, and the curve.

    Args:
        readings: with the noise of the stress alone.
        start: parameters to start at, (5 + k,).
        prior: of the parameters.
    """
    # An opening that is renewed late is wrong by a part of what it moves between renewals.
    jump = math.sqrt(float(np.mean(np.diff(readings.strain) ** 2)))
    least = max(jump / math.sqrt(12.0), SD_RANGE[0])
    readings = replace(readings, strain_sd=max(START_SD, least))
    fit = refine(readings, start, prior, scale_known=True)
    free = int((prior.sd > 0).sum())
    for _ in range(ROUNDS):
        predicted, jacobian = readings.predict(fit.parameters)
        slope, residual = -jacobian[:, ONSET], readings.stress - predicted
        touching = (slope > 0) * fit.weights
        scaled = residual / readings.noise(jacobian, 1.0)
        excess = float(np.sum(touching * scaled**2)) / max(float(touching.sum()) - free + 1, 1.0)
        sd = float(np.clip(readings.strain_sd * math.sqrt(excess), least, max(SD_RANGE[1], least)))
        # The foot of each reading on its tangent.
        foot = readings.strain + slope * sd**2 * residual / (readings.sd**2 + (slope * sd) ** 2)
        readings = replace(readings, true_strain=foot, strain_sd=sd)
        fit = refine(readings, fit.parameters, prior, scale_known=True)
    return readings, fit
