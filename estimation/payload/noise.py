"""What is known of the noise of joint torques, and how likely a residual is under it."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dynamics.errors import InvalidInput

Array = NDArray[np.float64]

OUTLIER_SCALE = 20.0  # sd of an outlier in sd of a good reading; estimates hardly depend on it
_HARMONICS = np.arange(1.0, 100.0)
POSE_OUTLIER_SHARE = 0.2  # outlying poses (a touch, a cable) per outlying reading


@dataclass(frozen=True)
class JointNoise:
    """Noise of the joint torques; numbers are one for all joints, or one a joint.

    Attributes:
        sd: white noise of one reading [N m]; None to estimate it from repeats.
        quantum: step of the reported torque [N m].
        drift: sd of the change of the bias from one pose to the next [N m]; 0 for a constant bias.
        outlier_rate: share of readings that are anything but good, in [0, 0.5).
        gain_sd: sd of the sensors' unknown gain errors, a share of the torque. They are not estimated (an
            error of the arm's model would pose as one); the covariance takes them into account.
        hold_sd: sd of what a hold's samples have in common and the next hold's have not, such as stiction
            [N m]; None to estimate it. It does not matter for single readings.
        pose_sd: sd of what tare and load at one pose have in common, such as errors of the arm's model [N m];
            infinite to trust only the differences between them. None stands for 0 where sd is given and for
            infinite where it is estimated.

    Raises:
        InvalidInput: for numbers out of range.
    """

    sd: ArrayLike | None = None
    quantum: ArrayLike = 0.0
    drift: ArrayLike = 0.0
    outlier_rate: float = 0.05
    gain_sd: ArrayLike = 0.0
    hold_sd: ArrayLike | None = None
    pose_sd: ArrayLike | None = None

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if value is None:
                continue
            numbers = np.asarray(value, float)
            if numbers.ndim > 1 or np.any(np.isnan(numbers)) or np.any(numbers < 0):
                raise InvalidInput(f"joint noise: {field.name}", value, "numbers >= 0")
            if field.name != "pose_sd" and not np.all(np.isfinite(numbers)):
                raise InvalidInput(f"joint noise: {field.name}", value, "finite numbers")
        if self.sd is not None and np.any(np.asarray(self.sd) == 0):
            raise InvalidInput("joint noise: sd", self.sd, "numbers > 0, or None to estimate it")
        if not self.outlier_rate < 0.5:
            raise InvalidInput("joint noise: outlier_rate", self.outlier_rate, "a share in [0, 0.5)")

    def per_joint(self, name: str, joints: int) -> Array:
        """Return one of the numbers for every joint, (joints,)."""
        value = np.asarray(getattr(self, name), float)
        if value.shape not in ((), (joints,)):
            raise InvalidInput(f"joint noise: {name}", f"shape {value.shape}", f"one number, or {joints}")
        return np.broadcast_to(value, (joints,)).copy()


def quantisation_variance(quantum: ArrayLike, sd: ArrayLike) -> Array:
    """Return the variance that rounding leaves in the mean of many samples [N^2 m^2].

    q^2/12 without noise. Noise of the samples dithers the rounding away, harmonic by harmonic of the sawtooth:
    sum_k q^2 / (2 pi^2 k^2) exp(-(2 pi k sd / q)^2).

    Args:
        quantum: step q [N m].
        sd: noise of a single sample [N m].
    """
    q, noise = np.broadcast_arrays(np.asarray(quantum, float), np.asarray(sd, float))
    ratio = np.divide(noise, q, out=np.full(q.shape, np.inf), where=q > 0)
    series = (np.exp(-((2 * np.pi * _HARMONICS * ratio[..., None]) ** 2)) / _HARMONICS**2).sum(axis=-1)
    return np.asarray(np.where(ratio > 0, q**2 / (2 * np.pi**2) * series, q**2 / 12))


@dataclass(frozen=True)
class Responsibility:
    """How good the readings are thought to be.

    Attributes:
        reading: probability that a reading is good and its pose too, (..., N, nv).
        pose: probability that a pose is good, (..., N).
        precision: expected inverse variance of every reading [1/(N m)^2], (..., N, nv).
        curvature: observed information of every reading, which is less where its class is in doubt (Louis,
            J. R. Stat. Soc. B 44, 1982), not below 0, (..., N, nv).
    """

    reading: Array
    pose: Array
    precision: Array
    curvature: Array


def responsibilities(residual: Array, sd: Array, outlier_rate: float) -> Responsibility:
    """Tell good readings and poses from outliers.

    A reading is N(0, sd^2) or, with the outlier rate, N(0, (OUTLIER_SCALE sd)^2); with a fifth of that rate the
    whole pose is an outlier. Bayes' rule gives the probabilities, in the log domain.

    Args:
        residual: of every reading [N m], (..., N, nv).
        sd: of a good one [N m], broadcast to the same shape.
        outlier_rate: in [0, 0.5).
    """
    variance = np.broadcast_to(sd, residual.shape) ** 2
    good, bad = 1 / variance, 1 / (OUTLIER_SCALE**2 * variance)
    if outlier_rate == 0:
        return Responsibility(np.ones_like(residual), np.ones(residual.shape[:-1]), good, good)
    square = residual**2
    log_good = np.log1p(-outlier_rate) - 0.5 * square * good
    log_bad = np.log(outlier_rate) - np.log(OUTLIER_SCALE) - 0.5 * square * bad
    log_either = np.logaddexp(log_good, log_bad)
    share = POSE_OUTLIER_SHARE * outlier_rate
    log_pose_good = np.log1p(-share) + log_either.sum(axis=-1)
    log_pose_bad = np.log(share) + (log_bad - np.log(outlier_rate)).sum(axis=-1)
    pose = np.exp(log_pose_good - np.logaddexp(log_pose_good, log_pose_bad))
    reading = np.exp(log_good - log_either) * pose[..., None]
    precision = reading * good + (1 - reading) * bad
    doubt = reading * (1 - reading) * square * (good - bad) ** 2
    return Responsibility(reading, pose, precision, np.maximum(precision - doubt, 0.0))
