"""Stiffness from a stress-strain curve: onset, modulus, interval and every other modulus, from one robust fit."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from dynamics.compression import StressStrain
from dynamics.errors import InvalidInput
from estimation.stiffness.estimate import NoContact, StiffnessEstimate, TooLittleCompression
from estimation.stiffness.fit import (
    BASELINE,
    COMPLIANCE,
    CURVE,
    MODULUS,
    ONSET,
    Fit,
    Prior,
    Readings,
    curve_of,
    marginalise,
    refine,
    scan_onset,
    slope_of,
)
from estimation.stiffness.noise import MIN_READINGS, CurveNoise, loading_of
from estimation.stiffness.profile import Profile, profile
from estimation.stiffness.strain import refine_with_strain

__all__ = ["CurveNoise", "NoContact", "StiffnessEstimate", "TooLittleCompression", "estimate_stiffness"]

Array = NDArray[np.float64]

MIN_TICKS = 10  # steps of the reported opening that a modulus needs
MIN_TOUCHING = 1.9  # readings that are no spikes, for contact to be believed
CONTACT_EVIDENCE = 5.0  # slope over its standard deviation, for the same
LAST, CLEAR_RISE = 5, 8.0  # readings at the end, and their stress over its noise, that are contact without a slope
CURVED_TICKS = 20  # steps of the opening that a curvature needs
MISFIT = 0.02  # of the largest stress, within which a line through 95 % of the readings is close enough to them
MORE_EVIDENCE = 7.0  # log-likelihood that each curvature must gain beyond the information criterion
READINGS_PER_CURVATURE = 10  # in contact
CURVED = (False, True)
CURVES = {  # which of the curvatures a2, a3 are tried, by the highest degree
    1: ((False, False),),
    2: ((False, False), (True, False)),
    3: ((False, False), (True, False), (False, True), (True, True)),
}
TWO_SIDED, ONE_SIDED = 1.96, 1.645  # of 95 %
WIDE = 0.25  # relative sd beyond which an interval comes from the profile
NOTHING_LEFT = 0.05  # of the largest strain, at least the object's in the start of a fit


def estimate_stiffness(
    curve: StressStrain,
    noise: CurveNoise | None = None,
    *,
    max_strain: float = 0.3,
    max_degree: int = 3,
    min_ticks: float = MIN_TICKS,
) -> StiffnessEstimate:
    """Estimate Young's modulus from the loading part of a stress-strain curve.

    The most probable curve of :mod:`estimation.stiffness.fit` under a mixture of noise and spikes: a line, or one
    with curvature where the Bayesian information criterion calls for it, and some more evidence with it. A series
    compliance c of gripper and pads, from the geometry, is part of the model, 1/E_apparent = 1/E + c, and its
    uncertainty part of the interval.

    Args:
        curve: in the order it was read; unloading may follow, readings before contact should precede.
        noise: of the readings; None to estimate it from them.
        max_strain: strain from the onset to use at most.
        max_degree: of the curve, 1 to 3.
        min_ticks: steps of the opening, in contact, below which no modulus is given.

    Raises:
        NoContact: if the stress never rises above its noise.
        TooLittleCompression: if the opening moved less than ``min_ticks`` steps in contact.
        InvalidInput: for too few readings, or contact at an opening larger than the object.
    """
    if len(curve) < MIN_READINGS:
        raise InvalidInput("stiffness: readings", len(curve), f"at least {MIN_READINGS}")
    if not 1 <= max_degree <= 3:
        raise InvalidInput("stiffness: max_degree", max_degree, "1, 2 or 3")
    if np.ptp(curve.strain) == 0.0:
        raise NoContact("stiffness: opening", "the same value throughout", "an opening that closes on the object")
    loading = loading_of(curve, noise)
    noise, geometry = loading.noise, curve.geometry
    span = float(np.max(loading.stress) - np.min(loading.stress))
    if span == 0.0:
        raise NoContact("stiffness: stress", "the same value throughout", "a stress that rises in contact")
    readings = Readings(loading.strain, loading.stress, loading.stress_sd, geometry, loading.strain)
    start = np.concatenate([scan_onset(readings), [noise.deadband, 0.0]])
    if start[MODULUS] <= 0:
        raise NoContact("stiffness: stress", "no rise with compression", "a stress that rises in contact")
    readings = _first(readings, loading.strain - start[ONSET] <= max_strain)
    baseline_sd = min(noise.baseline_sd, 0.25 * span + float(np.median(readings.sd)))
    prior = Prior(
        np.array([0.0, noise.onset, 0.0, noise.deadband, geometry.series_compliance]),
        np.array([baseline_sd, noise.onset_sd, math.inf, noise.deadband_sd, 0.0]),
    )
    if loading.renewed_late:
        readings, apparent = refine_with_strain(readings, start, _rigid(prior))
    else:
        readings = replace(readings, strain_sd=noise.strain_quantum / math.sqrt(12.0))
        apparent = refine(readings, start, _rigid(prior), scale_known=noise.scale_known)
    _check_contact(readings, apparent)
    reached = float(np.max(readings.true_strain) - apparent.parameters[ONSET])
    _check_ticks(readings, apparent, reached, noise, min_ticks)
    if noise.strain_quantum * CURVED_TICKS > reached or loading.renewed_late:
        max_degree = 1
    fit, prior, bent = _choose(readings, apparent, prior, noise.scale_known, max_degree)
    if geometry.series_compliance == 0:
        fit = marginalise(fit, readings, prior)
    return _result(readings, fit, prior, bent, noise, apparent)


def _first(readings: Readings, keep: NDArray[np.bool_]) -> Readings:
    """Return some of the readings."""
    return Readings(
        readings.strain[keep],
        readings.stress[keep],
        readings.sd[keep],
        readings.geometry,
        readings.true_strain[keep],
    )


def _rigid(prior: Prior) -> Prior:
    """Return the prior without a series compliance."""
    mean, sd = prior.mean.copy(), prior.sd.copy()
    mean[COMPLIANCE] = sd[COMPLIANCE] = 0.0
    return Prior(mean, sd)


def _grown(prior: Prior, curvatures: tuple[bool, bool]) -> Prior:
    """Return a prior with curvatures a2 and a3 that are unknown, or 0."""
    return Prior(
        np.concatenate([prior.mean, np.zeros(2)]),
        np.concatenate([prior.sd, [math.inf if free else 0.0 for free in curvatures]]),
    )


def _check_contact(readings: Readings, fit: Fit) -> None:
    touching = float(np.sum(fit.weights[readings.true_strain > fit.parameters[ONSET]]))
    modulus, spread = float(fit.parameters[MODULUS]), math.sqrt(max(float(fit.covariance[MODULUS, MODULUS]), 0.0))
    rise = float(np.median(readings.stress[-LAST:]) - fit.parameters[BASELINE])
    rose = rise > CLEAR_RISE * float(np.median(readings.sd)) * fit.scale
    if not rose and (touching < MIN_TOUCHING or not modulus > CONTACT_EVIDENCE * spread):
        raise NoContact(
            "stiffness: stress",
            f"a slope of {modulus:.3g} +- {spread:.3g} Pa over {touching:.0f} readings",
            f"a slope over {CONTACT_EVIDENCE:g} times its uncertainty, over 2 readings or more",
        )
    width = readings.geometry.width
    onset, onset_sd = width * (1 - fit.parameters[ONSET]), _onset_sd(fit, width)
    if math.isfinite(onset_sd) and onset - 3 * onset_sd > 1.15 * width:
        raise InvalidInput(
            "stiffness: contact at the opening [m]", round(float(onset), 5), f"about the object's width, {width:g}"
        )


def _onset_sd(fit: Fit, width: float) -> float:
    return width * math.sqrt(max(float(fit.covariance[ONSET, ONSET]), 0.0))


def _check_ticks(readings: Readings, fit: Fit, reached: float, noise: CurveNoise, min_ticks: float) -> None:
    if noise.strain_quantum == 0 or reached >= min_ticks * noise.strain_quantum:
        return
    geometry = readings.geometry
    # At least the stress that was surely reached, over at most the compression there can have been.
    sd = float(np.median(readings.sd)) * fit.scale
    top = int(np.argmax(readings.true_strain))
    stress = float(readings.predict(fit.parameters)[0][top] - fit.parameters[BASELINE]) - ONE_SIDED * sd
    most = np.array([max(reached, 0.0) + noise.strain_quantum])
    common = math.hypot(noise.gain_sd, geometry.kappa_sd / geometry.kappa)
    bound = max(stress, 0.0) / float(geometry.law_of(most)[0]) * math.exp(-ONE_SIDED * common)
    estimate = StiffnessEstimate(
        young_modulus=math.nan,
        sd=math.inf,
        reading_sd=math.inf,
        interval=(bound, math.inf),
        bound=bound,
        onset=geometry.width * (1 - float(fit.parameters[ONSET])),
        onset_sd=math.hypot(_onset_sd(fit, geometry.width), noise.strain_quantum * geometry.width),
        compression=reached * geometry.width,
        spike_rate=fit.spike_rate,
        weights=fit.weights,
        noise_sd=sd,
        fit=fit,
        curve=fit,
        geometry=geometry,
    )
    raise TooLittleCompression(
        "stiffness: compression in contact",
        f"{reached / noise.strain_quantum:.1f} steps of the opening",
        f"at least {min_ticks:g} steps; all that can be said is E >= {bound:.3g} Pa",
        estimate,
    )


def _choose(
    readings: Readings, apparent: Fit, prior: Prior, scale_known: bool, max_degree: int
) -> tuple[Fit, Prior, Fit]:
    """Return the fit with the least information criterion, the prior it was fitted with, and a curved fit."""
    geometry = readings.geometry
    reached = float(np.max(readings.true_strain))
    count = int(np.sum(readings.true_strain > apparent.parameters[ONSET]))
    x = _without_gripper(readings, apparent, float(prior.mean[COMPLIANCE]))
    best: tuple[Fit, Prior] | None = None
    curve: Fit | None = None
    score, straight_enough = math.inf, False
    for curvatures in CURVES[max_degree]:
        free = sum(curvatures)
        if count < READINGS_PER_CURVATURE * free:
            continue
        grown = _grown(prior, curvatures)
        fit = refine(readings, x, grown, scale_known=scale_known, scale=apparent.scale)
        h = geometry.law_of(np.linspace(0, reached - fit.parameters[ONSET], 50))
        if free and np.min(slope_of(fit.parameters, h)) <= 0:
            continue
        criterion = -fit.log_likelihood + free * (0.5 * math.log(len(readings)) + MORE_EVIDENCE)
        if criterion < score and not straight_enough:
            best, score = (fit, grown), criterion
        if not free:
            left = np.abs(readings.stress - readings.predict(fit.parameters)[0])
            straight_enough = bool(np.quantile(left, 0.95) <= MISFIT * np.max(np.abs(readings.stress)))
        if curvatures == CURVED:
            curve = fit
    assert best is not None  # the straight line always scores
    straight = best[1].sd[CURVE:].max() == 0
    return *best, (curve if straight and curve is not None else best[0])


def _without_gripper(readings: Readings, apparent: Fit, compliance: float) -> Array:
    """Return where to start with a series compliance: what is left of the largest strain is the object's, (7,)."""
    x = np.concatenate([apparent.parameters, np.zeros(2)])
    x[COMPLIANCE] = compliance
    if compliance > 0:
        reached = np.array([float(np.max(readings.true_strain)) - x[ONSET]])
        stress = float(curve_of(x, readings.geometry.law_of(reached))[0])
        left = np.maximum(reached - compliance * stress, NOTHING_LEFT * reached)
        x[MODULUS] = stress / float(readings.geometry.law_of(left)[0])
    return x


