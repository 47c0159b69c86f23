"""Stiffness from a stress-strain curve: onset, modulus, interval and every other modulus, from one robust fit."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dynamics.compression import Geometry, StressStrain
from dynamics.errors import InvalidInput
from estimation.stiffness_fit import (
    BASELINE,
    COMPLIANCE,
    CURVE,
    MODULUS,
    ONSET,
    Fit,
    Prior,
    curve_of,
    predict,
    refine,
    scan_onset,
    slope_of,
    spread_of,
)

Array = NDArray[np.float64]

MIN_TICKS = 10  # steps of the reported opening that a modulus needs
MIN_READINGS = 5  # in contact
CONTACT_EVIDENCE = 8.0  # log-likelihood ratio of contact over none
MORE_EVIDENCE = 4.0  # log-likelihood that a curvature must gain beyond the information criterion
TWO_SIDED, ONE_SIDED = 1.96, 1.645  # of 95 %
DROP_TWO_SIDED, DROP_ONE_SIDED = 1.92, 1.353  # of the profile log-likelihood, for the same
WIDE = 0.25  # relative sd beyond which an interval comes from the profile


class NoContact(InvalidInput):
    """The force never rose: the pads did not touch, or touched something too soft to feel."""


class TooLittleCompression(InvalidInput):
    """The opening moved too few of its steps in contact to tell a modulus from quantisation.

    Attributes:
        estimate: what can still be said: a bound, the onset.
    """

    def __init__(self, where: str, found: object, valid: str, estimate: StiffnessEstimate) -> None:
        super().__init__(where, found, valid)
        self.estimate = estimate


@dataclass(frozen=True)
class CurveNoise:
    """What is known of the errors in a stress-strain curve.

    Attributes:
        stress_sd: of one stress reading that is no spike [Pa], a number or (N,).
        scale_known: False where only the shape of ``stress_sd`` is known; its scale is then estimated.
        strain_quantum: step of the strain [-]; 0 where it is continuous.
        baseline_sd: of the stress without contact, around 0 [Pa]; infinite where no tare was made.
        deadband, deadband_sd: stress that the gripper's friction swallows before any is reported [Pa].
        gain_sd: relative standard deviation common to every stress: of the force per ampere, of sizes.
    """

    stress_sd: float | Array
    scale_known: bool = True
    strain_quantum: float = 0.0
    baseline_sd: float = math.inf
    deadband: float = 0.0
    deadband_sd: float = 0.0
    gain_sd: float = 0.0

    def __post_init__(self) -> None:
        sd = np.asarray(self.stress_sd)
        if not (np.all(np.isfinite(sd)) and np.all(sd > 0)):
            raise InvalidInput("curve noise: stress_sd [Pa]", self.stress_sd, "finite numbers > 0")
        if not self.baseline_sd > 0:
            raise InvalidInput("curve noise: baseline_sd [Pa]", self.baseline_sd, "a number > 0")
        for name in ("strain_quantum", "deadband", "deadband_sd", "gain_sd"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0):
                raise InvalidInput(f"curve noise: {name}", value, "a finite number >= 0")


@dataclass(frozen=True)
class StiffnessEstimate:
    """A material's stiffness.

    The curve is S(h) = E (h + a2 h^2 + a3 h^3) over h(strain), strain counted from the onset; its degree is 1
    unless the readings call for more.

    Attributes:
        young_modulus: E, the slope at the onset [Pa]; NaN where only a bound is known.
        sd: its standard deviation with that of the calibration [Pa]; infinite where only a bound is known.
        reading_sd: the part of it that other readings of the same gripper would average out [Pa].
        interval: of 95 % [Pa]; its upper end is infinite where only a bound is known.
        bound: the modulus is at least this, with 95 % confidence [Pa]; None where a modulus is known.
        onset, onset_sd: opening at which the object was touched [m].
        compression: from the onset to the largest strain of the loading [m].
        spike_rate: estimated share of the readings that are spikes.
        weights: probability of each loading reading to be no spike, (N,).
        noise_sd: median standard deviation of a stress reading [Pa].
        fit: the fitted curve.
        geometry: how the curve was made.
    """

    young_modulus: float
    sd: float
    reading_sd: float
    interval: tuple[float, float]
    bound: float | None
    onset: float
    onset_sd: float
    compression: float
    spike_rate: float
    weights: Array
    noise_sd: float
    fit: Fit
    geometry: Geometry

    @property
    def max_strain(self) -> float:
        """Largest strain of the loading, from the onset [-]."""
        return self.compression / self.geometry.width

    @property
    def max_slope(self) -> float:
        """Largest tangent modulus over the strains that were reached [Pa]."""
        h = self.geometry.law_of(np.linspace(0.0, self.max_strain, 200))
        return float(np.max(slope_of(self.fit.parameters, h)))

    def stress(self, strain: float) -> float:
        """Return the curve's stress at a strain from the onset [Pa]."""
        return float(curve_of(self.fit.parameters, self._h(strain))[0])

    def tangent(self, strain: float) -> float:
        """Return the tangent modulus dS/dh at a strain from the onset [Pa]."""
        return float(slope_of(self.fit.parameters, self._h(strain))[0])

    def chord(self, a: float, b: float) -> float:
        """Return the chord modulus (S(b) - S(a)) / (h(b) - h(a)) between two strains from the onset [Pa].

        Raises:
            InvalidInput: if the strains are equal.
        """
        low, high = float(self._h(a)[0]), float(self._h(b)[0])
        if low == high:
            raise InvalidInput("chord modulus: strains", (a, b), "two different strains")
        return (self.stress(b) - self.stress(a)) / (high - low)

    def secant(self, strain: float) -> float:
        """Return the secant modulus S / h at a strain from the onset > 0 [Pa]."""
        return self.chord(0.0, strain)

    def tangent_sd(self, strain: float) -> float:
        """Return the standard deviation of the tangent modulus, with that of the calibration [Pa]."""
        h = float(self._h(strain)[0])
        x = self.fit.parameters
        row = np.zeros(len(x))
        row[MODULUS] = slope_of(x, np.array([h]))[0] / x[MODULUS]
        for power in range(2, 2 + len(x) - CURVE):
            row[CURVE + power - 2] = x[MODULUS] * power * h ** (power - 1)
        gain = self.tangent(strain) * self._gain_sd
        return math.sqrt(float(row @ self.fit.covariance @ row) + gain**2)

    @property
    def _gain_sd(self) -> float:
        if not math.isfinite(self.sd):
            return 0.0
        return math.sqrt(max(self.sd**2 - self.reading_sd**2, 0.0)) / self.young_modulus

    def _h(self, strain: float) -> Array:
        if not (math.isfinite(strain) and 0 <= strain < 1):
            raise InvalidInput("modulus: strain", strain, "a number in [0, 1)")
        return self.geometry.law_of(np.array([strain]))


