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

_BASIS = np.array([pseudo_inertia(unit) for unit in np.eye(10)[4:]])  # the pseudo-inertia is linear in them


def nearest_body(parameters: Array, information: Array) -> Array:
    """Return the physical parameters with the same mass and centre whose inertia is of highest likelihood, (10,).

    min (I - I0)^T W (I - I0) over positive definite pseudo-inertias, which are those that log-Cholesky coordinates
    reach. The problem is convex: Newton's method with the barrier -mu log det P, whose optimum lies within 4 mu of
    the least cost. Mass and centre stay: the constraint would only carry errors of the inertia into them.

    Args:
        parameters: the unconstrained estimate, with a positive mass, (10,).
        information: W, the inverse covariance of its six moments of inertia, (6, 6).

    Raises:
        InvalidInput: if the mass is not positive.
    """
    if not parameters[0] > 0:
        raise InvalidInput("inertial parameters: mass", float(parameters[0]), "a mass > 0 [kg]")
    theta = _nearby(parameters)
    weight = 0.5 * (information + information.T)
    away = (theta - parameters)[4:]
    mu = max(float(away @ weight @ away), 1.0)
    while True:
        theta = _centred(theta, parameters, weight, mu)
        if 4 * mu < GAP:
            return theta
        mu *= SHRINK


def _centred(theta: Array, target: Array, weight: Array, mu: float) -> Array:
    """Return the minimum of (I - I0)^T W (I - I0) - mu log det P(theta), by damped Newton steps."""
    for _ in range(NEWTON_ROUNDS):
        inverse = np.linalg.inv(pseudo_inertia(theta))
        parts = np.einsum("ab,kbc->kac", inverse, _BASIS)
        slope = 2 * weight @ (theta - target)[4:] - mu * np.einsum("kaa->k", parts)
        curvature = 2 * weight + mu * np.einsum("iab,jba->ij", parts, parts)
        step = -np.linalg.solve(curvature, slope)
        decrement = np.sqrt(max(-float(slope @ step), 0.0) / mu)
        theta = theta + np.concatenate([np.zeros(4), step / (1 + decrement)])  # stays inside: self-concordant
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