def _result(
    readings: Readings, fit: Fit, prior: Prior, bent: Fit, noise: CurveNoise, apparent: Fit
) -> StiffnessEstimate:
    geometry = readings.geometry
    common = math.hypot(noise.gain_sd, geometry.kappa_sd / geometry.kappa)
    modulus = float(fit.parameters[MODULUS])
    student = _student(float(fit.weights.sum()) - float((prior.sd > 0).sum()))
    reached = max(float(np.max(readings.true_strain)) - float(fit.parameters[ONSET]), 1e-12)
    # The error of a staircase is no noise but follows the strain: over k steps of sd q/sqrt(12) each, a line tilts
    # by sqrt(12) / sqrt(k) (q/sqrt(12)) / (k q) = k^-1.5.
    tilt = (noise.strain_quantum / reached) ** 1.5
    relative = reading = math.hypot(_log_sd(fit) * student, tilt)
    bound = None
    if relative > WIDE or geometry.series_compliance > 0:
        found, softer, stiffer = _profiles(readings, fit.scale, prior, apparent)
        if math.isinf(found.high) or math.isinf(stiffer) or found.low == 0.0:
            bound = _bound(found, softer, apparent, student, math.hypot(tilt, common))
        else:
            fit, modulus = found.fit, found.modulus
            reading = math.hypot(math.log(found.high / found.low) / (2 * TWO_SIDED) * student, tilt)
            relative = math.hypot(reading, math.log(stiffer / softer) / (2 * TWO_SIDED))
    relative = math.hypot(relative, common)
    interval = (modulus * math.exp(-TWO_SIDED * relative), modulus * math.exp(min(TWO_SIDED * relative, 700.0)))
    return StiffnessEstimate(
        young_modulus=modulus if bound is None else math.nan,
        sd=modulus * relative if bound is None else math.inf,
        reading_sd=modulus * reading if bound is None else math.inf,
        interval=interval if bound is None else (bound, math.inf),
        bound=bound,
        onset=geometry.width * (1 - float(fit.parameters[ONSET])),
        onset_sd=_onset_sd(fit, geometry.width),
        compression=reached * geometry.width,
        spike_rate=fit.spike_rate,
        weights=fit.weights,
        noise_sd=float(np.median(readings.sd)) * fit.scale,
        fit=fit,
        curve=bent,
        geometry=geometry,
    )


