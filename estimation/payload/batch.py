"""The payload estimate of many runs at the same poses at once, for Monte Carlo studies.

The same model and the same expectation-maximisation as the graph's, with a constant bias, by normal equations.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dynamics.arm import Arm
from estimation.payload.em import HUBER, MAX_ROUNDS, START_ROUNDS, TOLERANCE
from estimation.payload.estimate import PRIOR_SD
from estimation.payload.graph import BIAS_PRIOR_SD
from estimation.payload.noise import responsibilities

Array = NDArray[np.float64]


@dataclass(frozen=True)
class BatchEstimate:
    """Payloads of R runs.

    Attributes:
        parameters: [m, m c] [kg, kg m], (R, 4).
        covariance: (R, 4, 4).
    """

    parameters: Array
    covariance: Array


def design_matrix(arm: Arm, tare: ArrayLike, load: ArrayLike) -> Array:
    """Return what multiplies [payload, gripper, bias] in the readings of tare and load poses.

    Args:
        tare, load: joint positions [rad], (N_tare, nv) and (N_load, nv).

    Returns:
        ((N_tare + N_load) nv, 8 + nv).
    """
    poses = np.concatenate([np.asarray(tare, float), np.asarray(load, float)])
    body = np.concatenate([arm.payload_regressor(q) for q in poses])
    loaded = np.repeat([0.0, 1.0], [len(np.asarray(tare)) * arm.nv, len(np.asarray(load)) * arm.nv])
    return np.hstack([loaded[:, None] * body, body, np.tile(np.eye(arm.nv), (len(poses), 1))])


def estimate_batch(matrix: Array, torque: Array, sd: Array, outlier_rate: float = 0.05) -> BatchEstimate:
    """Estimate the payload of every run.

    Args:
        matrix: of :func:`design_matrix`, (N nv, 8 + nv).
        torque: measured torque less the arm's own, tare before load [N m], (R, N nv).
        sd: of a good reading [N m], (nv,).
        outlier_rate: share of outliers; 0 for weighted least squares.
    """
    joints = len(sd)
    prior = np.concatenate([PRIOR_SD, PRIOR_SD, np.full(joints, BIAS_PRIOR_SD)])
    sigma = np.tile(np.asarray(sd, float), len(matrix) // joints)
    products = (matrix[:, :, None] * matrix[:, None, :]).reshape(len(matrix), -1)

    def solve(precision: Array) -> tuple[Array, Array]:
        information = (precision @ products).reshape(len(precision), len(prior), len(prior)) + np.diag(prior**-2)
        right = ((precision * torque[active]) @ matrix)[..., None]
        values = np.asarray(np.linalg.solve(information, right)[..., 0], np.float64)
        return values, torque[active] - values @ matrix.T

    active = np.arange(len(torque))
    precision = np.broadcast_to(sigma**-2, torque.shape)
    values, residual = solve(precision)
    curvature = precision.copy()
    for _ in range(START_ROUNDS if outlier_rate > 0 else 0):
        values, residual = solve(sigma**-2 / np.maximum(np.abs(residual) / sigma / HUBER, 1.0))
    for _ in range(MAX_ROUNDS if outlier_rate > 0 else 0):
        shape = (len(active), -1, joints)
        belief = responsibilities(residual[active].reshape(shape), np.asarray(sd, float), outlier_rate)
        new, left = solve(belief.precision.reshape(len(active), -1))
        moving = np.max(np.abs(left - residual[active]) / sigma, axis=1) >= TOLERANCE
        values[active], residual[active] = new, left
        active = active[moving]
        if len(active) == 0:
            break
    active = np.arange(len(torque))
    if outlier_rate > 0:
        belief = responsibilities(residual.reshape(len(torque), -1, joints), np.asarray(sd, float), outlier_rate)
        curvature = belief.curvature.reshape(len(torque), -1)
    information = (curvature @ products).reshape(len(torque), len(prior), len(prior)) + np.diag(prior**-2)
    return BatchEstimate(values[:, :4], np.asarray(np.linalg.inv(information)[:, :4, :4], np.float64))
