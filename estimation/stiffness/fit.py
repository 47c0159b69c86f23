"""The robust fit of a stress-strain curve that starts somewhere and has spikes.

    stress_i = b + max(0, S(h(s_i)) - d) + noise,      s_i = strain_i - onset - c max(0, S - d)
    S(h) = E (h + a2 h^2 + a3 h^3)

with baseline b, onset, modulus E, curvature a2 and a3, the stress d that the gripper's friction swallows, and the
series compliance c. Noise is a mixture of a narrow and a wide Gaussian: a spike costs little, wherever it is.
First the onset is scanned (a robust hinge for each candidate), then all parameters are refined together.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dynamics.compression import Geometry

Array = NDArray[np.float64]

SPIKE_SCALE = 15.0  # a spike's standard deviation over the noise's, at least
SPIKE_RATE = 0.05  # where the rate's estimate starts
SCAN = 72  # candidate onsets
SCAN_NOISE = 5e-3  # of the stress range, at least
SCAN_ROUNDS = 12  # reweightings per candidate
ROUNDS = 60  # refinements at most
SCALE_ROUNDS = 12  # of the noise's scale
MARGINAL_POINTS = 41  # onsets
CAUCHY = 2.385  # 95 % efficient on Gaussian noise

BASELINE, ONSET, MODULUS, DEADBAND, COMPLIANCE, CURVE = 0, 1, 2, 3, 4, 5


@dataclass(frozen=True)
class Readings:
    """What a curve is fitted to.

    Attributes:
        strain, stress: as read, (N,).
        sd: of the stress readings that are no spikes, up to a common scale [Pa], (N,).
        geometry: gives the law of the contact.
        true_strain: where the curve is evaluated, (N,): the strain, or where its errors matter the best guess of
            what it truly was. The curve is carried on to the strain along its tangent there.
        strain_sd: of the strain readings [-]; it counts as stress along the curve's slope.
    """

    strain: Array
    stress: Array
    sd: Array
    geometry: Geometry
    true_strain: Array
    strain_sd: float = 0.0

    def __len__(self) -> int:
        return len(self.strain)

    def predict(self, parameters: Array) -> tuple[Array, Array]:
        """Return the predicted stress and its derivatives by the parameters, (N,) and (N, 5 + k)."""
        stress, jacobian = predict(parameters, self.true_strain, self.geometry)
        return stress - jacobian[:, ONSET] * (self.strain - self.true_strain), jacobian

    def noise(self, jacobian: Array, scale: float) -> Array:
        """Return the standard deviation of the stress readings, with that of the strain in it [Pa], (N,)."""
        return np.hypot(scale * self.sd, jacobian[:, ONSET] * self.strain_sd)


@dataclass(frozen=True)
class Prior:
    """Independent Gaussian knowledge of parameters from elsewhere.

    Attributes:
        mean, sd: of baseline, onset, modulus, deadband, compliance, curvature..., (5 + k,); sd infinite where
            nothing is known and 0 where the value is fixed.
    """

    mean: Array
    sd: Array


@dataclass(frozen=True)
class Fit:
    """A fitted curve.

    Attributes:
        parameters: baseline [Pa], onset [-], modulus [Pa], deadband [Pa], compliance [1/Pa], a2, a3 [-], (5 + k,).
        covariance: of the parameters; 0 for fixed ones.
        scale: the noise's estimated scale, multiplying the sd it was given.
        weights: probability of each reading to be no spike, (N,).
        spike_rate: estimated share of spikes.
        spike_scale: their standard deviation over the noise's.
        log_likelihood: of the readings, with the prior.
    """

    parameters: Array
    covariance: Array
    scale: float
    weights: Array
    spike_rate: float
    spike_scale: float
    log_likelihood: float


def curve_of(parameters: Array, h: Array) -> Array:
    """Return S(h), the material's stress [Pa], (N,)."""
    curve = h.copy()
    for power, a in enumerate(parameters[CURVE:], start=2):
        curve += a * h**power
    stress: Array = parameters[MODULUS] * curve
    return stress


def slope_of(parameters: Array, h: Array) -> Array:
    """Return dS/dh, the material's modulus [Pa], (N,)."""
    slope = np.ones_like(h)
    for power, a in enumerate(parameters[CURVE:], start=2):
        slope += power * a * h ** (power - 1)
    modulus: Array = parameters[MODULUS] * slope
    return modulus


