"""The density of a reading of an uncertain quantity at any values, for drawing; planning has its own."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from estimation.mixture import Mixture

Array = NDArray[np.float64]

REACH = 7.0  # standard deviations
FINEST = 0.06  # step of a hypothesis' nodes in its coordinate, at most
LOCAL = np.linspace(-REACH, REACH, 113)
NARROW = 0.15  # relative noise up to which nodes around the reading reach all that matters


def reading_density(part: Mixture, z: Array, sd: float) -> Array:
    """Return p(z) for z = x + N(0, sd^2) with x of a mixture [1/unit], (N,).

    On the log scale, x = exp t, it is the integral of N(t; mean, spread^2) N(z; exp t, sd^2) over t: by nodes
    around ln z where the noise in t, sd / z, is the narrower of the two factors, else around the mean.

    Args:
        part: of the quantity; its weights need not sum to one.
        z: readings [unit], (N,).
        sd: of the noise [unit].
    """
    if part.scale != "log":
        return np.asarray(replace(part, sds=np.hypot(part.sds, sd)).density(z))
    noise = np.full(len(z), math.inf)
    noise[z > 0] = sd / z[z > 0]
    found = np.zeros(len(z))
    rows = zip(part.weights.tolist(), part.means.tolist(), part.sds.tolist(), strict=True)
    for weight, mean, spread in rows:
        local = noise <= min(0.5 * spread, NARROW)
        found[local] += weight * _around_reading(mean, spread, z[local], sd)
        found[~local] += weight * _around_mean(mean, spread, z[~local], sd)
    return found


def _around_reading(mean: float, spread: float, z: Array, sd: float) -> Array:
    noise = (sd / z)[:, None]
    t = np.log(z)[:, None] + noise * LOCAL
    values = _normal(t, mean, spread) * _normal(z[:, None], np.exp(t), sd) * noise
    return np.asarray(values.sum(axis=1) * (LOCAL[1] - LOCAL[0]))


def _around_mean(mean: float, spread: float, z: Array, sd: float) -> Array:
    step = min(0.1, FINEST / spread)
    nodes = np.linspace(-REACH, REACH, 2 * math.ceil(REACH / step) + 1)
    weights = _normal(nodes, 0.0, 1.0) * (nodes[1] - nodes[0])
    x = np.exp(np.minimum(mean + spread * nodes, 300.0))
    return np.asarray(_normal(z[:, None], x, sd) @ weights)


def _normal(x: Array, mean: Array | float, sd: float) -> Array:
    scaled = (x - mean) / sd
    return np.asarray(np.exp(-0.5 * scaled * scaled) / (sd * math.sqrt(2 * math.pi)))
