"""Mass and centre of mass of what the tool carries, from joint torques at rest.

Every joint of every pose is a reading; a factor graph (:mod:`estimation.payload.graph`) relates them to payload,
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
from estimation.payload.checks import check_gravity, check_readings
from estimation.payload.em import fit_mixture, fit_with_noise, small_sample_correction
from estimation.payload.estimate import PayloadEstimate
from estimation.payload.graph import Design, Fit, design_readings, solve
from estimation.payload.holds import StaticReadings, reduce_holds
from estimation.payload.noise import JointNoise, Responsibility, quantisation_variance

__all__ = ["JointNoise", "PayloadEstimate", "estimate_payload"]

Array = NDArray[np.float64]


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
    drift, pose_sd = noise.per_joint("drift", joints), _pose_sd(noise, joints)
    if not variances.estimated:
        sd = np.sqrt(variances.known + variances.common)
        fit, belief = fit_mixture(design, sd, drift, pose_sd, noise.outlier_rate)
        return summarise(design, fit, belief, sd, noise)
    fit, belief, sd, freedom = fit_with_noise(design, variances.known, drift, pose_sd, noise.outlier_rate)
    correction = small_sample_correction(design, belief, drift, pose_sd, freedom)
    return summarise(design, fit, belief, sd, noise, correction)


def summarise(
    design: Design, fit: Fit, belief: Responsibility, sd: Array, noise: JointNoise, correction: Array | None = None
) -> PayloadEstimate:
    """Return the estimate of a fit: covariance from the observed information, gain errors on top of it.

    Where every shared pose has an offset of its own, a gain error shows in the payload's torque alone; it is a
    parameter then, and joints whose gains matter less count more. Elsewhere it would take up what the arm's model
    gets wrong: there gains are not estimated but count (Schmidt's consider covariance).

    Args:
        design, fit, belief: the readings' matrices, the solved graph, and the readings' weights.
        sd: of good readings [N m], (N, nv).
        noise: of the sensors, gain errors among it.
        correction: factor on the noise's part of the covariance, (4, 4).
    """
    joints, size = design.torque.shape[1], design.tool.shape[2]
    drift, pose_sd = noise.per_joint("drift", joints), _pose_sd(noise, joints)
    gain_sd = noise.per_joint("gain_sd", joints)
    estimated = bool(np.all(gain_sd > 0) and np.all(np.isinf(pose_sd)))
    considered = bool(np.any(gain_sd > 0)) and not estimated
    sigma = 1 / np.sqrt(np.maximum(belief.curvature, 1e-6 * belief.precision))
    root = solve(design, sigma, drift, pose_sd, np.ones(joints) if considered else None).root
    inverse = np.linalg.inv(root[:size, :size])[:4]
    plain = inverse @ inverse.T
    covariance = plain if correction is None else correction @ plain @ correction.T
    parameters = fit.tool[:4]
    if considered:
        slope = -inverse @ root[:size, size:]
        covariance = covariance + (slope * gain_sd**2) @ slope.T
    if estimated:
        gained = solve(design, 1 / np.sqrt(belief.precision), drift, pose_sd, gain_sd)
        whole = np.linalg.inv(solve(design, sigma, drift, pose_sd, gain_sd).root)[:4]
        parameters = gained.tool[:4]
        covariance = covariance + whole @ whole.T - plain
    scale = np.sqrt(np.diag(covariance))
    return PayloadEstimate(
        parameters=parameters,
        covariance=covariance,
        weights=belief.reading,
        pose_weights=belief.pose,
        residuals=fit.residual,
        noise_sd=sd,
        condition=float(np.linalg.cond(covariance / np.outer(scale, scale))),
        capacity=design.capacity,
    )


def _pose_sd(noise: JointNoise, joints: int) -> Array:
    if noise.pose_sd is None:
        return np.full(joints, np.inf if noise.sd is None else 0.0)
    return noise.per_joint("pose_sd", joints)
