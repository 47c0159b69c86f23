"""Covariances of linear estimates that stay honest when residuals are correlated in time.

A linear estimate is x + H^-1 sum_t s_t with scores s_t = A_t^T W r_t. Naive theory takes the scores for
independent; here their correlation over time counts.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def bandwidth(scores: Array) -> float:
    """Return the lag over which Bartlett's kernel should reach, in samples.

    Andrews' rule (Econometrica 59, 1991, eq. 6.2 and 6.4) with a model of each score: 1.1447 (alpha T)^(1/3). The
    model is AR(1) beneath white noise, which would hide the correlation from a fit to neighbours alone.

    Args:
        scores: with mean zero, (T, p).
    """
    count = len(scores)
    _, rho = _persistence(scores)
    # unit weights on scores scaled to unit variance: units must not matter
    innovation = 1 - rho**2
    top = np.sum(4 * rho**2 * innovation**2 / ((1 - rho) ** 6 * (1 + rho) ** 2))
    bottom = np.sum(innovation**2 / (1 - rho) ** 4)
    return float(min(1.1447 * (float(top / bottom) * count) ** (1 / 3), count / 4))


def _persistence(series: Array) -> tuple[Array, Array]:
    """Return correlation at lag 1, and the factor by which it falls from lag to lag, of every column."""
    count = len(series)
    power = (series**2).sum(axis=0)
    safe = np.where(power > 0, power, 1.0)
    at = np.array([(series[lag:] * series[:-lag]).sum(axis=0) / safe for lag in range(1, 5)])
    there = at[:3].sum(axis=0) > 3 * 2 / np.sqrt(count)  # three lags, each beyond two sd of chance
    factor = np.where(there, at[1:].sum(axis=0) / np.where(there, at[:3].sum(axis=0), 1.0), at[0])
    return np.clip(at[0], 0.0, 1.0), np.clip(factor, 0.0, 0.98)


def long_run_covariance(scores: Array, lag: float | None = None) -> Array:
    """Return the covariance of the sum of correlated scores (HAC; Newey and West, Econometrica 55, 1987).

    sum_l (1 - |l| / L) Gamma_l, positive semidefinite.

    Args:
        scores: with mean zero, in order of time, (T, p).
        lag: reach L of the kernel in samples; None for Andrews' choice.
    """
    reach = bandwidth(scores) if lag is None else lag
    total = scores.T @ scores
    for shift in range(1, min(int(np.ceil(reach)), len(scores) - 1)):
        product = scores[shift:].T @ scores[:-shift]
        total = total + (1 - shift / reach) * (product + product.T)
    return np.asarray(total)


def small_sample_widening(scores: Array) -> float:
    """Return the factor on an sd from :func:`long_run_covariance`, for kernels that span much of the series.

    The 97.5 % quantile of the t ratio under fixed b = L / T over 1.96, for Bartlett's kernel:
    1.9600 + 2.9694 b + 0.4160 b^2 - 0.5324 b^3 (Kiefer and Vogelsang, Econometric Theory 21, 2005).
    """
    b = bandwidth(scores) / len(scores)
    return (1.96 + 2.9694 * b + 0.4160 * b**2 - 0.5324 * b**3) / 1.96


def block_bootstrap_covariance(scores: Array, length: int, draws: int, rng: np.random.Generator) -> Array:
    """Return the covariance of the sum of scores by the moving block bootstrap (Kuensch, Ann. Stat. 17, 1989).

    Args:
        scores: in order of time, (T, p).
        length: of a block, in samples; a multiple of the correlation time.
        draws: number of resampled series.
        rng: source of randomness.
    """
    count, blocks = len(scores), int(np.ceil(len(scores) / length))
    sums = np.cumsum(np.vstack([np.zeros(scores.shape[1]), scores]), axis=0)
    block_sums = sums[length:] - sums[:-length]
    picks = rng.integers(0, len(block_sums), size=(draws, blocks))
    totals = block_sums[picks].sum(axis=1) * np.sqrt(count / (blocks * length))
    return np.atleast_2d(np.cov(totals, rowvar=False))


def independent_count(residual: Array) -> float:
    """Return how many independent numbers correlated residuals are worth: sum_j T / (1 + 2 r_j / (1 - rho_j)).

    r is the correlation at lag 1 and rho the factor by which it falls from there on.

    Args:
        residual: one series a column, in order of time, (T, n).
    """
    first, factor = _persistence(residual)
    return float(np.sum(len(residual) / (1 + 2 * first / (1 - factor))))
