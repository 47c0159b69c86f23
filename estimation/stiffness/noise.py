"""The errors of a stress-strain curve: what is known of them, what its readings say of them, and which to use."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dynamics.compression import StressStrain
from dynamics.errors import InvalidInput

Array = NDArray[np.float64]

HELD_SHARE = 0.3  # of readings that repeat the opening before, from which it is taken to be renewed less often
HELD_STRESS_SD = 0.01  # of the largest stress: least noise of a stress whose strain was renewed at another instant
MIN_READINGS = 7


@dataclass(frozen=True)
class CurveNoise:
    """What is known of the errors in a stress-strain curve.

    Attributes:
        stress_sd: of one stress reading that is no spike [Pa], a number or (N,).
        scale_known: False where only the shape of ``stress_sd`` is known; its scale is then estimated.
        strain_quantum: step of the strain [-]; 0 where it is continuous.
        baseline_sd: of the stress without contact, around 0 [Pa]; infinite where no tare was made.
        deadband, deadband_sd: stress that the gripper's friction swallows before any is reported [Pa].
        onset, onset_sd: strain at which contact begins, where the width is known; infinite sd where it is not [-].
        gain_sd: relative standard deviation common to every stress: of the force per ampere, of sizes.
    """

    stress_sd: float | Array
    scale_known: bool = True
    strain_quantum: float = 0.0
    baseline_sd: float = math.inf
    deadband: float = 0.0
    deadband_sd: float = 0.0
    onset: float = 0.0
    onset_sd: float = math.inf
    gain_sd: float = 0.0

    def __post_init__(self) -> None:
        sd = np.asarray(self.stress_sd)
        if not (np.all(np.isfinite(sd)) and np.all(sd > 0)):
            raise InvalidInput("curve noise: stress_sd [Pa]", self.stress_sd, "finite numbers > 0")
        for name in ("baseline_sd", "onset_sd"):
            if not getattr(self, name) > 0:
                raise InvalidInput(f"curve noise: {name}", getattr(self, name), "a number > 0")
        for name in ("strain_quantum", "deadband", "deadband_sd", "gain_sd"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0):
                raise InvalidInput(f"curve noise: {name}", value, "a finite number >= 0")


@dataclass(frozen=True)
class Loading:
    """The readings of a curve that a modulus is estimated from.

    Attributes:
        strain, stress, stress_sd: in order, (N,).
        noise: with what had to be guessed of it.
        renewed_late: whether the opening was renewed less often than the force; its error is then to be estimated.
    """

    strain: Array
    stress: Array
    stress_sd: Array
    noise: CurveNoise
    renewed_late: bool


def loading_of(curve: StressStrain, noise: CurveNoise | None) -> Loading:
    """Return the loading part of a curve, up to its peak.

    Where the opening is renewed less often than the force, only readings with a new opening are kept: the others
    pair a force with an opening of some time before.
    """
    strain, stress = curve.strain, curve.stress
    end = max(end_of_loading(strain, stress), min(len(stress), MIN_READINGS))
    late = False
    if noise is None:
        span = float(np.max(stress) - np.min(stress))
        quantum = quantum_of(strain)
        sd = max(spread_of(stress), 1e-6 * span, 1e-12)
        late = quantum == 0 and _held_share(strain[:end]) > HELD_SHARE
        noise = CurveNoise(max(sd, HELD_STRESS_SD * span) if late else sd, late, quantum)
    each = np.broadcast_to(np.asarray(noise.stress_sd, dtype=np.float64), stress.shape)
    keep = np.arange(end)
    if late:
        new = np.concatenate([[True], np.diff(strain[:end]) != 0])
        keep = np.flatnonzero(new)
    return Loading(strain[keep], stress[keep], np.array(each[keep]), noise, late)


def end_of_loading(strain: Array, stress: Array) -> int:
    """Return how many readings belong to the loading: up to the peak of stress near the largest strain."""
    middle = _running_median(strain, 5)
    span = float(np.max(middle) - np.min(middle))
    peak = int(np.argmax(middle))
    if middle[-1] > middle[peak] - 0.1 * span:
        return len(strain)  # it never opens again
    near = np.flatnonzero(middle >= middle[peak] - 0.1 * span)
    force = _running_median(stress, 5)
    return int(near[np.argmax(force[near])]) + 1


def quantum_of(series: Array) -> float:
    """Return the step of a quantised series, or 0 where its values lie on no common grid."""
    values = np.unique(series)
    if len(values) < 3:
        return float(values[-1] - values[0]) if len(values) == 2 else 0.0
    steps = np.diff(values)
    quantum = float(np.min(steps))
    if quantum <= 1e-9 * float(values[-1] - values[0]):
        return 0.0
    multiples = steps / quantum
    on_grid = bool(np.max(np.abs(multiples - np.round(multiples))) < 1e-3)
    return quantum if on_grid and len(values) < 0.7 * len(series) else 0.0


def _running_median(series: Array, width: int) -> Array:
    half = width // 2
    padded = np.concatenate([np.repeat(series[0], half), series, np.repeat(series[-1], half)])
    middle: Array = np.median(np.lib.stride_tricks.sliding_window_view(padded, width), axis=1)
    return middle


def spread_of(stress: Array) -> float:
    """Return a first guess of the readings' noise from their second differences, spikes or not [Pa]."""
    if len(stress) < 4:
        return 0.0
    bends = np.abs(np.diff(stress, 2))
    return float(np.median(bends) / (0.6745 * math.sqrt(6.0)))


def _held_share(strain: Array) -> float:
    return float(np.mean(np.diff(strain) == 0)) if len(strain) > 1 else 0.0
