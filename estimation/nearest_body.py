"""The body that can exist and explains ten estimated parameters best."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from dynamics.errors import InvalidInput
from dynamics.payload import inertia_matrix, inertia_parameters, pseudo_inertia, skew

Array = NDArray[np.float64]

GAP = 1e-4  # by which the cost may exceed the least possible
SHRINK, NEWTON_ROUNDS = 0.1, 30
START_RADIUS = 0.02  # m, of gyration, at least, at the start

_BASIS = np.array([pseudo_inertia(unit) for unit in np.eye(10)])  # the pseudo-inertia is linear in the parameters


def nearest_body(parameters: Array, information: Array) -> Array:
    """Return the physical parameters of highest likelihood, (10,).

    min (theta - t)^T W (theta - t) over positive definite pseudo-inertias P(theta), which are those that
    log-Cholesky coordinates reach. The problem is convex: Newton's method with the barrier -mu log det P, whose
    optimum lies within 4 mu of the least cost.

    Args:
        parameters: t, the unconstrained estimate, with a positive mass, (10,).
        information: W, its inverse covariance, (10, 10).

    Raises:
        InvalidInput: if the mass is not positive.
    """
    if not parameters[0] > 0:
        raise InvalidInput("inertial parameters: mass", float(parameters[0]), "a mass > 0 [kg]")
    theta = _nearby(parameters)
    weight = 0.5 * (information + information.T)
    mu = max(float((theta - parameters) @ weight @ (theta - parameters)), 1.0)
    while True:
        theta = _centred(theta, parameters, weight, mu)
        if 4 * mu < GAP:
            return theta
        mu *= SHRINK


def _centred(theta: Array, target: Array, weight: Array, mu: float) -> Array:
    """Return the minimum of (theta - t)^T W (theta - t) - mu log det P(theta), by damped Newton steps."""
    for _ in range(NEWTON_ROUNDS):
        inverse = np.linalg.inv(pseudo_inertia(theta))
        parts = np.einsum("ab,kbc->kac", inverse, _BASIS)
        slope = 2 * weight @ (theta - target) - mu * np.einsum("kaa->k", parts)
        curvature = 2 * weight + mu * np.einsum("iab,jba->ij", parts, parts)
        scale = 1 / np.sqrt(np.diag(curvature))  # kilograms and kg m^2 differ by orders of magnitude
        step = -scale * np.linalg.solve(curvature * np.outer(scale, scale), scale * slope)
        decrement = np.sqrt(max(-float(slope @ step), 0.0) / mu)
        theta = theta + step / (1 + decrement)  # stays inside the cone: the barrier is self-concordant
        if decrement < 1e-6:
            break
    return theta


def _nearby(parameters: Array) -> Array:
    """Return a body with the same mass and centre, its central inertia made possible."""
    mass, center = float(parameters[0]), parameters[1:4] / parameters[0]
    central = inertia_matrix(parameters) + mass * skew(center) @ skew(center)
    second = 0.5 * np.trace(central) * np.eye(3) - central  # second moments, which must be positive
    values, axes = np.linalg.eigh(second)
    second = (axes * np.maximum(values, mass * START_RADIUS**2)) @ axes.T
    return inertia_parameters(mass, center, np.trace(second) * np.eye(3) - second)
