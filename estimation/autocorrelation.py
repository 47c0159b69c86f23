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

    Andrews' rule with AR(1) models of the scores (Econometrica 59, 1991, eq. 6.2 and 6.4):
    1.1447 (alpha T)^(1/3).

    Args:
        scores: (T, p).
    """
    count = len(scores)
    before, after = scores[:-1], scores[1:]
    power = np.einsum("ti,ti->i", before, before)
    rho = np.clip(np.einsum("ti,ti->i", before, after) / np.where(power > 0, power, 1.0), -0.97, 0.97)
    variance = np.mean((after - rho * before) ** 2, axis=0)
    # unit weights on scores scaled to unit variance: units must not matter
    share = variance / np.where(power > 0, power / count, 1.0)
    top = np.sum(4 * rho**2 * share**2 / ((1 - rho) ** 6 * (1 + rho) ** 2))
    bottom = np.sum(share**2 / (1 - rho) ** 4)
    alpha = float(top / bottom) if bottom > 0 else 0.0
    return float(min(1.1447 * (alpha * count) ** (1 / 3), count / 4))


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
    """Return how many independent numbers correlated residuals are worth: sum_j T (1 - rho_j) / (1 + rho_j).

    Args:
        residual: one AR(1) series a column, in order of time, (T, n).
    """
    before, after = residual[:-1], residual[1:]
    power = (residual**2).mean(axis=0)
    rho = np.clip((before * after).mean(axis=0) / np.where(power > 0, power, 1.0), 0.0, 0.999)
    return float(np.sum(len(residual) * (1 - rho) / (1 + rho)))
