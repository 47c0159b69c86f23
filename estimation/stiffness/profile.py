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
STEP = 0.2  # of the log of the modulus


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


def profile(readings: Readings, scale: float, prior: Prior, start: Array, *, peak_only: bool = False) -> Profile:
    """Follow the profile likelihood from a start upwards and downwards.

    Args:
        readings: of the curve.
        scale: of the noise.
        prior: of the parameters.
        start: parameters, near the most probable ones, (5 + k,).
        peak_only: whether the ends of the interval are not needed; low and high are then meaningless.
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
        mean[MODULUS] = fixed[MODULUS] = centre * math.exp(step * STEP)
        found = refine(known, fixed, Prior(mean, spread), scale_known=True)
        logs[step], starts[step] = found.log_likelihood, found
        return found.log_likelihood

    best = follow(0, start)
    for direction, last in ((1, round(STIFFEST / STEP)), (-1, round(SOFTEST / STEP))):
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
    peak = float(steps[at]) + _vertex(drop, at)
    low, high = _crossing(steps, drop, at, -1, DROP_TWO_SIDED), _crossing(steps, drop, at, 1, DROP_TWO_SIDED)
    least = _crossing(steps, drop, at, -1, DROP_ONE_SIDED)
    free = refine(known, starts[int(steps[at])].parameters, prior, scale_known=True)
    return Profile(
        modulus=centre * math.exp(peak * STEP),
        low=0.0 if low is None else centre * math.exp(low * STEP),
        high=math.inf if high is None else centre * math.exp(high * STEP),
        least=0.0 if least is None else centre * math.exp(least * STEP),
        fit=replace(free, scale=scale),
        open_ended=at == len(steps) - 1,
    )


def _vertex(drop: Array, at: int) -> float:
    """Return where, in steps from the lowest point, a parabola through it and its neighbours is lowest."""
    if not 0 < at < len(drop) - 1:
        return 0.0
    left, middle, right = drop[at - 1 : at + 2]
    bend = float(left - 2 * middle + right)
    return float(np.clip((left - right) / (2 * bend), -0.5, 0.5)) if bend > 0 else 0.0


def _crossing(steps: Array, drop: Array, at: int, direction: int, level: float) -> float | None:
    """Return the farthest step in a direction at which the drop rises through a level, or None without one."""
    side = np.arange(at, len(drop)) if direction > 0 else np.arange(at, -1, -1)
    below = np.flatnonzero(drop[side] < level)
    last = int(below[-1])
    if last + 1 >= len(side):
        return None
    inner, outer = side[last], side[last + 1]
    share = (level - drop[inner]) / (drop[outer] - drop[inner])
    return float(steps[inner] + share * (steps[outer] - steps[inner]))
