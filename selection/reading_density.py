"""Densities of noisy readings whose noise depends on the value, for many hypotheses at once."""

from __future__ import annotations

import math

import numpy as np

from estimation.network import LOG
from selection.quadrature import graded_nodes

REACH = 7.0
_SERIES = 0.2  # noise as a share of a hypothesis' width below which the series holds (to 1e-7)
_ORDER = 8
_SHARP = 1e-3  # width of a hypothesis as a share of the noise below which its value is as good as known
_ROOT_2PI = math.sqrt(2 * math.pi)
_NARROW = 0.13  # proportional noise beyond which it is not nearly Gaussian in the value: its tails end nowhere
_LOCAL = np.arange(-8.0, 12.5)  # sds of the noise in t; its tail away from zero is the longer one


def reading_columns(
    mean: np.ndarray, variance: np.ndarray, z: np.ndarray, sd: float, relative_sd: float, link: str = LOG
) -> np.ndarray:
    """Return p(z | u) for z = x + N(0, sd^2 + (relative_sd x)^2), x = t or exp t, t ~ N(mean_u, variance_u).

    Where the noise in t is narrow against the hypothesis, the density is the series of the hypothesis'
    derivatives with the noise's moments; elsewhere the integral over t on nodes that all hypotheses and
    readings share.

    Args:
        mean: shape (U,).
        variance: shape (U,), > 0.
        z: readings in ascending order, shape (N,).
        sd: constant part of the noise, > 0.
        relative_sd: proportional part of the noise.
        link: ``log`` for x = exp t, ``linear`` for x = t.

    Returns:
        Densities, shape (N, U).
    """
    log = link == LOG
    width = np.sqrt(variance)
    sharp = width <= _SHARP * _noise_in_t(np.exp(mean) if log else mean, sd, relative_sd, log)
    if sharp.any():
        columns = np.empty((len(z), len(mean)))
        columns[:, sharp] = _known_values(mean[sharp], width[sharp], z, sd, relative_sd, log)
        if not sharp.all():
            rest = ~sharp
            columns[:, rest] = reading_columns(mean[rest], variance[rest], z, sd, relative_sd, link)
        return columns
    noise = _noise_in_t(z, sd, relative_sd, log)
    limit = _SERIES * width
    if log:
        limit = np.minimum(limit, _NARROW)
    holds = (noise[:, None] <= limit) & (relative_sd < _NARROW)
    whole, none = holds.all(axis=1), ~holds.any(axis=1)
    columns = np.empty(holds.shape)
    if not whole.all():
        low, high = _needed(mean, width, z, holds, sd, relative_sd, log)
        columns[~whole] = _integrals(mean, width, z[~whole], (low, high), sd, relative_sd, log)
    if not none.all():
        rows = np.flatnonzero(~none)
        series = _series(mean, width, z[rows], noise[rows], sd, relative_sd, log)
        pure = whole[rows]
        columns[rows[pure]] = series[pure]
        if not pure.all():
            mixed = rows[~pure]
            columns[mixed] = np.where(holds[mixed], series[~pure], columns[mixed])
    return columns


def _known_values(
    mean: np.ndarray, width: np.ndarray, z: np.ndarray, sd: float, relative_sd: float, log: bool
) -> np.ndarray:
    """Return the densities of readings of values that are known much better than they are read, (N, U)."""
    value = np.exp(mean) if log else mean
    spread = np.sqrt(sd**2 + (relative_sd * value) ** 2 + ((value if log else 1.0) * width) ** 2)
    scaled = (z[:, None] - value) / spread
    return np.asarray(np.exp(-0.5 * scaled * scaled) / (spread * _ROOT_2PI))


def _noise_in_t(z: np.ndarray, sd: float, relative_sd: float, log: bool) -> np.ndarray:
    noise = np.hypot(sd, relative_sd * z)
    if not log:
        return noise
    return np.asarray(np.where(z > 0, noise / np.where(z > 0, z, 1.0), np.inf))


