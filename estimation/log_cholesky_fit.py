"""The body that can exist and explains ten estimated parameters best."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from dynamics.errors import InvalidInput
from dynamics.payload import (
    from_log_cholesky,
    inertia_matrix,
    inertia_parameters,
    log_cholesky_jacobian,
    skew,
    to_log_cholesky,
)

Array = NDArray[np.float64]

ROUNDS = 200
BARRIER = 1e-3  # weight that keeps the coordinates finite where the optimum is a body without extent
SMALLEST_RADIUS = 1e-3  # m, of gyration, at the start


def nearest_body(parameters: Array, information: Array) -> Array:
    """Return the physical parameters of highest likelihood, (10,).

    min over lambda of (theta(lambda) - t)^T W (theta(lambda) - t): Levenberg-Marquardt over log-Cholesky
    coordinates, in which every point is a body.

    Args:
        parameters: t, the unconstrained estimate, with a positive mass, (10,).
        information: W, its inverse covariance, (10, 10).

    Raises:
        InvalidInput: if the mass is not positive.
    """
    if not parameters[0] > 0:
        raise InvalidInput("inertial parameters: mass", float(parameters[0]), "a mass > 0 [kg]")
    start = to_log_cholesky(_nearby(parameters))
    root = np.linalg.cholesky(0.5 * (information + information.T)).T

    def cost(at: Array) -> tuple[float, Array]:
        residual = np.concatenate([root @ (from_log_cholesky(at) - parameters), BARRIER * (at - start)])
        return float(residual @ residual), residual

    at, damping = start, 1e-3
    value, residual = cost(at)
    for _ in range(ROUNDS):
        jacobian = np.vstack([root @ log_cholesky_jacobian(at), BARRIER * np.eye(10)])
        normal, slope = jacobian.T @ jacobian, jacobian.T @ residual
        step = np.linalg.solve(normal + damping * np.diag(np.diag(normal)), -slope)
        trial = at + np.clip(step, -2.0, 2.0)
        new, new_residual = cost(trial)
        if new < value:
            settled = value - new < 1e-10 * value
            at, value, residual, damping = trial, new, new_residual, max(damping / 3, 1e-12)
            if settled:
                break
        else:
            damping *= 4
            if damping > 1e12:
                break
    return from_log_cholesky(at)


def _nearby(parameters: Array) -> Array:
    """Return a body with the same mass and centre, its central inertia made possible."""
    mass, center = float(parameters[0]), parameters[1:4] / parameters[0]
    central = inertia_matrix(parameters) + mass * skew(center) @ skew(center)
    second = 0.5 * np.trace(central) * np.eye(3) - central  # second moments, which must be positive
    values, axes = np.linalg.eigh(second)
    values = np.maximum(values, mass * SMALLEST_RADIUS**2)
    second = (axes * values) @ axes.T
    return inertia_parameters(mass, center, np.trace(second) * np.eye(3) - second)
