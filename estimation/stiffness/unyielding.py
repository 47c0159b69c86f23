"""What is known of an object that hardly gives: a bound of its modulus, and where it was touched."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from dynamics.compression import Geometry
from estimation.stiffness.estimate import StiffnessEstimate
from estimation.stiffness.fit import COMPLIANCE, DEADBAND, MODULUS, ONSET, Fit
from estimation.stiffness.noise import CurveNoise

Array = NDArray[np.float64]

PRESSING = 5.0  # force over its noise that is contact
FEW_STEPS = 2.5  # of the opening, within which no line through the readings tells a modulus
FEWEST, ENDS = 3, 5  # readings that press; smallest and largest forces of them that tell how much it rose, at most
ONE_SIDED = 1.645  # standard deviations of a bound of 95 %


def hardly_gives(
    opening: Array,
    force: Array,
    force_sd: Array,
    quantum: float,
    geometry: Geometry,
    noise: CurveNoise,
    steps: float = FEW_STEPS,
) -> StiffnessEstimate | None:
    """Return the bound that readings of an object give which yields by two steps of the opening at most.

    Half a step at either end may be anything, so no line through such readings tells a modulus. What is sure is
    that the force rose from F_low to F_high over no more than the steps that were seen and one:
    E >= (F_high - F_low - 1.645 sd) / (A h(u_most / L)).

    Args:
        opening: as reported by closing pads [m], (N,).
        force, force_sd: of a pad, and the noise of it [N], (N,).
        quantum: step of the opening [m]; 0 where it is not reported in steps.
        geometry: of the object between the pads.
        noise: gives the relative standard deviation of the calibration.
        steps: of the opening, by which an object may yield at most.

    Returns:
        None for an object that gives more, that was hardly pressed, or without steps.
    """
    pressing = force > PRESSING * force_sd
    if quantum == 0 or pressing.sum() < FEWEST:
        return None
    order = np.argsort(force[pressing])
    opening, force, force_sd = opening[pressing][order], force[pressing][order], force_sd[pressing][order]
    give = float(np.ptp(opening))
    if give > steps * quantum:
        return None
    ends = min(ENDS, len(force) // 2)
    rise = float(np.median(force[-ends:]) - np.median(force[:ends]))
    sd = math.hypot(float(np.median(force_sd[-ends:])), float(np.median(force_sd[:ends])))
    most = float(geometry.law_of(np.array([(give + quantum) / geometry.width]))[0])
    common = math.hypot(noise.gain_sd, geometry.kappa_sd / geometry.kappa)
    bound = max(rise - ONE_SIDED * sd, 0.0) / geometry.area / most * math.exp(-ONE_SIDED * common)
    onset = float(opening.max())
    parameters = np.zeros(5)
    parameters[[ONSET, MODULUS, DEADBAND, COMPLIANCE]] = (
        1 - onset / geometry.width,
        bound,
        noise.deadband,
        geometry.series_compliance,
    )
    weights = np.ones(len(force))
    line = Fit(parameters, np.diag(np.full(5, math.inf)), 1.0, weights, 0.0, 1.0, -math.inf)
    return StiffnessEstimate(
        young_modulus=math.nan,
        sd=math.inf,
        reading_sd=math.inf,
        interval=(bound, math.inf),
        bound=bound,
        onset=onset,
        onset_sd=quantum,
        compression=give,
        spike_rate=0.0,
        weights=weights,
        noise_sd=float(np.median(force_sd)) / geometry.area,
        fit=line,
        curve=line,
        geometry=geometry,
    )
