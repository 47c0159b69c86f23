"""One scalar reading against a bank of Gaussian hypotheses: log evidence and posterior moments."""

from __future__ import annotations

import math

import numpy as np

_LOG_2PI = math.log(2 * math.pi)
_TAIL = 40.0  # exp(-40) is where a density is taken to end


def log_normal_density(z: np.ndarray | float, mean: np.ndarray, variance: np.ndarray) -> np.ndarray:
    """Return ln N(z; mean, variance); shapes broadcast."""
    return np.asarray(-0.5 * ((z - mean) ** 2 / variance + np.log(variance) + _LOG_2PI))


def logsumexp(values: np.ndarray) -> float:
    """Return ln sum exp(values), finite wherever one value is, shape (K,) -> scalar."""
    top = float(values.max())
    if not math.isfinite(top):
        return top
    return top + math.log(float(np.exp(values - top).sum()))


def condition_linear(
    mean: np.ndarray, variance: np.ndarray, z: float, sd: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Condition t ~ N(mean, variance) on z = t + N(0, sd^2).

    Args:
        mean: shape (K,).
        variance: shape (K,), >= 0.
        z: the reading.
        sd: its standard deviation, > 0.

    Returns:
        Log evidence, posterior mean and posterior variance, each (K,).
    """
    total = variance + sd * sd
    gain = variance / total
    residual = z - mean
    evidence = -0.5 * (residual**2 / total + np.log(total) + _LOG_2PI)
    return evidence, mean + gain * residual, gain * (sd * sd)


def condition_exponential(
    mean: np.ndarray, variance: np.ndarray, z: np.ndarray | float, sd: float, nodes: int = 48
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Condition t ~ N(mean, variance) on z = exp(t) + N(0, sd^2), by moment matching.

    Evidence and moments are one-dimensional integrals over t, by the trapezoid rule on an interval outside
    of which the integrand is below exp(-40) of a lower bound of its peak; that interval is the intersection
    of two closed-form ones, so no reading is too far off or too sharp for it.

    Args:
        mean: shape (...).
        variance: shape (...), > 0.
        z: the reading; broadcasts against the mean.
        sd: its standard deviation, > 0.
        nodes: quadrature nodes per hypothesis.

    Returns:
        Log evidence, posterior mean and posterior variance of t, each (...).
    """
    z = np.asarray(z, dtype=float)
    low, high = _support(mean, variance, z, sd)
    step = (high - low) / (nodes - 1)
    t = low[..., None] + step[..., None] * np.arange(nodes)
    log = -0.5 * ((t - mean[..., None]) ** 2 / variance[..., None] + ((z[..., None] - np.exp(t)) / sd) ** 2)
    top = log.max(axis=-1)
    density = np.exp(log - top[..., None])
    mass = density.sum(axis=-1)
    centre = (density * t).sum(axis=-1) / mass
    spread = (density * (t - centre[..., None]) ** 2).sum(axis=-1) / mass
    evidence = top + np.log(mass * step) - 0.5 * np.log(variance) - math.log(sd) - _LOG_2PI
    return evidence, centre, np.maximum(spread, np.finfo(float).tiny)


def _support(mean: np.ndarray, variance: np.ndarray, z: np.ndarray, sd: float) -> tuple[np.ndarray, np.ndarray]:
    """Return bounds outside of which prior times likelihood is negligible, each (...).

    With phi = (t - m)^2 / 2v + (z - e^t)^2 / 2n^2 and phi* = phi at any point, both terms stay below
    phi* + 40 wherever the integrand exceeds exp(-40) of its value there.
    """
    start = np.log(np.maximum(z, 0.1 * sd))
    relative = np.minimum(sd / np.maximum(z, sd), 1.0) ** 2
    blend = (mean * relative + start * variance) / (relative + variance)
    shape = np.broadcast(mean, z).shape
    t = np.stack([np.broadcast_to(guess, shape) for guess in (mean, start, blend)])
    best = np.full(shape, np.inf)
    with np.errstate(over="ignore"):
        for _ in range(4):
            value = np.exp(np.minimum(t, 300.0))
            error, scaled = (z - value) / sd, (t - mean) / variance
            phi = 0.5 * (scaled * (t - mean) + error**2)
            best = np.fmin(best, np.fmin.reduce(phi))
            slope = scaled - error * value / sd
            bend = 1.0 / variance + (value / sd) ** 2
            t = t - np.clip(slope / bend, -2.0, 2.0)
    reach = best + _TAIL
    half = np.sqrt(2 * variance * reach)
    outer = sd * np.sqrt(2 * reach)
    high = np.minimum(mean + half, np.log(z + outer))
    floor = np.log(np.maximum(z - outer, np.finfo(float).tiny))
    low = np.maximum(mean - half, floor)
    return np.minimum(low, high), high
