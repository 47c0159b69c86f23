"""Mass, centre of mass and inertia from a recorded motion, with calibrated drives.

    effort / k - model(q, dq, ddq) = B(q, dq, ddq) [m, m c, I] + offset + noise

Residuals of friction are strongly correlated in time: the covariance is autocorrelation-consistent, and what the
calibration itself leaves uncertain is carried through.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dynamics.errors import InvalidInput
from dynamics.payload import inertia_matrix, is_physical, skew
from estimation.graph import LinearGraph, key
from estimation.measurement import Measurement
from estimation.payload.autocorrelation import (
    bandwidth,
    block_bootstrap_covariance,
    independent_count,
    long_run_covariance,
    small_sample_widening,
)
from estimation.payload.drives import Drives
from estimation.payload.mass import MassEstimate
from estimation.payload.motion_rows import MotionRows
from estimation.payload.nearest_body import nearest_body
from estimation.payload.noise import responsibilities

Array = NDArray[np.float64]

PRIOR_SD = 100.0  # kg, kg m, kg m^2: only keeps the graph solvable
OFFSET_SD = 100.0  # N m
OUTLIER_RATE = 0.02
ROUNDS = 30
MOST_FITTED = 0.1  # share of the residuals' freedom that is left at least
DISTINCT = 3.0  # sd by which every principal moment of inertia must exceed zero to count as identified


@dataclass(frozen=True)
class MotionPayload(MassEstimate):
    """A payload estimated from a motion.

    Attributes:
        parameters: [m, m c, Ixx, Ixy, Iyy, Ixz, Iyz, Izz] about the tool's origin, (10,); a body that can exist,
            if the mass is distinct from zero.
        covariance: of the unconstrained parameters, scaled so that +-1.96 sd cover 95 %, (10, 10).
        inertia_identified: whether the motion tells the inertia about the centre of mass from zero.
        weights: share of good readings in every block of time, (T,).
        residual_sd: of every joint [N m], (nv,).
    """

    inertia_identified: bool
    weights: Array
    residual_sd: Array

    @property
    def center_of_mass(self) -> Array:
        """Centre of mass in the tool frame [m], (3,); nan if the mass is not distinct from zero."""
        return self.parameters[1:4] / self.mass if self.mass_is_distinct else np.full(3, np.nan)

    @property
    def inertia(self) -> Array:
        """Inertia about the centre of mass along the tool's axes [kg m^2], (3, 3); nan if not identified."""
        if not self.inertia_identified:
            return np.full((3, 3), np.nan)
        return _central_inertia(self.parameters)

    @property
    def verdict(self) -> str:
        """What the motion could and could not tell, in a sentence."""
        if not self.mass_is_distinct:
            low, high = self.mass_interval
            return f"no payload distinguishable from zero: mass in [{low:.3f}, {high:.3f}] kg"
        if not self.inertia_identified:
            return "mass and centre of mass identified; inertia not identifiable from this motion"
        return "mass, centre of mass and inertia identified"

    def measurement(self) -> Measurement:
        """Return the reading of the property ``mass`` [kg]."""
        return Measurement("mass", self.mass, self.mass_sd, "kg")


def estimate_payload_motion(
    rows: MotionRows, drives: Drives, *, bootstrap: np.random.Generator | None = None, draws: int = 2000
) -> MotionPayload:
    """Estimate the payload of a recorded motion.

    Args:
        rows: of the motion (:func:`estimation.payload.motion_rows.motion_rows`).
        drives: the calibrated arm.
        bootstrap: if given, the covariance comes from a block bootstrap with this source of randomness instead
            of the HAC formula.
        draws: of the bootstrap.

    Raises:
        InvalidInput: if log and calibration do not belong together.
    """
    joints = rows.effort.shape[1]
    if rows.effort_kind != drives.effort_kind or drives.inverse_gain.shape != (joints,):
        found = f"{rows.effort_kind} of {joints} joints"
        raise InvalidInput(
            "motion log", found, f"{drives.effort_kind} of {len(drives.inverse_gain)} joints, as calibrated"
        )
    torque = rows.effort / drives.inverse_gain - rows.model @ drives.model
    sigma = drives.noise_sd.copy()
    precision = np.broadcast_to(sigma**-2, torque.shape)
    values = np.zeros(10 + joints)
    matrix = np.concatenate([rows.payload, np.broadcast_to(np.eye(joints), (len(rows), joints, joints))], axis=2)
    for _ in range(ROUNDS):
        previous, values = values, _solve(matrix, torque, precision, joints)
        residual = torque - matrix @ values
        belief = responsibilities(residual, sigma, OUTLIER_RATE)
        sigma = np.sqrt((belief.reading * residual**2).sum(axis=0) / belief.reading.sum(axis=0)) + 1e-12
        precision = belief.precision
        if np.max(np.abs(values - previous)) < 1e-7:
            break
    covariance = _covariance(matrix, residual, precision, rows, drives, bootstrap, draws)[:10, :10]
    identified = _inertia_identified(values[:10], covariance)
    parameters = values[:10]
    if values[0] > 2 * np.sqrt(covariance[0, 0]) and not is_physical(parameters):
        parameters = nearest_body(parameters, np.asarray(np.linalg.inv(covariance[4:, 4:]), np.float64))
    return MotionPayload(parameters, covariance, identified, belief.reading.mean(axis=1), sigma)


