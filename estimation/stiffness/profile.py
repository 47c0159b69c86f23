"""The interval of a modulus from its profile likelihood: for moduli that a Gaussian does not fit.

The log-likelihood, maximised over every other parameter, is followed over the log of the modulus. Where it is
still high at the far end, gripper and pads could be all that gave way, and the modulus has a lower bound only.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from estimation.stiffness.fit import MODULUS, Fit, Prior, Readings, refine

Array = NDArray[np.float64]

DROP_TWO_SIDED, DROP_ONE_SIDED = 1.92, 1.353  # of the log-likelihood, for 95 %
SOFTEST, STIFFEST = math.log(0.1), math.log(1000.0)  # followed from the start, at most
STEP = 0.2  # of the log of the modulus, at most
COARSE = 1.5  # drop of the log-likelihood over a step to both sides of the peak, from which steps are too wide


@dataclass(frozen=True)
class Profile:
    """What the readings say of the modulus, whatever the other parameters.

    Attributes:
        modulus: the most probable [Pa].
        low, high: ends of the 95 % interval [Pa]; high infinite where there is none.
        least: with 95 % confidence the modulus is at least this [Pa].
        fit: at the most probable modulus.
        open_ended: whether the stiffest modulus that was tried is the most probable.
    """

    modulus: float
    low: float
    high: float
    least: float
    fit: Fit
    open_ended: bool


def profile(
    readings: Readings, scale: float, prior: Prior, start: Array, *, peak_only: bool = False, width: float = STEP
) -> Profile:
    """Follow the profile likelihood from a start upwards and downwards, in steps that fit its peak.

    Args:
        readings: of the curve.
        scale: of the noise.
        prior: of the parameters.
        start: parameters, near the most probable ones, (5 + k,).
        peak_only: whether the ends of the interval are not needed; low and high are then meaningless.
        width: of a step, of the log of the modulus.
    """
    known = replace(readings, sd=readings.sd * scale)
    centre = float(start[MODULUS])
    mean, spread = prior.mean.copy(), prior.sd.copy()
    spread[MODULUS] = 0.0
    far = 0.5 if peak_only else 2 * DROP_TWO_SIDED
    logs: dict[int, float] = {}
    starts: dict[int, Fit] = {}

    def follow(step: int, start: Array) -> float:
        fixed = np.array(start)
        mean[MODULUS] = fixed[MODULUS] = centre * math.exp(step * width)
        found = refine(known, fixed, Prior(mean, spread), scale_known=True)
        logs[step], starts[step] = found.log_likelihood, found
        return found.log_likelihood

    best = follow(0, start)
    for direction, last in ((1, round(STIFFEST / width)), (-1, round(SOFTEST / width))):
        step = 0
        while step != last:
            value = follow(step + direction, starts[step].parameters)
            step += direction
            best = max(best, value)
            if value < best - far:
                break
    steps = np.array(sorted(logs))
    drop = best - np.array([logs[s] for s in steps])
    at = int(np.argmin(drop))
    least_rise = float(drop[[at - 1, at + 1]].min()) if 0 < at < len(drop) - 1 else 0.0
    if least_rise > COARSE:
        finer, nearest = width / math.sqrt(least_rise), starts[int(steps[at])].parameters
        return profile(readings, scale, prior, nearest, peak_only=peak_only, width=finer)
    peak = _vertex(np.exp(width * steps), drop, at)
    low, high = _crossing(steps, drop, at, -1, DROP_TWO_SIDED), _crossing(steps, drop, at, 1, DROP_TWO_SIDED)
    least = _crossing(steps, drop, at, -1, DROP_ONE_SIDED)
    free = refine(known, starts[int(steps[at])].parameters, prior, scale_known=True)
    return Profile(
        modulus=centre * peak,
        low=0.0 if low is None else centre * math.exp(low * width),
        high=math.inf if high is None else centre * math.exp(high * width),
        least=0.0 if least is None else centre * math.exp(least * width),
        fit=replace(free, scale=scale),
        open_ended=at == len(steps) - 1,
    )


def _vertex(modulus: Array, drop: Array, at: int) -> float:
    """Return where a parabola through the lowest point and its neighbours is lowest, between these."""
    if not 0 < at < len(drop) - 1:
        return float(modulus[at])
    x, y = modulus[at - 1 : at + 2] - modulus[at], drop[at - 1 : at + 2] - drop[at]
    bend, slope = np.linalg.solve(np.stack([x[[0, 2]] ** 2, x[[0, 2]]], axis=1), y[[0, 2]])
    shift = np.clip(-slope / (2 * bend), x[0] / 2, x[2] / 2) if bend > 0 else 0.0
    return float(modulus[at] + shift)


def _crossing(steps: Array, drop: Array, at: int, direction: int, level: float) -> float | None:
    """Return the farthest step in a direction at which the drop rises through a level, or None without one.

    Between two steps its root is taken to be straight, as it is for a Gaussian.
    """
    side = np.arange(at, len(drop)) if direction > 0 else np.arange(at, -1, -1)
    below = np.flatnonzero(drop[side] < level)
    last = int(below[-1])
    if last + 1 >= len(side):
        return None
    inner, outer = side[last], side[last + 1]
    near, far = math.sqrt(drop[inner]), math.sqrt(drop[outer])
    share = (math.sqrt(level) - near) / (far - near)
    return float(steps[inner] + share * (steps[outer] - steps[inner]))