def _profiles(readings: Readings, scale: float, prior: Prior, apparent: Fit) -> tuple[Profile, float, float]:
    """Return the profile at the series compliance, and the moduli at the ends of its own 95 % interval [Pa].

    The compliance is one of all squeezes with this gripper: none of them may bend it to its own readings.
    """
    geometry = readings.geometry
    c, margin = geometry.series_compliance, TWO_SIDED * geometry.series_compliance_sd

    def at(compliance: float, *, peak_only: bool) -> Profile:
        mean = prior.mean.copy()
        mean[COMPLIANCE] = compliance
        start = _without_gripper(readings, apparent, compliance)
        return profile(readings, scale, Prior(mean, prior.sd), start, peak_only=peak_only)

    found = at(c, peak_only=False)
    if margin == 0:
        return found, found.modulus, found.modulus
    stiffer = at(c + margin, peak_only=True)
    softer = at(max(c - margin, 0.0), peak_only=True).modulus
    return found, softer, math.inf if stiffer.open_ended else stiffer.modulus


def _bound(found: Profile, softer: float, apparent: Fit, student: float, common: float) -> float:
    """Return what the modulus is at least, with 95 % confidence [Pa].

    It is at least that of object, gripper and pads in series.
    """
    app = float(apparent.parameters[MODULUS])
    series = app * math.exp(-ONE_SIDED * math.hypot(_log_sd(apparent) * student, common))
    if found.least == 0.0:
        return series
    spread = math.hypot(math.log(found.modulus / found.least) * student, math.log(found.modulus / softer), common)
    return max(series, found.modulus * math.exp(-spread))


def _log_sd(fit: Fit) -> float:
    """Return the standard deviation of the log of the modulus that the readings leave."""
    variance = float(fit.covariance[MODULUS, MODULUS])
    return math.sqrt(max(variance, 0.0)) / float(fit.parameters[MODULUS])


def _student(freedom: float) -> float:
    """Return how much wider Student's 95 % interval is than a Gaussian's (Abramowitz and Stegun, 26.7.5)."""
    nu, z = max(freedom, 1.0), TWO_SIDED
    return 1 + (z**2 + 1) / (4 * nu) + (5 * z**4 + 16 * z**2 + 3) / (96 * nu**2)