def _needed(
    mean: np.ndarray, width: np.ndarray, z: np.ndarray, holds: np.ndarray, sd: float, relative_sd: float, log: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Return between which t every hypothesis matters to the readings for which its series does not hold."""
    low, high = mean - REACH * width, mean + REACH * width
    if relative_sd >= _NARROW:
        return low, high
    open_ = ~holds
    first = np.maximum(open_.argmax(axis=0) - 1, 0)
    last = np.minimum(len(z) - open_[::-1].argmax(axis=0), len(z) - 1)
    bottom = z[first] - 9 * np.hypot(sd, relative_sd * z[first])
    top = z[last] + 9 * np.hypot(sd, relative_sd * z[last])
    if log:
        bottom, top = (np.log(np.maximum(bound, 1e-300)) for bound in (bottom, top))
    low = np.where(open_[0], low, np.maximum(low, bottom))
    high = np.where(open_[-1], high, np.minimum(high, top))
    return low, np.where(open_.any(axis=0), high, low)


def _integrals(
    mean: np.ndarray,
    width: np.ndarray,
    z: np.ndarray,
    bounds: tuple[np.ndarray, np.ndarray],
    sd: float,
    relative_sd: float,
    log: bool,
) -> np.ndarray:
    """Return the densities as integrals over t, shape (N, U)."""

    def scale(t: np.ndarray, own: np.ndarray) -> np.ndarray:
        if log:
            noise = sd**2 * np.exp(-2 * np.clip(t, -300, 300)) + relative_sd**2
            return np.asarray(1 / np.sqrt(1 + 1 / own**2 + 1 / noise))
        return np.asarray(1 / np.sqrt(1 / own**2 + 1 / (sd**2 + (relative_sd * t) ** 2)))

    low, high = bounds
    used = high > low
    t, weights = graded_nodes(low[used], high[used], width[used], scale, sd / relative_sd if relative_sd else 0.0)
    value = np.exp(np.minimum(t, 300.0)) if log else t
    spread = np.hypot(sd, relative_sd * value)
    kernel = z[:, None] / spread
    kernel -= value / spread
    kernel *= kernel
    kernel *= -0.5
    np.exp(kernel, out=kernel)
    kernel *= weights / (spread * (2 * math.pi))
    prior = t[:, None] / width
    prior -= mean / width
    prior *= prior
    prior *= -0.5
    np.exp(prior, out=prior)
    prior /= width
    return np.asarray(kernel @ prior)


def _series(
    mean: np.ndarray,
    width: np.ndarray,
    z: np.ndarray,
    noise: np.ndarray,
    sd: float,
    relative_sd: float,
    log: bool,
) -> np.ndarray:
    """Return sum_j M_j / j! q^(j)(t_z), M_j the moments of the noise about t_z, q the hypothesis, (N, U)."""
    centre = np.log(z) if log else z
    offset = np.copysign(noise, z)[:, None] * _LOCAL
    value = z[:, None] * np.exp(offset) if log else z[:, None] + offset
    spread = np.hypot(sd, relative_sd * value)
    moment = np.exp(-0.5 * ((z[:, None] - value) / spread) ** 2) / spread
    moment *= noise[:, None] * (_LOCAL[1] - _LOCAL[0]) / (2 * math.pi)
    slope = centre[:, None] - mean
    slope /= width
    derivative = slope * slope
    derivative *= -0.5
    np.exp(derivative, out=derivative)
    derivative /= width
    slope /= -width
    curve = 1 / width**2
    before, following, term = np.zeros_like(slope), np.empty_like(slope), np.empty_like(slope)
    total = moment.sum(axis=1)[:, None] * derivative
    for order in range(1, _ORDER + 1):
        moment *= offset / order
        np.multiply(slope, derivative, out=following)
        if order > 1:
            before *= (order - 1) * curve
            following -= before
        before, derivative, following = derivative, following, before
        total += np.multiply(moment.sum(axis=1)[:, None], derivative, out=term)
    return np.asarray(total)
