"""Products of two properties of which one lives on the linear scale, such as mass = density volume."""

from __future__ import annotations

import math

import numpy as np

_LOG_2PI = math.log(2 * math.pi)
_TAIL = 40.0
_ZOOMS = 3


def condition_product(
    mean: np.ndarray, covariance: np.ndarray, log: bool, z: float, sd: float, nodes: int = 96
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Condition two coordinates on z = a b + N(0, sd^2), where b is its coordinate or exp of it.

    Given b the reading is linear in a, so evidence and moments are integrals over b alone; the grid over b
    is zoomed onto where the integrand lives.

    Args:
        mean: means (m_a, m_b) per hypothesis, shape (K, 2).
        covariance: shape (K, 2, 2).
        log: whether b is exp of its coordinate.
        z: the reading.
        sd: its standard deviation, > 0.
        nodes: quadrature nodes per hypothesis in the last grid.

    Returns:
        Log evidence (K,), posterior mean (K, 2) and covariance (K, 2, 2).
    """
    m_a, m_b = mean[:, :1], mean[:, 1:]
    v_a, v_b, c = covariance[:, :1, 0], covariance[:, 1:, 1], covariance[:, :1, 1]
    slope = c / v_b
    inner = np.maximum(v_a - slope * c, 0.0)
    low, high = m_b - 9.5 * np.sqrt(v_b), m_b + 9.5 * np.sqrt(v_b)
    for zoom in range(_ZOOMS + 1):
        count = nodes if zoom == _ZOOMS else 65
        step = (high - low) / (count - 1)
        b = low + step * np.arange(count)
        g = np.exp(np.minimum(b, 300.0)) if log else b
        a = m_a + slope * (b - m_b)
        total = g * g * inner + sd * sd
        density = -0.5 * ((b - m_b) ** 2 / v_b + (z - g * a) ** 2 / total + np.log(total))
        top = density.max(axis=1, keepdims=True)
        if zoom < _ZOOMS:
            low, high = _live(b, density > top - _TAIL)
    mass = np.exp(density - top)
    weight = mass / mass.sum(axis=1, keepdims=True)
    gain = g * inner / total
    a = a + gain * (z - g * a)
    m_a, m_b = (weight * a).sum(axis=1, keepdims=True), (weight * b).sum(axis=1, keepdims=True)
    spread = np.empty_like(covariance)
    spread[:, 0, 0] = (weight * ((a - m_a) ** 2 + inner * (1 - gain * g))).sum(axis=1)
    spread[:, 1, 1] = (weight * (b - m_b) ** 2).sum(axis=1)
    spread[:, 0, 1] = spread[:, 1, 0] = (weight * (a - m_a) * (b - m_b)).sum(axis=1)
    evidence = (top + np.log(mass.sum(axis=1, keepdims=True) * step) - 0.5 * np.log(v_b))[:, 0]
    return evidence - _LOG_2PI, np.concatenate([m_a, m_b], axis=1), spread


def _live(grid: np.ndarray, live: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the ends of the marked part of every row, one node wider on both sides, each (K, 1)."""
    rows, last = np.arange(len(grid)), grid.shape[1] - 1
    first = np.maximum(live.argmax(axis=1) - 1, 0)
    final = np.minimum(last - live[:, ::-1].argmax(axis=1) + 1, last)
    return grid[rows, first][:, None], grid[rows, final][:, None]


def product_moments(mean: np.ndarray, covariance: np.ndarray, log: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return mean and variance of a b, where b is its coordinate or exp of it, each (K,).

    Args:
        mean: means (m_a, m_b), shape (K, 2).
        covariance: shape (K, 2, 2).
        log: whether b is exp of its coordinate.
    """
    m_a, m_b = mean[:, 0], mean[:, 1]
    v_a, v_b, c = covariance[:, 0, 0], covariance[:, 1, 1], covariance[:, 0, 1]
    if not log:
        centre = m_a * m_b + c
        return centre, v_a * v_b + c**2 + m_a**2 * v_b + m_b**2 * v_a + 2 * m_a * m_b * c
    centre = np.exp(m_b + 0.5 * v_b) * (m_a + c)
    second = np.exp(2 * (m_b + v_b)) * ((m_a + 2 * c) ** 2 + v_a)
    return centre, np.maximum(second - centre**2, 0.0)
