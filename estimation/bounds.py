"""Lower bounds: what a squeeze of something too stiff tells, as a measurement and as evidence.

What resists without giving way has a compliance C = 1 / E that cannot be told from nothing: a reading C = 0 +- s,
where s follows from the bound b that E exceeds with 95 % confidence, P(C < 1 / b) = 0.95: s = 1 / (1.645 b). As a
measurement of C a bound is recorded, kept and shown; the likelihood exp(-(1 / (s E))^2 / 2) is learnt from.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from estimation.measurement import Measurement
from estimation.network import LOG

RECIPROCALS: Mapping[str, tuple[str, str]] = MappingProxyType({"compliance": ("elasticity", "Pa")})
"""Quantities that are read where a bound is all that can be said: what each is the reciprocal of, and its unit."""
ONE_SIDED = 1.6448536269514722  # standard deviations that a Gaussian exceeds with a probability of 5 %
_TAIL = 40.0  # exp(-40) is where a density is taken to end
_HALVINGS = 200
_NODES = 160
_SMALLEST = 1e-100


def elasticity_at_least(least: float) -> Measurement:
    """Return the measurement that says that a modulus exceeds a bound with 95 % confidence.

    Args:
        least: the bound [Pa], > 0.
    """
    return Measurement("compliance", 0.0, 1 / (ONE_SIDED * least), "1/Pa")


def bound_of(measurement: Measurement) -> tuple[str, float, str] | None:
    """Return of which quantity a measurement is a bound, the bound, and its unit; None if it is none."""
    if measurement.property not in RECIPROCALS:
        return None
    quantity, unit = RECIPROCALS[measurement.property]
    return quantity, 1 / (max(measurement.mean, 0.0) + ONE_SIDED * measurement.sd), unit


def condition_bound(
    scale: str, mean: np.ndarray, variance: np.ndarray, least: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Condition x, Gaussian itself or in its logarithm, on a lower bound, by moment matching.

    p(x | b) ~ p(x) exp(-(1.645 b / x)^2 / 2) for x > 0.

    Args:
        scale: ``log`` if the coordinate is ln x.
        mean, variance: of the coordinate, (K,).
        least: the bound b, in the unit of x.

    Returns:
        Log evidence, posterior mean and posterior variance of the coordinate, each (K,).
    """
    reach = ONE_SIDED * least
    logarithmic = scale == LOG

    def exponent(t: np.ndarray) -> np.ndarray:
        with np.errstate(over="ignore", under="ignore"):
            x = np.exp(t) if logarithmic else t
            return np.asarray(-0.5 * ((t - mean) ** 2 / variance + (reach / x) ** 2))

    def rises(t: np.ndarray) -> np.ndarray:
        with np.errstate(over="ignore", under="ignore"):
            pull = reach**2 * np.exp(-2 * t) if logarithmic else reach**2 / t**3
            return np.asarray(pull > (t - mean) / variance)

    # Log-concave: it rises to one peak, and is negligible beyond where it crosses exp(-40) of that.
    if logarithmic:
        floor, most = mean, mean + variance * reach**2 * np.exp(-2 * mean)
    else:
        floor, most = np.full(mean.shape, _SMALLEST), np.maximum(mean, 0.0) + np.sqrt(reach * np.sqrt(variance))
    peak = _crossing(rises, floor, most)
    end = exponent(peak) - _TAIL
    half = np.sqrt(-2 * variance * end)
    low = mean - half if logarithmic else np.maximum(mean - half, _SMALLEST)
    low = _crossing(lambda t: exponent(t) < end, low, peak)
    high = _crossing(lambda t: exponent(t) > end, peak, mean + half)
    # Even steps of ln x: where a prior of x reaches to 0, it ends more abruptly than steps of x would show.
    first, last = (low, high) if logarithmic else (np.log(low), np.log(high))
    step = (last - first) / (_NODES - 1)
    nodes = first + step * np.arange(_NODES)[:, None]
    t = nodes if logarithmic else np.exp(nodes)
    values = exponent(t)
    top = values.max(axis=0)
    density = np.exp(values - top) * (1.0 if logarithmic else t)
    mass = density.sum(axis=0)
    centre = (density * t).sum(axis=0) / mass
    spread = (density * (t - centre) ** 2).sum(axis=0) / mass
    evidence = top + np.log(mass * step) - 0.5 * np.log(2 * np.pi * variance)
    return evidence, centre, np.maximum(spread, np.finfo(float).tiny)


def _crossing(before: Callable[[np.ndarray], np.ndarray], low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return where something that holds at ``low`` ceases to, by bisection; it does not hold at ``high``."""
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        holds = before(middle)
        low, high = np.where(holds, middle, low), np.where(holds, high, middle)
    return np.asarray(0.5 * (low + high))