def predict(parameters: Array, strain: Array, geometry: Geometry) -> tuple[Array, Array]:
    """Return the predicted stress and its derivatives by the parameters, (N,) and (N, 5 + k)."""
    onset, deadband, compliance = parameters[ONSET], parameters[DEADBAND], parameters[COMPLIANCE]
    total = strain - onset
    s = total.copy()
    if compliance > 0:
        # s + c max(0, S(h(s)) - d) = total grows with s: bracketed by [0, total], Newton kept inside.
        low, high = np.zeros_like(s), np.maximum(total, 0.0)
        s = high.copy()
        for _ in range(40):
            h = geometry.law_of(s)
            excess = s + compliance * np.maximum(curve_of(parameters, h) - deadband, 0.0) - high
            above = excess > 0
            low, top = np.where(above, low, s), np.where(above, s, np.maximum(total, 0.0))
            rise = 1 + compliance * slope_of(parameters, h) * geometry.slope_of_law(s)
            step = s - excess / np.maximum(rise, 1e-9)
            new = np.where((step >= low) & (step <= top), step, (low + top) / 2)
            if np.max(np.abs(new - s), initial=0.0) < 1e-12:
                s = new
                break
            s = new
    h = geometry.law_of(s)
    touching = (total > 0) & (curve_of(parameters, h) > deadband)
    rise = slope_of(parameters, h) * geometry.slope_of_law(s)  # dS/ds
    gain = np.where(touching, 1 / (1 + compliance * rise), 0.0)
    stress = np.where(touching, curve_of(parameters, h) - deadband, 0.0)
    jacobian = np.zeros((len(strain), len(parameters)))
    jacobian[:, BASELINE] = 1.0
    jacobian[:, ONSET] = -gain * rise
    jacobian[:, MODULUS] = gain * curve_of(parameters, h) / parameters[MODULUS]
    jacobian[:, DEADBAND] = -gain
    jacobian[:, COMPLIANCE] = -gain * rise * stress
    for power in range(2, 2 + len(parameters) - CURVE):
        jacobian[:, CURVE + power - 2] = gain * parameters[MODULUS] * h**power
    return parameters[BASELINE] + stress, jacobian


def scan_onset(readings: Readings) -> Array:
    """Return a start for the refinement: the onset of the best robust hinge, with its baseline and modulus.

    Every candidate onset gets its own Cauchy-weighted line over h; the one with the least robust loss wins.
    """
    strain, stress, geometry = readings.true_strain, readings.stress, readings.geometry
    # Between two candidates a hinge misses clean readings by more than their noise.
    sd = np.maximum(readings.sd, SCAN_NOISE * _range(stress))
    low, high = np.min(strain), np.max(strain)
    span = high - low
    candidates = np.linspace(low - 0.02 * span, low + 0.9 * span, SCAN)
    h = np.stack([geometry.law_of(strain - onset) for onset in candidates])  # (G, N)
    weights = np.ones_like(h) / sd**2
    baseline, modulus = np.zeros(SCAN), np.zeros(SCAN)
    loss = np.zeros(SCAN)
    for _ in range(SCAN_ROUNDS):
        total = weights.sum(axis=1)
        mean_h, mean_y = (weights * h).sum(axis=1) / total, (weights * stress).sum(axis=1) / total
        offset = h - mean_h[:, None]
        spread = (weights * offset**2).sum(axis=1)
        modulus = (weights * offset * (stress - mean_y[:, None])).sum(axis=1) / np.maximum(spread, 1e-300)
        baseline = mean_y - modulus * mean_h
        scaled = ((stress - baseline[:, None] - modulus[:, None] * h) / sd / CAUCHY) ** 2
        weights = 1 / (1 + scaled) / sd**2
        loss = np.log1p(scaled).sum(axis=1)
    loss = np.where(modulus > 0, loss, np.inf)
    best = int(np.argmin(loss))
    if not np.isfinite(loss[best]):
        return np.array([float(np.median(stress)), high, 0.0])
    return np.array([baseline[best], candidates[best], modulus[best]])


