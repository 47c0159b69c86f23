"""Mass and centre of mass of what the tool carries, from joint torques at rest.

Every joint of every pose is a reading; a factor graph (:mod:`estimation.payload_graph`) relates them to payload,
gripper and sensor bias, and expectation-maximisation tells good readings from outliers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from dynamics.arm import Arm
from dynamics.errors import InvalidInput
from dynamics.signals import JointReadings
from estimation.payload_checks import check_gravity, check_readings
from estimation.payload_estimate import PayloadEstimate
from estimation.payload_graph import Design, Fit, build, design_readings, solve
from estimation.payload_holds import StaticReadings, reduce_holds
from estimation.payload_noise import JointNoise, Responsibility, quantisation_variance, responsibilities

__all__ = ["JointNoise", "PayloadEstimate", "estimate_payload"]

Array = NDArray[np.float64]

HUBER = 1.345  # sd at which a residual's weight starts to fall, in the warm start
START_ROUNDS, MAX_ROUNDS, TOLERANCE = 4, 60, 1e-5
POOL = 3.0  # degrees of freedom that the joints lend each other's noise
LARGEST_DENSE = 120  # readings whose leverages are computed densely


def estimate_payload(
    arm: Arm,
    tare: JointReadings | Sequence[JointReadings],
    load: JointReadings | Sequence[JointReadings],
    noise: JointNoise | None = None,
    *,
    friction: bool = False,
    torque_sign: int = 1,
) -> PayloadEstimate:
    """Estimate the payload from readings without it (tare) and with it (load).

    A JointReadings is a set of single readings, one a row; a list of them is a list of holds, of many samples
    each at one pose, which count as one reading each. Tare at the same poses, approached the same way, and if
    possible before and after: then errors of the arm's model, hysteresis and bias cancel.

    Args:
        arm: the arm, with its gripper.
        tare, load: readings of the unloaded and of the loaded arm.
        noise: of the torques; without it, it is estimated from the readings.
        friction: estimate Coulomb and viscous friction too; needs velocities.
        torque_sign: -1 for sensors that read the reaction.

    Raises:
        InvalidInput: for readings that cannot be this arm's, or too few of them.
    """
    if torque_sign not in (-1, 1):
        raise InvalidInput("torque_sign", torque_sign, "1 or -1")
    noise = JointNoise() if noise is None else noise
    empty, full = reduce_holds(tare, "tare"), reduce_holds(load, "load")
    for readings, name in ((empty, "tare"), (full, "load")):
        check_readings(arm, readings, name)
    empty, full = (replace(r, tau=torque_sign * r.tau) for r in (empty, full))
    if friction and (empty.dq is None or full.dq is None):
        raise InvalidInput("friction", "readings without velocity", "single readings with dq, in tare and load")
    design = design_readings(arm, empty, full, friction)
    check_gravity(design, len(empty))
    return _estimate(design, _variances(empty, full, noise, arm.nv), noise)


@dataclass(frozen=True)
class _Variances:
    """Variance of the readings: a known part, and one a joint that may have to be estimated [N^2 m^2]."""

    known: Array
    common: Array
    estimated: bool


def _variances(tare: StaticReadings, load: StaticReadings, noise: JointNoise, joints: int) -> _Variances:
    count = np.concatenate([tare.count, load.count])[:, None]
    error, scatter = np.concatenate([tare.error, load.error]), np.concatenate([tare.scatter, load.scatter])
    holds = bool(np.any(count > 1))
    quantum = noise.per_joint("quantum", joints)
    if noise.sd is None:
        known = error**2 + quantisation_variance(quantum, scatter) * holds
    else:
        sd = noise.per_joint("sd", joints)
        known = np.where(count >= 20, error**2, sd**2 / count)
        known = known + quantisation_variance(quantum, np.where(count > 1, sd, 0.0))
    if holds and noise.hold_sd is not None:
        return _Variances(known, noise.per_joint("hold_sd", joints) ** 2, False)
    return _Variances(known, np.zeros(joints), holds or noise.sd is None)


def _estimate(design: Design, variances: _Variances, noise: JointNoise) -> PayloadEstimate:
    joints = design.torque.shape[1]
    drift = noise.per_joint("drift", joints)
    free = noise.pose_sd is None and noise.sd is None
    pose_sd = np.full(joints, np.inf if free else 0.0)
    if noise.pose_sd is not None:
        pose_sd = noise.per_joint("pose_sd", joints)
    sd = np.sqrt(variances.known + variances.common)
    widening = 1.0
    if variances.estimated:
        fit, belief, sd, freedom = _fit_with_noise(design, variances.known, drift, pose_sd, noise.outlier_rate)
        widening = _student(freedom) / 1.96
    else:
        fit, belief = _fit(design, sd, drift, pose_sd, noise.outlier_rate)
    covariance = _covariance(design, belief, drift, pose_sd, noise.per_joint("gain_sd", joints)) * widening**2
    scale = np.sqrt(np.diag(covariance))
    return PayloadEstimate(
        parameters=fit.tool[:4],
        covariance=covariance,
        weights=belief.reading,
        pose_weights=belief.pose,
        residuals=fit.residual,
        noise_sd=sd,
        condition=float(np.linalg.cond(covariance / np.outer(scale, scale))),
    )


def _fit(
    design: Design, sd: Array, drift: Array, pose_sd: Array, outlier_rate: float, start: Fit | None = None
) -> tuple[Fit, Responsibility]:
    """Alternate between the graph and the weights of its readings, from a Huber fit on."""
    fit = solve(design, sd, drift, pose_sd) if start is None else start
    if outlier_rate == 0:
        return fit, responsibilities(fit.residual, sd, 0.0)
    if start is None:
        for _ in range(START_ROUNDS):
            size = np.abs(fit.residual) / sd
            fit = solve(design, sd * np.sqrt(np.maximum(size / HUBER, 1.0)), drift, pose_sd)
    for _ in range(MAX_ROUNDS):
        belief = responsibilities(fit.residual, sd, outlier_rate)
        previous, fit = fit, solve(design, 1 / np.sqrt(belief.precision), drift, pose_sd)
        if np.max(np.abs(fit.residual - previous.residual) / sd) < TOLERANCE:
            break
    return fit, responsibilities(fit.residual, sd, outlier_rate)


def _fit_with_noise(
    design: Design, known: Array, drift: Array, pose_sd: Array, outlier_rate: float
) -> tuple[Fit, Responsibility, Array, float]:
    """Fit, and estimate the variance that each joint's readings have beyond the known one.

    Restricted maximum likelihood: the variance is such that the weighted squares of the residuals come to their
    degrees of freedom, readings less leverage; joints with few of these lean on all joints' common ratio.
    """
    joints = design.torque.shape[1]
    scale = np.sqrt(known.mean(axis=0)) if known.max() > 0 else np.full(joints, 0.3)
    common = scale**2
    fit: Fit | None = None
    for _ in range(12):
        sd = np.sqrt(known + common)
        fit, belief = _fit(design, sd, drift, pose_sd, outlier_rate, start=fit)
        room = belief.reading * (1 - _leverages(design, 1 / np.sqrt(belief.precision), drift, pose_sd))
        squares = (belief.reading * (fit.residual / sd) ** 2).sum(axis=0)
        freedom = room.sum(axis=0)
        if freedom.sum() < 1:
            raise InvalidInput("payload: readings", f"{len(design)} poses", "more poses, or the noise given (sd)")
        pooled = squares.sum() / freedom.sum()
        ratio = (squares + POOL * pooled) / (freedom + POOL)
        target = np.maximum(ratio * sd**2 - known, 0).mean(axis=0)
        floor = 1e-6 * (known.mean(axis=0) + target) + 1e-12
        settled = bool(np.all(np.abs(target - common) <= 0.01 * (common + known.mean(axis=0))))
        common = np.maximum(target, floor)
        if settled:
            break
    return fit, belief, np.sqrt(known + common), float(freedom.sum())


def _leverages(design: Design, sigma: Array, drift: Array, pose_sd: Array) -> Array:
    """Return how much of its own value every reading's fit takes, (N, nv)."""
    graph, _, _ = build(design, sigma, drift, pose_sd)
    whitened = graph.graph.jacobian()[0]
    leverage: Array = (np.linalg.qr(whitened)[0] ** 2).sum(axis=1)[: sigma.size].reshape(sigma.shape)
    return leverage


def _covariance(design: Design, belief: Responsibility, drift: Array, pose_sd: Array, gain_sd: Array) -> Array:
    """Return the payload's covariance: observed information, and gain errors as parameters not estimated."""
    sigma = 1 / np.sqrt(np.maximum(belief.curvature, 1e-6 * belief.precision))
    gains = bool(np.any(gain_sd > 0))
    root = solve(design, sigma, drift, pose_sd, gains).root
    size = design.tool.shape[2]
    inverse = np.linalg.inv(root[:size, :size])
    covariance = inverse @ inverse.T
    if gains:
        slope = -inverse @ root[:size, size:]
        covariance = covariance + (slope * gain_sd**2) @ slope.T
    return covariance[:4, :4]


def _student(freedom: float) -> float:
    """Return the 97.5 % quantile of Student's distribution."""
    from scipy.special import stdtrit

    return float(stdtrit(freedom, 0.975))
