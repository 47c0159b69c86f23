"""Densities of noisy readings of log-normal quantities, for many hypotheses at once."""

from __future__ import annotations

import math

import numpy as np

from estimation.conditioning import exponential_density

_REACH = 6.5
_LOCAL = np.arange(-7.0, 7.5)
_PROPORTIONAL = 0.15  # beyond it a reading near zero may come from any value, however large


def log_columns(
    mean: np.ndarray, variance: np.ndarray, z: np.ndarray, sd: float, relative_sd: float
) -> np.ndarray:
    """Return p(z | u) for z = exp(t) + N(0, sd^2 + (relative_sd exp t)^2), t ~ N(mean_u, variance_u).

    The integral over t, by trapezoid rules: where the noise in t is narrow against every hypothesis, over the
    noise on nodes around ln z that all hypotheses share; elsewhere one integral per reading and hypothesis.

    Args:
        mean: shape (U,).
        variance: shape (U,), > 0.
        z: readings, shape (N,).
        sd: constant part of the noise.
        relative_sd: proportional part of the noise.

    Returns:
        Densities, shape (N, U).
    """
    width = np.sqrt(variance)
    noise = np.full(len(z), np.inf)
    positive = z > 0
    noise[positive] = np.hypot(sd, relative_sd * z[positive]) / z[positive]
    local = (noise < 0.5 * float(width.min())) & (relative_sd <= _PROPORTIONAL)
    columns = np.zeros((len(z), len(mean)))
    if local.any():
        columns[local] = _around_readings(mean, width, z[local], noise[local], sd, relative_sd)
    if not local.all():
        columns[~local] = _pairs(mean, width, z[~local], sd, relative_sd)
    return columns


def _around_readings(
    mean: np.ndarray, width: np.ndarray, z: np.ndarray, noise: np.ndarray, sd: float, relative_sd: float
) -> np.ndarray:
    t = np.log(z)[:, None] + noise[:, None] * _LOCAL
    kernel = _kernel(z, t, sd, relative_sd) * noise[:, None]
    found = np.empty((len(z), len(mean)))
    for u, (centre, spread) in enumerate(zip(mean.tolist(), width.tolist(), strict=True)):
        scaled = (t - centre) / spread
        found[:, u] = np.einsum("nj,nj->n", kernel, np.exp(-0.5 * scaled * scaled))
    return found / (width * math.sqrt(2 * math.pi))


def _kernel(z: np.ndarray, t: np.ndarray, sd: float, relative_sd: float) -> np.ndarray:
    """Return N(z; exp t, noise^2) at nodes of shape (N, J)."""
    value = np.exp(np.minimum(t, 300.0))
    noise = np.maximum(np.hypot(sd, relative_sd * value), 1e-150)
    scaled = (z[:, None] - value) / noise
    return np.asarray(np.exp(-0.5 * scaled * scaled) / (noise * math.sqrt(2 * math.pi)))


def _pairs(mean: np.ndarray, width: np.ndarray, z: np.ndarray, sd: float, relative_sd: float) -> np.ndarray:
    noise = np.hypot(sd, relative_sd * np.exp(mean))
    low = np.exp(mean - _REACH * width) - 8.5 * noise
    high = np.exp(mean + _REACH * width) * (1 + 8.5 * relative_sd) + 8.5 * sd
    rows, cols = np.nonzero((z[:, None] >= low) & (z[:, None] <= high))
    found = np.zeros((len(z), len(mean)))
    found[rows, cols] = exponential_density(mean[cols], width[cols] ** 2, z[rows], sd, relative_sd)
    return found