def _solve(matrix: Array, torque: Array, precision: Array, joints: int) -> Array:
    """Solve the graph of payload and offset, (10 + nv,)."""
    root = np.sqrt(precision)[:, :, None]
    flat = (np.concatenate([matrix, torque[:, :, None]], axis=2) * root).reshape(-1, 11 + joints)
    factor = np.asarray(np.linalg.qr(flat, mode="r"), np.float64)
    payload, offset = key("p"), key("b")
    graph = LinearGraph()
    graph.add({payload: factor[:, :10], offset: factor[:, 10:-1]}, factor[:, -1], np.ones(len(factor)))
    graph.add_prior(payload, np.zeros(10), PRIOR_SD)
    graph.add_prior(offset, np.zeros(joints), OFFSET_SD)
    solution = graph.solve(last=payload)
    return np.concatenate([solution[payload], solution[offset]])


def _covariance(
    matrix: Array,
    residual: Array,
    precision: Array,
    rows: MotionRows,
    drives: Drives,
    bootstrap: np.random.Generator | None,
    draws: int,
) -> Array:
    """Return the covariance of payload and offset: of the correlated residuals, and of the calibration."""
    joints = residual.shape[1]
    weighted = matrix * precision[:, :, None]
    prior = np.concatenate([np.full(10, PRIOR_SD), np.full(joints, OFFSET_SD)])
    information = np.einsum("tji,tjk->ik", weighted, matrix, optimize=True) + np.diag(prior**-2)
    inverse = np.linalg.inv(information)
    scores = np.einsum("tji,tj->ti", weighted, residual)
    if bootstrap is None:
        spread = long_run_covariance(scores)
    else:
        length = max(2, int(np.ceil(bandwidth(scores))))
        spread = block_bootstrap_covariance(scores, length, draws, bootstrap)
    # what a change of model and gain would do to the estimate
    by_model = np.einsum("tji,tjk->ik", weighted, rows.model, optimize=True)
    by_gain = np.einsum("tji,tj->ij", weighted, rows.effort / drives.inverse_gain**2)
    slope = inverse @ np.hstack([by_model, by_gain])
    count = independent_count(np.sqrt(precision) * residual)
    widening = small_sample_widening(scores) * np.sqrt(count / max(count - len(information), MOST_FITTED * count))
    covariance: Array = widening**2 * inverse @ spread @ inverse + slope @ drives.covariance @ slope.T
    return covariance


def _central_inertia(parameters: Array) -> Array:
    mass, center = parameters[0], parameters[1:4] / parameters[0]
    central: Array = inertia_matrix(parameters) + mass * skew(center) @ skew(center)
    return central


def _inertia_identified(parameters: Array, covariance: Array) -> bool:
    """Tell whether every principal moment about the centre of mass exceeds zero clearly."""
    if parameters[0] <= 2 * np.sqrt(covariance[0, 0]):
        return False
    moments, axes = np.linalg.eigh(_central_inertia(parameters))
    gradient = np.empty((3, 10))
    for i, step in enumerate(np.eye(10)):
        change = 1e-6 * max(abs(parameters[i]), 1e-3)
        difference = _central_inertia(parameters + change * step) - _central_inertia(parameters - change * step)
        gradient[:, i] = np.einsum("ji,jk,ki->i", axes, difference, axes) / (2 * change)
    sd = np.sqrt(np.einsum("ij,jk,ik->i", gradient, covariance, gradient))
    return bool(np.all(moments > DISTINCT * sd))
