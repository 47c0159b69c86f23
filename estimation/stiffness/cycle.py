"""What loading alone does not show: hysteresis between loading and unloading, and stiffness over speed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dynamics.compression import StressStrain
from dynamics.errors import InvalidInput
from estimation.stiffness.estimate import StiffnessEstimate
from estimation.stiffness.noise import end_of_loading, loading_of

Array = NDArray[np.float64]

GRID = 60  # strains at which the branches are compared
SMOOTH = 0.12  # of the strain range: width of the running median of a branch
TWO_SIDED = 1.96


@dataclass(frozen=True)
class Hysteresis:
    """The energy of one cycle of loading and unloading.

    Attributes:
        work: done on the material while loading, per volume [J/m^3].
        returned: given back while unloading, per volume [J/m^3].
        residual_strain: strain at which the unloading stress has fallen to a twentieth of the peak, less that of
            the loading [-].
    """

    work: float
    returned: float
    residual_strain: float

    @property
    def loss(self) -> float:
        """Share of the work that is lost [-]."""
        return 1 - self.returned / self.work


def separate(curve: StressStrain, loading: int | None = None) -> tuple[StressStrain, StressStrain]:
    """Return the loading and the unloading part of a curve; the unloading is empty where the pads never opened.

    Args:
        curve: of a whole cycle.
        loading: how many readings the loading has, where it is known.
    """
    end = end_of_loading(curve.strain, curve.stress) if loading is None else loading
    first = StressStrain(curve.strain[:end], curve.stress[:end], curve.geometry)
    return first, StressStrain(curve.strain[end:], curve.stress[end:], curve.geometry)


def hysteresis(curve: StressStrain, loading: int | None = None) -> Hysteresis:
    """Return the work of loading and unloading, integral of stress over strain, baseline taken off.

    Each branch is a running median over strain, so that a spike of current counts for nothing.

    Args:
        curve: of a whole cycle.
        loading: how many readings the loading has, where it is known.

    Raises:
        InvalidInput: if the curve has no unloading, no work was done, or the opening was renewed so much less
            than the force that a loss would be that of the delay.
    """
    if loading_of(curve, None).renewed_late:
        raise InvalidInput(
            "hysteresis: opening", "renewed less often than the force", "openings of the same instants"
        )
    first, second = separate(curve, loading)
    if len(second) < 5:
        raise InvalidInput("hysteresis: unloading", f"{len(second)} readings", "at least 5")
    low = max(float(np.min(first.strain)), float(np.min(second.strain)))
    high = min(float(np.max(first.strain)), float(np.max(second.strain)))
    if high <= low:
        raise InvalidInput("hysteresis: strains", (low, high), "loading and unloading over the same strains")
    grid = np.linspace(low, high, GRID)
    baseline = float(np.percentile(np.concatenate([first.stress[:5], second.stress[-5:]]), 30))
    up = np.maximum(_branch(first, grid, high - low) - baseline, 0.0)
    down = np.maximum(_branch(second, grid, high - low) - baseline, 0.0)
    work, returned = float(np.trapezoid(up, grid)), float(np.trapezoid(down, grid))
    if work <= 0:
        raise InvalidInput("hysteresis: work of loading [J/m^3]", work, "a number > 0")
    level = 0.05 * float(np.max(up))
    residual = float(grid[int(np.argmax(down > level))] - grid[int(np.argmax(up > level))])
    return Hysteresis(work, returned, residual)


@dataclass(frozen=True)
class RateDependence:
    """How the modulus depends on the strain rate, E = E0 (rate / reference)^exponent.

    Attributes:
        modulus, modulus_sd: at the reference rate [Pa].
        exponent, exponent_sd: [-]; 0 for a material that does not care.
        reference: strain rate [1/s].
    """

    modulus: float
    modulus_sd: float
    exponent: float
    exponent_sd: float
    reference: float

    @property
    def significant(self) -> bool:
        """Whether the exponent differs from 0 with 95 % confidence."""
        return abs(self.exponent) > TWO_SIDED * self.exponent_sd

    def at(self, rate: float) -> float:
        """Return the modulus at a strain rate [Pa]."""
        return float(self.modulus * (rate / self.reference) ** self.exponent)


def rate_dependence(
    estimates: Sequence[StiffnessEstimate], rates: Sequence[float], reference: float | None = None
) -> RateDependence:
    """Fit a power law of the strain rate to moduli measured at several speeds.

    ln E = ln E0 + p ln(rate / reference), weighted by what the readings leave; the calibration of force is common
    to all speeds and cancels from the exponent.

    Args:
        estimates: with moduli, at two rates or more.
        rates: strain rate of each [1/s].
        reference: where E0 is; None for the geometric mean of the rates.

    Raises:
        InvalidInput: for bounds among the estimates, rates that do not differ, or are not positive.
    """
    if len(estimates) != len(rates) or len(set(rates)) < 2:
        raise InvalidInput(
            "rate dependence: rates [1/s]", list(rates), "one a squeeze, at least two different ones"
        )
    if not all(math.isfinite(r) and r > 0 for r in rates):
        raise InvalidInput("rate dependence: rates [1/s]", list(rates), "finite numbers > 0")
    if any(e.bound is not None for e in estimates):
        raise InvalidInput("rate dependence: estimates", "a bound", "moduli")
    logs = np.log(np.asarray(rates))
    reference = math.exp(float(logs.mean())) if reference is None else reference
    x = logs - math.log(reference)
    y = np.array([math.log(e.young_modulus) for e in estimates])
    weight = np.array([(e.young_modulus / e.reading_sd) ** 2 for e in estimates])
    design = np.stack([np.ones_like(x), x], axis=1)
    covariance = np.linalg.inv((design.T * weight) @ design)
    offset, exponent = covariance @ (design.T @ (weight * y))
    if len(y) > 2:  # scatter beyond the readings' own widens both
        excess = float(np.sum(weight * (y - offset - exponent * x) ** 2)) / (len(y) - 2)
        covariance = covariance * max(excess, 1.0)
    modulus = math.exp(float(offset))
    common = max(math.sqrt(max(e.sd**2 - e.reading_sd**2, 0.0)) / e.young_modulus for e in estimates)
    return RateDependence(
        modulus=modulus,
        modulus_sd=modulus * math.hypot(math.sqrt(covariance[0, 0]), common),
        exponent=float(exponent),
        exponent_sd=math.sqrt(covariance[1, 1]),
        reference=reference,
    )


def _branch(curve: StressStrain, grid: Array, span: float) -> Array:
    """Return the median stress of a branch around every strain of a grid, (GRID,)."""
    order = np.argsort(curve.strain, kind="stable")
    strain, stress = curve.strain[order], curve.stress[order]
    straight = np.interp(grid, strain, stress)
    found = np.empty_like(grid)
    for k, at in enumerate(grid):
        near = np.abs(strain - at) <= SMOOTH / 2 * span
        if near.sum() < 3:
            found[k] = straight[k]
            continue
        # The line through the neighbours, so that a median over a slope is not biased at the ends.
        slope = _median_slope(strain[near], stress[near])
        found[k] = float(np.median(stress[near] - slope * (strain[near] - at)))
    return found


def _median_slope(x: Array, y: Array) -> float:
    i, j = np.triu_indices(len(x), 1)
    apart = x[j] > x[i]
    return float(np.median((y[j] - y[i])[apart] / (x[j] - x[i])[apart])) if apart.any() else 0.0
