"""Figures with their uncertainty: rates, means, scores of probabilities."""

from __future__ import annotations

import math

import numpy as np

Z95 = 1.959963984540054
"""Half width of a 95 % interval in standard errors."""
_BINS = 10
_RESAMPLES = 60


def wilson(successes: int, trials: int) -> tuple[float, float]:
    """Return the 95 % interval of a rate (Wilson 1927): (p + z^2/2n +- z sqrt(p q/n + z^2/4n^2)) / (1 + z^2/n)."""
    if trials == 0:
        return 0.0, 1.0
    p, square = successes / trials, Z95**2 / trials
    half = Z95 * math.sqrt(p * (1 - p) / trials + square / (4 * trials))
    low, high = (p + square / 2 - half) / (1 + square), (p + square / 2 + half) / (1 + square)
    return max(low, 0.0) if successes else 0.0, min(high, 1.0) if successes < trials else 1.0


def fisher(first: tuple[int, int], second: tuple[int, int]) -> float:
    """Return the two-sided P of Fisher's exact test that two counts have one rate.

    Args:
        first, second: successes and trials.
    """
    (a, n), (b, m) = first, second
    total = a + b

    def weight(k: int) -> int:
        return math.comb(n, k) * math.comb(m, total - k)

    seen = weight(a)
    sums = [weight(k) for k in range(max(0, total - m), min(n, total) + 1)]
    return sum(w for w in sums if w <= seen) / sum(sums)


def mean_interval(values: np.ndarray) -> tuple[float, float, float]:
    """Return a mean and its 95 % interval, of independent values (N,)."""
    mean = float(np.mean(values))
    if len(values) < 2:
        return mean, mean, mean
    half = Z95 * float(np.std(values, ddof=1)) / math.sqrt(len(values))
    return mean, mean - half, mean + half


def log_score(true: np.ndarray) -> np.ndarray:
    """Return log2 P(true class), floored at 1e-12 so that one surprise does not hide everything else."""
    return np.asarray(np.log2(np.maximum(true, 1e-12)))


def calibration_error(top: np.ndarray, right: np.ndarray) -> tuple[float, float, float]:
    """Return the expected calibration error and its 95 % interval by resampling the trials.

    ECE = sum over tenths of |sum of (right - P)| / N, with P the probability of the most probable class.

    Args:
        top: these probabilities, shape (N,).
        right: whether that class was the true one, shape (N,).
    """
    index = np.minimum((top * _BINS).astype(int), _BINS - 1)
    gap = right.astype(float) - top
    count = len(top)
    found = float(np.abs(np.bincount(index, gap, _BINS)).sum()) / count
    picks = np.random.default_rng(0).integers(count, size=(_RESAMPLES, count))
    flat = index[picks] + _BINS * np.arange(_RESAMPLES)[:, None]
    sums = np.bincount(flat.ravel(), gap[picks].ravel(), _RESAMPLES * _BINS).reshape(_RESAMPLES, _BINS)
    low, high = np.quantile(np.abs(sums).sum(axis=1) / count, [0.025, 0.975])
    return found, min(float(low), found), max(float(high), found)
