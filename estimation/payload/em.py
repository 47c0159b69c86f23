"""Expectation-maximisation around the payload's graph: weights of the readings, and their noise if unknown."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from dynamics.errors import InvalidInput
from estimation.payload.graph import Design, Fit, build, solve
from estimation.payload.noise import Responsibility, responsibilities

Array = NDArray[np.float64]

HUBER = 1.345  # sd at which a residual's weight starts to fall, in the warm start
START_ROUNDS, MAX_ROUNDS, TOLERANCE = 4, 100, 1e-7
NOISE_ROUNDS = 20
LEAST_NOISE = 1e-6  # of what a joint is built for; with less the graph loses its digits, and no sensor has less
LONGEST_CHAIN = 200  # readings whose leverages, dense in the biases of all, are still quick to compute
POOL = 3.0  # degrees of freedom that the joints lend each other's noise


def fit_mixture(
    design: Design, sd: Array, drift: Array, pose_sd: Array, outlier_rate: float, start: Fit | None = None
) -> tuple[Fit, Responsibility]:
    """Alternate between the graph and the weights of its readings, from a Huber fit on."""
    fit = solve(design, sd, drift, pose_sd) if start is None or outlier_rate == 0 else start
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


def fit_with_noise(
    design: Design, known: Array, drift: Array, pose_sd: Array, outlier_rate: float
) -> tuple[Fit, Responsibility, Array, Array]:
    """Fit, and estimate the variance that each joint's readings have beyond the known one.

    Restricted maximum likelihood: the variance is such that the weighted squares of the residuals come to their
    degrees of freedom, readings less leverage; joints with few of these lean on all joints' common ratio.

    Returns:
        The fit, the weights, the sd of every reading [N m] (N, nv), and the degrees of freedom behind it (nv,).

    Raises:
        InvalidInput: if there are too few readings to know their noise.
    """
    joints = design.torque.shape[1]
    if np.any(drift > 0) and len(design) > LONGEST_CHAIN:
        found = f"{len(design)} readings with drift and no sd"
        raise InvalidInput("joint noise", found, f"a given sd, for more than {LONGEST_CHAIN} readings")
    # not less than the residuals show: readings that scatter far more than their samples would look like outliers
    common = np.maximum(known.mean(axis=0), _first_guess(design, drift, pose_sd))
    fit: Fit | None = None
    for _ in range(NOISE_ROUNDS):
        sd = np.sqrt(known + common)
        fit, belief = fit_mixture(design, sd, drift, pose_sd, outlier_rate, start=fit)
        rows, covariance = _whitened(design, belief, drift, pose_sd)
        leverage = np.einsum("ijk,kl,ijl->ij", rows, covariance, rows)
        freedom = (belief.reading * (1 - leverage)).sum(axis=0)
        if freedom.sum() < joints / 2:
            if (1 - leverage).sum() < joints / 2:
                advice = "more poses, or the noise given (sd; of holds, hold_sd)"
                raise InvalidInput("payload: readings", f"{len(design)} poses", advice)
            common, fit = 4 * common, None  # too small: most readings were taken for outliers
            continue
        squares = (belief.reading * (fit.residual / sd) ** 2).sum(axis=0)
        ratio = (squares + POOL * squares.sum() / freedom.sum()) / (freedom + POOL)
        least = 1e-6 * known + (LEAST_NOISE * design.scale) ** 2
        target = np.maximum(ratio * sd**2 - known, least).mean(axis=0)
        settled = bool(np.all(np.abs(target - common) <= 0.01 * (common + known.mean(axis=0))))
        common = target
        if settled:
            break
    assert fit is not None
    return fit, belief, np.sqrt(known + common), freedom


def small_sample_correction(
    design: Design, belief: Responsibility, drift: Array, pose_sd: Array, freedom: Array
) -> Array:
    """Return what widens the payload's covariance for noise that is itself an estimate, as a factor (4, 4).

    With A_j the information from joint j, Phi the covariance and n_j the degrees of freedom of its noise:
    Phi' = Phi + 2 Phi [sum_j 2/n_j (A_j - A_j Phi A_j)] Phi, and Student's quantile instead of 1.96 at
    1/n = sum_j ((Phi A_j Phi)_kk / Phi_kk)^2 / n_j for parameter k (Kenward and Roger, Biometrics 53, 1997).
    """
    from scipy.special import stdtrit

    rows, covariance = _whitened(design, belief, drift, pose_sd)
    size = design.tool.shape[2]
    columns = slice(covariance.shape[0] - size, covariance.shape[0] - size + 4)
    payload = covariance[columns]
    added, share = np.zeros((4, 4)), np.zeros(4)
    for joint, count in enumerate(freedom):
        part = rows[:, joint] @ payload.T  # (N, 4)
        seen = rows[:, joint] @ covariance @ rows[:, joint].T
        added += 2 / count * (part.T @ part - part.T @ seen @ part)
        share += (np.einsum("ij,ij->j", part, part) / np.diag(payload[:, columns])) ** 2 / count
    plain = payload[:, columns]
    widened = np.sqrt(np.diag(plain + 2 * added) / np.diag(plain))
    return np.diag(widened * stdtrit(np.maximum(1 / share, 2.0), 0.975) / 1.96)


def _first_guess(design: Design, drift: Array, pose_sd: Array) -> Array:
    """Return a variance of each joint's readings, from an unweighted fit and what the joints are built for."""
    residual = solve(design, np.ones_like(design.torque), drift, pose_sd).residual
    share = 1.4826 * np.median(np.abs(residual / design.scale))
    return np.asarray((max(float(share), LEAST_NOISE) * design.scale) ** 2)


def _whitened(design: Design, belief: Responsibility, drift: Array, pose_sd: Array) -> tuple[Array, Array]:
    """Return the readings' rows of the weighted graph, (N, nv, all variables), and the covariance of these."""
    graph, _, _, order = build(design, 1 / np.sqrt(belief.precision), drift, pose_sd)
    matrix = graph.graph.jacobian()[0]
    root = np.linalg.inv(np.linalg.qr(matrix, mode="r"))
    rows = np.empty((*design.torque.shape, matrix.shape[1]))
    rows[order] = matrix[: design.torque.size].reshape(rows.shape)
    return rows, root @ root.T
