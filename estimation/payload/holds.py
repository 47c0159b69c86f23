"""A hold becomes one reading: the mean over its samples, with a standard error that knows they are correlated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dynamics.errors import InvalidInput
from dynamics.signals import JointReadings

Array = NDArray[np.float64]

BLOCKS = 10  # of a hold; correlation longer than a tenth of a hold is not averaged away in its standard error
STILL = 0.05  # rad by which the joints may wander within a hold
WINSOR = 4.0  # robust sd beyond which a sample is pulled in, so that a spike does not move the mean


@dataclass(frozen=True)
class StaticReadings:
    """Readings of an arm at rest, one row a pose.

    Attributes:
        q, tau: position and torque [rad, N m], (N, nv).
        error: standard error that the samples of a hold show [N m], 0 for single readings, (N, nv).
        scatter: sd of a single sample about the hold's mean [N m], 0 for single readings, (N, nv).
        count: samples behind each reading, (N,).
        time: [s], nan where unknown, (N,).
        dq: velocity where known [rad/s], (N, nv).
    """

    q: Array
    tau: Array
    error: Array
    scatter: Array
    count: NDArray[np.int_]
    time: Array
    dq: Array | None = None

    def __len__(self) -> int:
        return len(self.q)


def reduce_holds(readings: JointReadings | Sequence[JointReadings], name: str) -> StaticReadings:
    """Return one row a pose: of single readings as they are, of a list of holds their means.

    The standard error of a mean is that of the means of BLOCKS consecutive blocks, pooled over the holds of
    equal standing: every hold knows its own too badly.

    Args:
        readings: rows that are readings, or a list of holds.
        name: ``tare`` or ``load``, for messages.

    Raises:
        InvalidInput: if there is no reading, or a hold moves.
    """
    if isinstance(readings, JointReadings):
        n, joints = readings.q.shape
        if n == 0:
            raise InvalidInput(name, "no reading", "at least one")
        none = np.zeros((n, joints))
        stamps = np.full(n, np.nan) if readings.time is None else readings.time
        return StaticReadings(readings.q, readings.tau, none, none, np.ones(n, int), stamps, readings.dq)
    if len(readings) == 0:
        raise InvalidInput(name, "no hold", "at least one")
    q, tau, scatter, time = [], [], [], []
    squares, freedom = 0.0, 0
    for index, hold in enumerate(readings):
        _check_hold(hold, f"{name}, hold {index}", readings[0].q.shape[1])
        samples = _winsorised(hold.tau)
        q.append(hold.q.mean(axis=0))
        tau.append(samples.mean(axis=0))
        scatter.append(samples.std(axis=0))
        time.append(np.nan if hold.time is None else hold.time.mean())
        blocks = min(BLOCKS, len(samples))
        if blocks > 1:  # long-run variance of a sample: block length times the variance of block means
            length = len(samples) // blocks
            means = samples[: blocks * length].reshape(blocks, length, -1).mean(axis=1)
            squares = squares + length * ((means - means.mean(axis=0)) ** 2).sum(axis=0)
            freedom += blocks - 1
    count = np.array([len(hold) for hold in readings])
    long_run = squares / freedom if freedom else np.zeros(len(q[0]))
    error = np.sqrt(long_run / count[:, None])
    return StaticReadings(np.array(q), np.array(tau), error, np.array(scatter), count, np.array(time))


def _winsorised(samples: Array) -> Array:
    middle = np.median(samples, axis=0)
    scale = 1.4826 * np.median(np.abs(samples - middle), axis=0)
    scale = np.where(scale > 0, scale, samples.std(axis=0))
    return np.clip(samples, middle - WINSOR * scale, middle + WINSOR * scale)


def _check_hold(hold: JointReadings, where: str, joints: int) -> None:
    if len(hold) == 0:
        raise InvalidInput(where, "no sample", "at least one")
    if hold.q.shape[1] != joints:
        raise InvalidInput(where, f"{hold.q.shape[1]} joints", f"{joints}, as in the first hold")
    wander = np.ptp(hold.q, axis=0)
    if wander.max() > STILL:
        joint = int(wander.argmax())
        raise InvalidInput(where, f"joint {joint + 1} moves by {wander[joint]:.3f} rad", f"at most {STILL} rad")