def refine(readings: Readings, start: Array, prior: Prior, *, scale_known: bool, scale: float = 1.0) -> Fit:
    """Return the most probable curve, by expectation-maximisation with Levenberg's damped Gauss-Newton steps.

    Args:
        readings: to fit.
        start: parameters to start at, (5 + k,).
        prior: of the parameters.
        scale_known: whether the readings' sd is the noise or only its shape.
        scale: the scale to start at.
    """
    stress = readings.stress
    free = prior.sd > 0
    information = np.where(np.isfinite(prior.sd) & free, 1 / np.where(free, prior.sd, 1.0) ** 2, 0.0)
    x = np.where(free, start, prior.mean)
    rate, spike = SPIKE_RATE, SPIKE_SCALE
    floor = 1e-6 * max(float(np.max(np.abs(stress))), 1e-12) / float(np.median(readings.sd))
    n = len(readings)
    if not scale_known:  # starts wide: a start that is a little off must not take all the readings for spikes
        scale = max(scale, SCAN_NOISE * _range(stress) / float(np.median(readings.sd)))

    def loss(trial: Array) -> tuple[float, Array, Array]:
        predicted, jacobian = readings.predict(trial)
        value = -_log_density((stress - predicted) / sd, rate, spike).sum()
        return value + 0.5 * float((information * (trial - prior.mean) ** 2).sum()), stress - predicted, jacobian

    predicted, jacobian = readings.predict(x)
    residual = stress - predicted
    damping = 1e-3
    used = float(free.sum())  # degrees of freedom that the readings, not the prior, decide
    for step in range(ROUNDS):
        sd = readings.noise(jacobian, scale)
        weights = _inlier(residual / sd, rate, spike)
        if step < ROUNDS - 5:
            spike = _spike_scale(residual / sd, weights)
            rate = min(max((float((1 - weights).sum()) + 0.5) / (n + 20.0), 1e-3), 0.45)
            if not scale_known and step < SCALE_ROUNDS:
                # Parameters cost degrees of freedom, the spikes' rate one more: without, small samples would be
                # over-confident.
                dof = max(float(weights.sum()) - used - 1.0, 1.0)
                scale = max(scale * math.sqrt(float((weights * (residual / sd) ** 2).sum()) / dof), floor)
                sd = readings.noise(jacobian, scale)
        value, residual, jacobian = loss(x)
        w = (weights + (1 - weights) / spike**2) / sd**2
        hessian = (jacobian.T * w) @ jacobian + np.diag(information)
        used = _decided((jacobian.T * w) @ jacobian, hessian, free)
        gradient = jacobian.T @ (w * residual) - information * (x - prior.mean)
        moved = False
        for _ in range(12):
            trial = x + _solve(hessian, gradient, free, damping)
            if trial[MODULUS] > 0:
                new, new_residual, new_jacobian = loss(trial)
                if new <= value + 1e-12 * abs(value):
                    moved = value - new > 1e-9 * (1 + abs(value))
                    x, residual, jacobian = trial, new_residual, new_jacobian
                    damping = max(damping / 5, 1e-9)
                    break
            damping *= 5
        if not moved and step > SCALE_ROUNDS:
            break
    sd = readings.noise(jacobian, scale)
    weights = _inlier(residual / sd, rate, spike)
    w = (weights + (1 - weights) / spike**2) / sd**2
    # Louis: what is not known of the spikes is taken off the information.
    missing = weights * (1 - weights) * (residual / sd * (1 - 1 / spike**2)) ** 2 / sd**2
    covariance = _invert((jacobian.T * (w - missing)) @ jacobian + np.diag(information), free)
    if covariance is None:
        covariance = _invert((jacobian.T * w) @ jacobian + np.diag(information), free)
    if covariance is None:
        covariance = np.full((len(x), len(x)), np.inf)
    likelihood = float(_log_density(residual / sd, rate, spike).sum() - np.log(sd).sum())
    penalty = 0.5 * float((information * (x - prior.mean) ** 2).sum())
    return Fit(x, covariance, scale, weights, rate, spike, likelihood - penalty)


def marginalise(fit: Fit, readings: Readings, prior: Prior, reach: float = 5.0) -> Fit:
    """Return a fit with the mean and covariance of its parameters over every onset that the readings allow.

    A hinge is not linear in its onset, so the curvature at the best one understates what is not known. Each onset
    of a grid gets the best other parameters, by two Gauss-Newton steps, and counts with its probability.
    """
    spread = math.sqrt(max(float(fit.covariance[ONSET, ONSET]), 0.0))
    if not (math.isfinite(spread) and spread > 0):
        return fit
    stress = readings.stress
    sd = readings.noise(readings.predict(fit.parameters)[1], fit.scale)
    w = (fit.weights + (1 - fit.weights) / fit.spike_scale**2) / sd**2
    fixed = Prior(prior.mean, prior.sd.copy())
    fixed.sd[ONSET] = 0.0
    free = fixed.sd > 0
    information = np.where(np.isfinite(fixed.sd) & free, 1 / np.where(free, fixed.sd, 1.0) ** 2, 0.0)
    means, covariances, logs = [], [], []
    onset_information = 1 / prior.sd[ONSET] ** 2
    for offset in np.linspace(-reach, reach, MARGINAL_POINTS):
        x = fit.parameters.copy()
        x[ONSET] += offset * spread
        x[MODULUS] += fit.covariance[MODULUS, ONSET] / spread * offset
        x[MODULUS] = max(x[MODULUS], 0.05 * fit.parameters[MODULUS])
        hessian = np.eye(len(x))
        for _ in range(2):
            predicted, jacobian = readings.predict(x)
            hessian = (jacobian.T * w) @ jacobian + np.diag(information)
            gradient = jacobian.T @ (w * (stress - predicted)) - information * (x - prior.mean)
            x = x + _solve(hessian, gradient, free, 1e-9)
            x[MODULUS] = max(x[MODULUS], 0.05 * fit.parameters[MODULUS])
        covariance = _invert(hessian, free)
        if covariance is None:
            continue
        residual = (stress - readings.predict(x)[0]) / sd
        penalty = 0.5 * float((information * (x - prior.mean) ** 2).sum())
        penalty += 0.5 * onset_information * (x[ONSET] - prior.mean[ONSET]) ** 2
        volume = covariance[np.ix_(np.flatnonzero(free), np.flatnonzero(free))]
        log = (
            float(_log_density(residual, fit.spike_rate, fit.spike_scale).sum())
            - penalty
            + 0.5 * float(np.linalg.slogdet(volume)[1])
        )
        means.append(x)
        covariances.append(covariance)
        logs.append(log)
    if len(logs) < MARGINAL_POINTS // 2:
        return fit
    share = np.exp(np.array(logs) - max(logs))
    share /= share.sum()
    mean = share @ np.array(means)
    apart = np.array(means) - mean
    covariance = np.einsum("g,gij->ij", share, np.array(covariances)) + (apart.T * share) @ apart
    return Fit(mean, covariance, fit.scale, fit.weights, fit.spike_rate, fit.spike_scale, fit.log_likelihood)


