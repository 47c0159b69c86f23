"""Repeated readings of one property fused into one, in a factor graph with odd readings weighed down."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from dynamics.errors import InvalidInput
from estimation.graph import LinearGraph, key
from estimation.measurement import Measurement

Array = NDArray[np.float64]

ODD_RATE = 0.05  # share of readings that went wrong
ODD_SCALE = 6.0  # how much wider their errors are, at least
ROUNDS = 50


def fuse(measurements: Sequence[Measurement], *, common_sd: float = 0.0) -> Measurement:
    """Fuse readings of one property of one object.

    Minimises sum_i (z_i - x)^2 / sd_i^2; an error that all readings share, as a calibration's, is added after.
    From three readings on, one that went wrong is weighed down by a mixture of a narrow and a wide Gaussian.

    Args:
        measurements: at least one; their sd is what differs between them.
        common_sd: standard deviation of what they share, in their unit; more readings do not reduce it.

    Raises:
        InvalidInput: for no measurements, different properties or units, or a common sd < 0.
    """
    if not measurements:
        raise InvalidInput("fuse: measurements", "none", "at least one")
    first = measurements[0]
    for other in measurements[1:]:
        if (other.property, other.unit) != (first.property, first.unit):
            raise InvalidInput(
                "fuse: measurements",
                f"{other.property} [{other.unit}]",
                f"{first.property} [{first.unit}] throughout",
            )
    if not (math.isfinite(common_sd) and common_sd >= 0):
        raise InvalidInput("fuse: common_sd", common_sd, "a finite number >= 0")
    z, sd = np.array([m.mean for m in measurements]), np.array([m.sd for m in measurements])
    centre = float(np.median(z))
    unit = float(np.median(sd))  # the graph is solved in units of it
    mean, spread, scale = centre, unit, ODD_SCALE
    for _ in range(ROUNDS):
        residual = (z - mean) / sd
        weight = _inlier(residual, scale) if len(z) > 2 else np.ones(len(z))
        odd = 1 - weight  # and as wide as they are: a reading far off must not pull
        scale = max(math.sqrt(float((odd * residual**2).sum()) / max(float(odd.sum()), 1e-9)), ODD_SCALE)
        graph = LinearGraph()
        for value, own, right in zip(z, sd, weight, strict=True):
            wider = own / unit / math.sqrt(right + (1 - right) / scale**2)
            graph.add({key("x"): np.eye(1)}, np.array([(value - centre) / unit]), np.array([wider]))
        solution = graph.solve(key("x"))
        before, mean = mean, centre + unit * float(solution[key("x")][0])
        spread = unit / abs(float(solution.root[0, 0]))
        if abs(mean - before) < 1e-9 * unit:
            break
    return Measurement(first.property, mean, math.hypot(spread, common_sd), first.unit)


def _inlier(residual: Array, scale: float) -> Array:
    """Return each reading's probability to have gone right, (n,)."""
    odds = math.log(ODD_RATE / (1 - ODD_RATE) / scale) + 0.5 * residual**2 * (1 - 1 / scale**2)
    probability: Array = 1 / (1 + np.exp(np.minimum(odds, 700.0)))
    return probability
