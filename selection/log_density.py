"""Densities of noisy readings of log-normal quantities, for many hypotheses at once."""

from __future__ import annotations

import math

import numpy as np

_REACH = 6.5
_LOCAL = np.arange(-7.0, 7.5)
_NARROW = 0.15  # noise in t beyond which it is no longer nearly Gaussian there: its tails end nowhere


def log_columns(
    mean: np.ndarray, variance: np.ndarray, z: np.ndarray, sd: float, relative_sd: float
) -> np.ndarray:
    """Return p(z | u) for z = exp(t) + N(0, sd^2 + (relative_sd exp t)^2), t ~ N(mean_u, variance_u).

    The integral over t, by trapezoid rules that resolve the narrower of the two: where the noise in t is
    narrow against the hypothesis, nodes around ln z, which all hypotheses share; elsewhere nodes around the
    hypothesis, which all readings share.

    Args:
        mean: shape (U,).
        variance: shape (U,), > 0.
        z: readings in ascending order, shape (N,).
        sd: constant part of the noise.
        relative_sd: proportional part of the noise.

    Returns:
        Densities, shape (N, U).
    """
    width = np.sqrt(variance)
    noise = np.full(len(z), np.inf)
    positive = z > 0
    noise[positive] = np.hypot(sd, relative_sd * z[positive]) / z[positive]
    columns = np.zeros((len(z), len(mean)))
    edges = np.stack([mean - _REACH * width, mean + _REACH * width])
    reach = 8.5 * np.hypot(sd, relative_sd * np.exp(edges))
    starts = np.searchsorted(z, (np.exp(edges) - reach).min(axis=0))
    ends = np.searchsorted(z, (np.exp(edges) + reach)[1])
    proportional = relative_sd > _NARROW
    shared = 0 if proportional else len(z)
    if not proportional:
        # noise falls with z: from here on it is narrow for the widest hypothesis
        shared = int(np.searchsorted(-noise, -min(0.5 * float(width.max()), _NARROW)))
        nodes = np.log(z[shared:])[:, None] + noise[shared:, None] * _LOCAL
        kernel = _kernel(z[shared:], nodes, sd, relative_sd) * noise[shared:, None]
    for u, (centre, spread) in enumerate(zip(mean.tolist(), width.tolist(), strict=True)):
        first, last = int(starts[u]), int(ends[u])
        narrow = last
        if not proportional:
            narrow = min(max(int(np.searchsorted(-noise, -min(0.5 * spread, _NARROW))), first), last)
        if narrow > first:
            finest = relative_sd if proportional else float(noise[first:narrow].min())
            step = min(0.5 * spread, 0.5 * finest, 0.3)
            count = 2 * math.ceil(_REACH * spread / step) + 1
            t = centre + spread * np.linspace(-_REACH, _REACH, count)
            prior = np.exp(-0.5 * ((t - centre) / spread) ** 2) * (t[1] - t[0]) / spread
            columns[first:narrow, u] = _kernel(z[first:narrow], t, sd, relative_sd) @ prior
        if last > narrow:
            rows = slice(narrow - shared, last - shared)
            scaled = (nodes[rows] - centre) / spread
            columns[narrow:last, u] = np.einsum("nj,nj->n", kernel[rows], np.exp(-0.5 * scaled * scaled)) / spread
    return columns / math.sqrt(2 * math.pi)


def _kernel(z: np.ndarray, t: np.ndarray, sd: float, relative_sd: float) -> np.ndarray:
    """Return N(z; exp t, noise^2) at nodes of shape (N, J) or (J,)."""
    value = np.exp(np.minimum(t, 300.0))
    noise = np.maximum(np.hypot(sd, relative_sd * value), 1e-150)
    scaled = (z[:, None] - value) / noise
    return np.asarray(np.exp(-0.5 * scaled * scaled) / (noise * math.sqrt(2 * math.pi)))
