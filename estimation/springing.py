"""Whether an object springs back: how much of the work of pressing it first is not there when it is pressed again.

Clay, or foam past its yield, keeps the shape that it is pressed to. Its first loading tells more of its yield than
of its elasticity; elastic are the readings of pads that close on it again, up to where it had been pressed before.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from dynamics.signals import GripperReadings, Phase

Array = NDArray[np.float64]

PLASTIC = 0.6  # share of the work lost that is not sprung back; the table's drag feigns 0.3, noise 0.2
LEAST_TICKS = 4.0  # steps of the opening that pads must have come back to tell
MOST_CONTINUED = 3.0  # times what was passed, as which a line is believed
STARTING = 2  # readings at the start of a motion in which the current is that of a motor that speeds up
_CLOSINGS = ("grasp", "regrasp", "close", "compress")
_POINTS = 50
_FEWEST = 4


def lost_work(phases: Sequence[Phase], air: float, tick: float) -> float:
    """Return the share of the work of pressing an object first that is not there when it is pressed again [-].

    1 - W' / W with W the integral of (I - air) dx from where the object was met to where it was pressed before the
    last squeeze, W' that of the last squeeze; where the pads had not let go before it, its readings are continued
    in a straight line. 0 where the pads came back too little to tell.

    Args:
        phases: of a squeeze.
        air: current of a gripper that closes on nothing [A].
        tick: step of the opening's reading [m].
    """
    first, again = _first_and_again(phases)
    x, current = _curve(first)
    x_again, current_again = _curve(again[-1:])
    if len(x) < _FEWEST or len(x_again) < _FEWEST or np.ptp(x_again) < max(LEAST_TICKS * tick, 1e-6):
        return 0.0
    at = np.linspace(max(x[0], x_again[0]), x[-1], _POINTS)
    work = float(np.mean(np.maximum(np.interp(at, x, current) - air, 0.0)))
    line = _line(x_again, current_again)
    beyond = np.maximum(line[0] + line[1] * at - air, 0.0)
    passed = np.interp(at, x_again, current_again) - air
    work_again = float(np.mean(np.where(at > x_again[-1], beyond, np.maximum(passed, 0.0))))
    return float(np.clip(1 - work_again / work, 0.0, 1.0)) if work > 0 else 0.0


def comes_back(phases: Sequence[Phase], effort: float, tick: float) -> float:
    """Return how far an object comes back from where it was pressed last until it presses with a current only [m].

    Read off the last squeeze, up to where the object had been pressed before it, and continued in a straight line:
    what springs back less and less steeply comes back further than that. From further on, with more force, it
    comes back no less. 0 where the pads passed too little to tell.

    Args:
        phases: of a squeeze.
        effort: the current [A].
        tick: step of the opening's reading [m].
    """
    x, current = _curve(_first_and_again(phases)[1][-1:])
    if len(x) < 2 or np.ptp(x) < max(tick / 2, 1e-6):
        return 0.0
    intercept, slope = _line(x, current)
    if slope >= 0:
        return 0.0
    return float(np.clip((effort - intercept) / slope - x[0], 0.0, MOST_CONTINUED * np.ptp(x)))


def elastic_readings(phases: Sequence[Phase]) -> list[GripperReadings]:
    """Return the readings of every ``compress`` up to where the object had been pressed before."""
    return [readings for squeeze in _first_and_again(phases, 0)[1] for readings in squeeze]


def _first_and_again(
    phases: Sequence[Phase], skip: int = STARTING
) -> tuple[list[GripperReadings], list[list[GripperReadings]]]:
    """Return the readings of pads that press further than ever, and those of every squeeze before it does."""
    deepest = before = np.inf
    first: list[GripperReadings] = []
    again: list[list[GripperReadings]] = [[]]
    for phase in phases:
        if phase.name == "release":
            again.append([])
            before = deepest
        if phase.name not in _CLOSINGS or len(phase.samples) <= skip:
            continue
        readings = phase.gripper()
        at = np.arange(len(readings)) >= skip
        first.append(_rows(readings, at & (readings.opening < deepest)))
        at &= readings.opening > before
        if phase.name == "compress" and at.any():
            again[-1].append(_rows(readings, at))
        deepest = min(deepest, float(readings.opening.min()))
    return first, [squeeze for squeeze in again if squeeze]


def _line(x: Array, current: Array) -> tuple[float, float]:
    """Return intercept and slope of the less tight half of a curve, or of all of a short one."""
    loose = x >= (x[0] + x[-1]) / 2
    if loose.sum() < _FEWEST:
        loose[:] = True
    slope, intercept = np.polyfit(x[loose], current[loose], 1)
    return float(intercept), float(slope)


def _curve(series: Sequence[GripperReadings] | Sequence[Sequence[GripperReadings]]) -> tuple[Array, Array]:
    """Return the openings that were passed, ascending, and the mean current at each."""
    flat = [r for one in series for r in ([one] if isinstance(one, GripperReadings) else one)]
    openings = np.concatenate([np.zeros(0), *(readings.opening for readings in flat)])
    efforts = np.concatenate([np.zeros(0), *(readings.effort for readings in flat)])
    x, which = np.unique(openings, return_inverse=True)
    return x, np.bincount(which, weights=efforts) / np.bincount(which) if len(x) else x


def _rows(readings: GripperReadings, at: NDArray[np.bool_]) -> GripperReadings:
    return replace(readings, opening=readings.opening[at], effort=readings.effort[at], time=readings.time[at])