def estimate_stiffness(
    curve: StressStrain,
    noise: CurveNoise | None = None,
    *,
    max_strain: float = 0.3,
    max_degree: int = 3,
    min_ticks: float = MIN_TICKS,
) -> StiffnessEstimate:
    """Estimate Young's modulus from the loading part of a stress-strain curve.

    The most probable curve of :mod:`estimation.stiffness_fit` under a mixture of noise and spikes. Its degree is
    the one with the least Bayesian information criterion. A series compliance c of gripper and pads, from the
    geometry, is part of the model, 1/E_apparent = 1/E + c, and its uncertainty part of the interval.

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
    if len(curve) < MIN_READINGS + 2:
        raise InvalidInput("stiffness: readings", len(curve), f"at least {MIN_READINGS + 2}")
    if not 1 <= max_degree <= 3:
        raise InvalidInput("stiffness: max_degree", max_degree, "1, 2 or 3")
    strain, stress, sd, noise = _loading(curve, noise)
    geometry = curve.geometry
    span = float(np.max(stress) - np.min(stress))
    if span == 0.0:
        raise NoContact("stiffness: stress", "the same value throughout", "a stress that rises in contact")
    start = np.concatenate([scan_onset(strain, stress, sd, geometry), [noise.deadband, 0.0]])
    keep = strain - start[ONSET] <= max_strain
    strain, stress, sd = strain[keep], stress[keep], sd[keep]
    baseline_sd = min(noise.baseline_sd, 0.25 * span + float(np.median(sd)))
    prior = Prior(
        np.array([0.0, 0.0, 0.0, noise.deadband, geometry.series_compliance]),
        np.array([baseline_sd, math.inf, math.inf, noise.deadband_sd, geometry.series_compliance_sd]),
    )
    if start[MODULUS] <= 0:
        raise NoContact("stiffness: stress", "no rise with compression", "a stress that rises in contact")
    apparent = refine(strain, stress, sd, geometry, start, _rigid(prior), scale_known=noise.scale_known)
    sd = np.hypot(sd, apparent.parameters[MODULUS] * noise.strain_quantum / math.sqrt(12.0) / apparent.scale)
    _check_contact(strain, stress, sd, geometry, apparent, noise)
    compression = float(np.max(strain) - apparent.parameters[ONSET]) * geometry.width
    _check_ticks(apparent, compression, geometry, noise, min_ticks, float(np.median(sd)))
    fit = _choose(strain, stress, sd, geometry, apparent, prior, noise.scale_known, max_degree)
    return _result(strain, stress, sd, geometry, fit, prior, noise)


def _loading(curve: StressStrain, noise: CurveNoise | None) -> tuple[Array, Array, Array, CurveNoise]:
    """Return strain, stress and stress sd of the loading, and the noise with what had to be guessed of it."""
    strain, stress = curve.strain, curve.stress
    if noise is None:
        span = float(np.max(stress) - np.min(stress))
        noise = CurveNoise(max(spread_of(stress), 1e-6 * span, 1e-12), False, quantum_of(strain))
    sd = np.broadcast_to(np.asarray(noise.stress_sd, dtype=np.float64), stress.shape)
    end = max(_end_of_loading(strain, stress), min(len(stress), MIN_READINGS + 2))
    return strain[:end], stress[:end], np.array(sd[:end]), noise


def _end_of_loading(strain: Array, stress: Array) -> int:
    """Return how many readings belong to the loading: up to the peak of stress near the largest strain."""
    middle = _running_median(strain, 5)
    span = float(np.max(middle) - np.min(middle))
    peak = int(np.argmax(middle))
    if middle[-1] > middle[peak] - 0.1 * span:
        return len(strain)  # it never opens again
    near = np.flatnonzero(middle >= middle[peak] - 0.1 * span)
    force = _running_median(stress, 5)
    return int(near[np.argmax(force[near])]) + 1


def quantum_of(series: Array) -> float:
    """Return the step of a quantised series, or 0 where its values lie on no common grid."""
    values = np.unique(series)
    if len(values) < 3:
        return float(values[-1] - values[0]) if len(values) == 2 else 0.0
    steps = np.diff(values)
    quantum = float(np.min(steps))
    if quantum <= 1e-9 * float(values[-1] - values[0]):
        return 0.0
    multiples = steps / quantum
    on_grid = bool(np.max(np.abs(multiples - np.round(multiples))) < 1e-3)
    return quantum if on_grid and len(values) < 0.7 * len(series) else 0.0


def _running_median(series: Array, width: int) -> Array:
    half = width // 2
    padded = np.concatenate([np.repeat(series[0], half), series, np.repeat(series[-1], half)])
    middle: Array = np.median(np.lib.stride_tricks.sliding_window_view(padded, width), axis=1)
    return middle


def _rigid(prior: Prior) -> Prior:
    """Return the prior without a series compliance."""
    mean, sd = prior.mean.copy(), prior.sd.copy()
    mean[COMPLIANCE] = sd[COMPLIANCE] = 0.0
    return Prior(mean, sd)


def _check_contact(
    strain: Array, stress: Array, sd: Array, geometry: Geometry, fit: Fit, noise: CurveNoise
) -> None:
    in_contact = strain > fit.parameters[ONSET]
    scaled = sd * fit.scale
    level = float(np.median(stress))
    without = np.minimum(0.5 * ((stress - level) / scaled) ** 2, 12.0)
    with_contact = np.minimum(0.5 * ((stress - predict(fit.parameters, strain, geometry)[0]) / scaled) ** 2, 12.0)
    evidence = float(np.sum(without - with_contact))
    if evidence < CONTACT_EVIDENCE or int(in_contact.sum()) < 2:
        raise NoContact(
            "stiffness: stress",
            f"a rise of evidence {evidence:.1f}",
            f"at least {CONTACT_EVIDENCE} over its noise",
        )
    onset = geometry.width * (1 - fit.parameters[ONSET])
    spread = geometry.width * math.sqrt(max(float(fit.covariance[ONSET, ONSET]), 0.0))
    if math.isfinite(spread) and onset - 3 * spread > 1.15 * geometry.width:
        raise InvalidInput(
            "stiffness: contact at the opening [m]",
            round(onset, 5),
            f"about the object's width, {geometry.width:g}",
        )


def _check_ticks(
    fit: Fit, compression: float, geometry: Geometry, noise: CurveNoise, min_ticks: float, sd: float
) -> None:
    quantum = noise.strain_quantum * geometry.width
    if quantum == 0 or compression >= min_ticks * quantum:
        return
    # At least the stress that was surely reached over at most the compression there can have been.
    rise = predict(
        fit.parameters, np.array([1.0 - (fit_onset(fit, geometry) - compression) / geometry.width]), geometry
    )
    stress = max(float(rise[0][0]) - fit.parameters[BASELINE] - ONE_SIDED * sd * fit.scale, 0.0)
    most = np.array([(max(compression, 0.0) + quantum) / geometry.width])
    common = math.hypot(noise.gain_sd, geometry.kappa_sd / geometry.kappa)
    bound = stress / float(geometry.law_of(most)[0]) * math.exp(-ONE_SIDED * common)
    estimate = StiffnessEstimate(
        young_modulus=math.nan,
        sd=math.inf,
        reading_sd=math.inf,
        interval=(bound, math.inf),
        bound=bound,
        onset=fit_onset(fit, geometry),
        onset_sd=math.hypot(geometry.width * math.sqrt(max(float(fit.covariance[ONSET, ONSET]), 0.0)), quantum),
        compression=compression,
        spike_rate=fit.spike_rate,
        weights=fit.weights,
        noise_sd=sd * fit.scale,
        fit=fit,
        geometry=geometry,
    )
    raise TooLittleCompression(
        "stiffness: compression in contact",
        f"{compression / quantum:.1f} steps of the opening",
        f"at least {min_ticks:g} steps; all that can be said is E >= {bound:.3g} Pa",
        estimate,
    )


def fit_onset(fit: Fit, geometry: Geometry) -> float:
    """Return the opening at which a fitted curve begins [m]."""
    return geometry.width * (1 - float(fit.parameters[ONSET]))


def _choose(
    strain: Array,
    stress: Array,
    sd: Array,
    geometry: Geometry,
    apparent: Fit,
    prior: Prior,
    scale_known: bool,
    max_degree: int,
) -> Fit:
    """Return the curve of the degree with the least information criterion."""
    count = int(np.sum(strain > apparent.parameters[ONSET]))
    best: Fit | None = None
    score = math.inf
    x = apparent.parameters.copy()
    c = prior.mean[COMPLIANCE]
    x[COMPLIANCE] = c
    if c > 0:  # 1/E = 1/E_apparent - c, kept away from where nothing is left of it
        x[MODULUS] = 1 / max(1 / x[MODULUS] - c, 0.02 / x[MODULUS])
    for degree in range(1, max_degree + 1):
        if degree > 1 and count < 6 * degree:
            break
        more = np.zeros(degree - 1)
        grown = Prior(
            np.concatenate([prior.mean, more]), np.concatenate([prior.sd, np.full(degree - 1, math.inf)])
        )
        fit = refine(
            strain, stress, sd, geometry, np.concatenate([x, more]), grown,
            scale_known=scale_known, scale=apparent.scale,
        )  # fmt: skip
        h = geometry.law_of(np.linspace(0, float(np.max(strain)) - fit.parameters[ONSET], 50))
        if degree > 1 and np.min(slope_of(fit.parameters, h)) <= 0:
            continue
        penalty = -fit.log_likelihood + 0.5 * (degree - 1) * math.log(max(len(strain), 2))
        if penalty < score - (MORE_EVIDENCE if degree > 1 else 0.0):
            best, score = fit, penalty
    assert best is not None  # degree 1 always scores
    return best


def _result(
    strain: Array, stress: Array, sd: Array, geometry: Geometry, fit: Fit, prior: Prior, noise: CurveNoise
) -> StiffnessEstimate:
    x, covariance = fit.parameters, fit.covariance
    modulus = float(x[MODULUS])
    reading = math.sqrt(max(float(covariance[MODULUS, MODULUS]), 0.0))
    reached = max(float(np.max(strain)) - float(x[ONSET]), 1e-12)
    common = math.hypot(noise.gain_sd, geometry.kappa_sd / geometry.kappa)
    # A staircase of k steps can tilt a line by 1/k^2: its error is no noise but follows the strain.
    steps = noise.strain_quantum / reached
    reading = math.hypot(reading, modulus * steps**2)
    relative = math.hypot(reading / modulus, common) if math.isfinite(reading) else math.inf
    interval = (modulus * math.exp(-TWO_SIDED * relative), modulus * math.exp(min(TWO_SIDED * relative, 700.0)))
    bound = None
    if relative > WIDE or geometry.series_compliance > 0:
        low, high, least = _profile(strain, stress, sd, geometry, fit, prior)
        low, high, least = (v * math.exp(s * TWO_SIDED * common) for v, s in ((low, -1), (high, 1), (least, -1)))
        interval = (low, high)
        if math.isinf(high):
            bound, interval = least, (least, math.inf)
    return StiffnessEstimate(
        young_modulus=modulus if bound is None else math.nan,
        sd=modulus * relative if bound is None else math.inf,
        reading_sd=reading if bound is None else math.inf,
        interval=interval,
        bound=bound,
        onset=geometry.width * (1 - float(x[ONSET])),
        onset_sd=geometry.width * math.sqrt(max(float(covariance[ONSET, ONSET]), 0.0)),
        compression=reached * geometry.width,
        spike_rate=fit.spike_rate,
        weights=fit.weights,
        noise_sd=float(np.median(sd)) * fit.scale,
        fit=fit,
        geometry=geometry,
    )


def _profile(
    strain: Array, stress: Array, sd: Array, geometry: Geometry, fit: Fit, prior: Prior
) -> tuple[float, float, float]:
    """Return the 95 % interval of the modulus and its one-sided lower bound, from the profile likelihood [Pa]."""
    degree = len(fit.parameters) - CURVE
    mean = np.concatenate([prior.mean, np.zeros(degree)])
    spread = np.concatenate([prior.sd, np.full(degree, math.inf)])
    spread[MODULUS] = 0.0
    start = fit.parameters.copy()

    def likelihood(modulus: float) -> float:
        mean[MODULUS] = start[MODULUS] = modulus
        known = Prior(mean, spread)
        return refine(strain, stress, sd * fit.scale, geometry, start, known, scale_known=True).log_likelihood

    def drop(modulus: float) -> float:
        return top - likelihood(modulus)

    top = likelihood(float(fit.parameters[MODULUS]))
    centre = float(fit.parameters[MODULUS])

    def edge(direction: float, level: float) -> float:
        inner, outer = 0.0, 0.05
        while drop(centre * math.exp(direction * outer)) < level:
            inner, outer = outer, outer * 2
            if outer > 12.0:
                return math.inf if direction > 0 else 0.0
        for _ in range(14):
            middle = (inner + outer) / 2
            if drop(centre * math.exp(direction * middle)) < level:
                inner = middle
            else:
                outer = middle
        return centre * math.exp(direction * outer)

    return edge(-1.0, DROP_TWO_SIDED), edge(1.0, DROP_TWO_SIDED), edge(-1.0, DROP_ONE_SIDED)