def _range(stress: Array) -> float:
    """Return the range of the stress but for its extremes [Pa]."""
    return float(np.subtract(*np.percentile(stress, [95, 5])))


def _decided(readings: Array, hessian: Array, free: NDArray[np.bool_]) -> float:
    """Return how many parameters the readings decide, the trace of their share of the information."""
    at = np.flatnonzero(free)
    h = hessian[np.ix_(at, at)]
    size = _scale(h)
    scale = np.outer(size, size)
    share = np.linalg.lstsq(h / scale, readings[np.ix_(at, at)] / scale, rcond=None)[0]
    return float(np.trace(share))


def _log_density(z: Array, rate: float, spike: float) -> Array:
    """Return the mixture's log density at standardised residuals, (N,)."""
    narrow = math.log1p(-rate) - 0.5 * z**2
    wide = math.log(rate / spike) - 0.5 * (z / spike) ** 2
    value: Array = np.logaddexp(narrow, wide) - 0.5 * math.log(2 * math.pi)
    return value


def _inlier(z: Array, rate: float, spike: float) -> Array:
    """Return each reading's probability of being no spike, (N,)."""
    odds = math.log(rate / spike / (1 - rate)) + 0.5 * z**2 * (1 - 1 / spike**2)
    probability: Array = 1 / (1 + np.exp(np.minimum(odds, 700.0)))
    return probability


def _spike_scale(z: Array, weights: Array) -> float:
    """Return the spikes' standard deviation over the noise's: a huge spike must not pull like a small one."""
    share = 1 - weights
    return max(math.sqrt(float((share * z**2).sum()) / max(float(share.sum()), 1e-9)), SPIKE_SCALE)


def _solve(hessian: Array, gradient: Array, free: NDArray[np.bool_], damping: float) -> Array:
    """Return the damped step of the free parameters, scaled by the Hessian's diagonal."""
    at = np.flatnonzero(free)
    h, g = hessian[np.ix_(at, at)], gradient[at]
    size = _scale(h)
    scaled = h / np.outer(size, size) + damping * np.eye(len(at))
    move = np.zeros(len(gradient))
    move[at] = np.linalg.lstsq(scaled, g / size, rcond=None)[0] / size
    return move


def _scale(hessian: Array) -> Array:
    """Return the roots of the diagonal, 1 for what the readings say nothing of."""
    diagonal = np.diag(hessian)
    known = diagonal > 1e-300
    return np.where(known, np.sqrt(np.where(known, diagonal, 1.0)), 1.0)


def _invert(hessian: Array, free: NDArray[np.bool_]) -> Array | None:
    """Return the covariance of the free parameters within all, or None where it is not positive and finite."""
    at = np.flatnonzero(free)
    h = hessian[np.ix_(at, at)]
    size = _scale(h)
    scaled = h / np.outer(size, size)
    try:
        np.linalg.cholesky(scaled)
        inverse = np.linalg.inv(scaled)
    except np.linalg.LinAlgError:
        return None
    covariance = np.zeros_like(hessian)
    with np.errstate(over="ignore", invalid="ignore"):
        known = inverse / np.outer(size, size)
    if not np.all(np.isfinite(known)):
        return None
    covariance[np.ix_(at, at)] = known
    return covariance
