"""A rigid body carried by the tool: how its mass, first moment and inertia enter forces linearly.

Parameters are in the tool frame: 4 of them for an arm at rest, ``[m, m c_x, m c_y, m c_z]`` [kg, kg m]; 10 for a
moving one, followed by the inertia about the origin of the tool frame ``[Ixx, Ixy, Iyy, Ixz, Iyz, Izz]``
[kg m^2]. A body exists only if its pseudo-inertia

    P = [[Sigma, h], [h^T, m]],   Sigma = tr(I)/2 E - I,   h = m c

is positive definite; P = U U^T with U upper triangular and a positive diagonal reaches every such body and no
other (log-Cholesky parameters: Rucker and Wensing, IEEE RA-L 7(2), 2022).
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, NDArray

from dynamics.errors import InvalidInput

Array = NDArray[np.float64]

STATIC_PARAMETERS = ("mass", "m c_x", "m c_y", "m c_z")
INERTIA_PARAMETERS = (*STATIC_PARAMETERS, "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")

# position of the ten parameters' inertia entries in a symmetric 3 x 3 matrix
_ROW, _COLUMN = np.array([0, 0, 1, 0, 1, 2]), np.array([0, 1, 1, 2, 2, 2])
_UPPER = np.triu_indices(4)


def skew(vector: ArrayLike) -> Array:
    """Return the matrix of the cross product, S(v) w = v x w, (3, 3)."""
    x, y, z = np.asarray(vector, float)
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def static_wrench_regressor(gravity: ArrayLike) -> Array:
    """Return what a body at rest asks of the tool, linear in its four parameters.

    w = [[-g, 0], [0, S(g)]] [m, m c]: the force and torque that hold the body, in the tool frame.

    Args:
        gravity: acceleration of gravity in the tool frame [m/s^2], (3,).

    Returns:
        (6, 4), force rows first.
    """
    g = np.asarray(gravity, float)
    regressor = np.zeros((6, 4))
    regressor[:3, 0] = -g
    regressor[3:, 1:] = skew(g)
    return regressor


def dynamic_wrench_regressor(velocity: ArrayLike, acceleration: ArrayLike) -> Array:
    """Return what a moving body asks of the tool, linear in its ten parameters.

    Args:
        velocity: twist of the tool in the tool frame, linear part first [m/s, rad/s], (6,).
        acceleration: its spatial acceleration less that of gravity [m/s^2, rad/s^2], (6,).

    Returns:
        (6, 10), force rows first.
    """
    regressor: Array = pin.bodyRegressor(
        pin.Motion(np.asarray(velocity, float)), pin.Motion(np.asarray(acceleration, float))
    )
    return regressor


def inertia_parameters(mass: float, center_of_mass: ArrayLike, inertia: ArrayLike) -> Array:
    """Return the ten parameters of a body.

    Args:
        mass: [kg].
        center_of_mass: in the tool frame [m], (3,).
        inertia: about the centre of mass, along the tool's axes [kg m^2], (3, 3).

    Returns:
        [m, m c, Ixx, Ixy, Iyy, Ixz, Iyz, Izz] about the tool's origin, (10,).
    """
    c = np.asarray(center_of_mass, float)
    about_origin = np.asarray(inertia, float) - mass * skew(c) @ skew(c)
    parameters: Array = np.concatenate([[mass], mass * c, about_origin[_ROW, _COLUMN]])
    return parameters


def inertia_matrix(parameters: ArrayLike) -> Array:
    """Return the inertia about the tool's origin that ten parameters hold [kg m^2], (3, 3)."""
    values = _ten(parameters)[4:]
    matrix = np.zeros((3, 3))
    matrix[_ROW, _COLUMN] = values
    matrix[_COLUMN, _ROW] = values
    return matrix


def pseudo_inertia(parameters: ArrayLike) -> Array:
    """Return the 4 x 4 pseudo-inertia of ten parameters; it is linear in them."""
    theta = _ten(parameters)
    inertia = inertia_matrix(theta)
    matrix = np.empty((4, 4))
    matrix[:3, :3] = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    matrix[:3, 3] = matrix[3, :3] = theta[1:4]
    matrix[3, 3] = theta[0]
    return matrix


def is_physical(parameters: ArrayLike) -> bool:
    """Tell whether a body with these ten parameters can exist: its pseudo-inertia is positive definite."""
    return bool(np.linalg.eigvalsh(pseudo_inertia(parameters))[0] > 0)


def to_log_cholesky(parameters: ArrayLike) -> Array:
    """Return the log-Cholesky coordinates of a body: the entries of U, its diagonal as logarithms, (10,).

    Raises:
        InvalidInput: if no body has these parameters.
    """
    if not is_physical(parameters):
        raise InvalidInput("inertial parameters", list(_ten(parameters)), "a positive definite pseudo-inertia")
    # P = U U^T with U upper: reverse the axes, take the lower factor, reverse back
    lower = np.linalg.cholesky(pseudo_inertia(parameters)[::-1, ::-1])
    upper = np.array(lower[::-1, ::-1], np.float64)
    np.fill_diagonal(upper, np.log(np.diag(upper)))
    coordinates: Array = upper[_UPPER]
    return coordinates


def from_log_cholesky(coordinates: ArrayLike) -> Array:
    """Return the ten parameters of log-Cholesky coordinates; every finite input is a body that can exist."""
    return _from_pseudo_inertia(_upper(coordinates) @ _upper(coordinates).T)


def log_cholesky_jacobian(coordinates: ArrayLike) -> Array:
    """Return the derivative of the ten parameters with respect to the coordinates, (10, 10)."""
    upper = _upper(coordinates)
    jacobian = np.empty((10, 10))
    for k, (i, j) in enumerate(zip(*_UPPER, strict=True)):
        change = np.zeros((4, 4))
        change[i, j] = upper[i, i] if i == j else 1.0
        jacobian[:, k] = _from_pseudo_inertia(change @ upper.T + upper @ change.T)
    return jacobian


def _upper(coordinates: ArrayLike) -> Array:
    upper = np.zeros((4, 4))
    upper[_UPPER] = _ten(coordinates)
    np.fill_diagonal(upper, np.exp(np.diag(upper)))
    return upper


def _from_pseudo_inertia(matrix: Array) -> Array:
    sigma = matrix[:3, :3]
    inertia = np.trace(sigma) * np.eye(3) - sigma
    parameters: Array = np.concatenate([[matrix[3, 3]], matrix[:3, 3], inertia[_ROW, _COLUMN]])
    return parameters


def _ten(values: ArrayLike) -> Array:
    vector = np.asarray(values, float)
    if vector.shape != (10,) or not np.all(np.isfinite(vector)):
        raise InvalidInput("inertial parameters", vector.tolist(), "ten finite numbers")
    return vector
