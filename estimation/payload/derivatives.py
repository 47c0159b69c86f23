"""Velocity and acceleration of recorded joints, by a Rauch-Tung-Striebel smoother of filterpy.

Each joint is a chain of position, velocity and acceleration driven by white jerk; the noise of the recorded
position comes from its third differences, the size of the jerk from the likelihood.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from dynamics.errors import InvalidInput

Array = NDArray[np.float64]

TRIAL = 200  # samples on which the jerk is chosen
JERK_GRID = 10.0 ** np.arange(-1, 6)  # rad^2/s^5, spectral density


def smooth(time: Array, q: Array, dq: Array | None = None) -> tuple[Array, Array, Array]:
    """Return smoothed position, velocity and acceleration.

    Args:
        time: [s], increasing, (N,).
        q: recorded positions [rad], (N, nv).
        dq: recorded velocities, if any [rad/s], (N, nv).

    Returns:
        q, dq, ddq [rad, rad/s, rad/s^2], (N, nv) each.

    Raises:
        InvalidInput: for fewer than ten samples, or times that do not increase.
    """
    if len(time) < 10:
        raise InvalidInput("derivatives: samples", len(time), "at least 10")
    if np.any(np.diff(time) <= 0):
        raise InvalidInput("derivatives: time", "times that do not increase", "increasing times")
    steps = np.concatenate([[0.0], np.diff(time)])
    out = np.empty((3, *q.shape))
    for joint in range(q.shape[1]):
        readings = q[:, [joint]] if dq is None else np.column_stack([q[:, joint], dq[:, joint]])
        noise = np.array([_noise(column) for column in readings.T])
        middle = _liveliest(readings[:, 0])
        trial = [_filter(steps[middle], readings[middle], noise, jerk)[1] for jerk in JERK_GRID]
        kalman, _ = _filter(steps, readings, noise, float(JERK_GRID[int(np.argmax(trial))]))
        out[:, :, joint] = _smoothed(*kalman)
    return out[0], out[1], out[2]


def _noise(series: Array) -> float:
    """Return the variance of white noise on a smooth series: third differences have 20 times as much."""
    third = np.diff(series, 3)
    spread = max(1.4826 * float(np.median(np.abs(third))), 0.3 * float(np.std(third)))
    return max(spread**2 / 20, 1e-12)


def _liveliest(series: Array) -> slice:
    """Return the stretch of TRIAL samples in which most happens."""
    if len(series) <= TRIAL:
        return slice(0, len(series))
    travel = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(series)))])
    start = int(np.argmax(travel[TRIAL:] - travel[:-TRIAL]))
    return slice(start, start + TRIAL)


Chain = tuple[Array, Array, list[Array], list[Array]]


def _filter(steps: Array, readings: Array, noise: Array, jerk: float) -> tuple[Chain, float]:
    """Run the filter; return its states with their models, and the log likelihood."""
    from filterpy.kalman import KalmanFilter

    size = readings.shape[1]
    kalman = KalmanFilter(dim_x=3, dim_z=size)
    kalman.x = np.array([readings[0, 0], readings[0, 1] if size == 2 else 0.0, 0.0])
    kalman.P = np.diag([noise[0], noise[1] if size == 2 else 10.0, 100.0])
    kalman.H, kalman.R = np.eye(size, 3), np.diag(noise)
    means, covariances = np.empty((len(steps), 3)), np.empty((len(steps), 3, 3))
    transitions, drives, score = [], [], 0.0
    for i, dt in enumerate(steps):
        transition = np.array([[1, dt, dt**2 / 2], [0, 1, dt], [0, 0, 1.0]])
        drive = jerk * np.array(
            [[dt**5 / 20, dt**4 / 8, dt**3 / 6], [dt**4 / 8, dt**3 / 3, dt**2 / 2], [dt**3 / 6, dt**2 / 2, dt]]
        )
        if i:
            kalman.predict(F=transition, Q=drive)
            kalman.update(readings[i])
            surprise = kalman.y @ kalman.SI @ kalman.y
            score -= 0.5 * (surprise + float(np.linalg.slogdet(kalman.S)[1]))
        means[i], covariances[i] = kalman.x, kalman.P
        transitions.append(transition)
        drives.append(drive)
    return (means, covariances, transitions, drives), score


def _smoothed(means: Array, covariances: Array, transitions: list[Array], drives: list[Array]) -> Array:
    from filterpy.kalman import rts_smoother

    # filterpy expects the model of the step from k to k + 1 at place k
    ahead = (transitions[1:] + transitions[-1:], drives[1:] + drives[-1:])
    smoothed: Array = rts_smoother(means, covariances, *ahead)[0]
    return smoothed.T
