"""What a rub along the sides of a pinched object tells: a coefficient of friction, by gripper and joint torques.

The object stands on the table between the pads, which press on it from both sides with a force F and are then
driven down along its sides. At the limit of friction the arm feels T = 2 mu F, whatever the object weighs.

F is read while the gripper closes, shortly before and after the pads slide, for a locked gripper's current says
nothing of force. The pads swing down as they close, by ``gripper.swing`` of their way, against the friction on
them: the motor feels F + swing T / 2.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dynamics.arm import Arm
from dynamics.errors import InvalidInput
from dynamics.gripper import ParallelGripper
from dynamics.signals import Phase, Sample
from estimation.friction import FrictionEstimate
from estimation.fusion import fuse
from estimation.measurement import Measurement
from estimation.squeezing import air_current

Array = NDArray[np.float64]

SLIDING_SHARE = 0.5  # of the time of a slide, its end: before, the object is sheared and does not slide yet
CAUGHT = 1.2  # ratio to the force at the end above which the pads had caught on something rather than slid
SMOOTH, SMOOTH_AIR = 3, 7  # samples of a running mean of the torques, with contact and without
SLIDE_SD = 0.12  # relative; scatter of one slide, from the simulation: stick and slip, and what F does meanwhile
PINCH_SD = 0.06  # relative, common to all slides: where in stick and slip the limit is, how pads lie on sides
NEVER_SLID = 1.8  # ratio of the force at the end over that in the middle of the way; 2 where nothing slides
NEAR = 5  # samples of a closing that tell the force at its start or end
FELT = 0.5  # N; smaller forces cannot be told from the gripper's own friction


@dataclass(frozen=True)
class Slide:
    """One slide of the pads along the object's sides.

    Attributes:
        tangential: while it slid, on both pads together [N].
        middle, end: tangential force half way and at the end [N].
        before, after: force of a pad when it began and when it was over [N].
        force_sd: of the force, by the scatter of the readings [N].
    """

    tangential: float
    middle: float
    end: float
    before: float
    after: float
    force_sd: float

    @property
    def force(self) -> float:
        """Force of a pad while it slid, in the middle of the time that counts [N]."""
        return self.before + (1 - SLIDING_SHARE / 2) * (self.after - self.before)

    @property
    def coefficient(self) -> float:
        """Coefficient of friction [-]."""
        return self.tangential / (2 * self.force)


def measure_pinched_rub(
    arm: Arm, gripper: ParallelGripper, phases: Sequence[Phase]
) -> tuple[FrictionEstimate, Measurement]:
    """Estimate friction from slides of closed pads down the sides of an object.

    mu = T / (2 F) of every slide; slides are fused with odd ones weighed down. The uncertainty of the force's
    calibration, of the torque sensors' scale and of the method are common to all and added after.

    Args:
        arm, gripper: their descriptions.
        phases: ``idle`` (the gripper closes in air), ``air`` (the slide's motion with nothing between the pads),
            and for every ``slide`` a ``press`` (the gripper closes on the object) before and after it.

    Raises:
        InvalidInput: if phases are missing, the pads press too little to tell, or never slid.
    """
    slides = find_slides(arm, gripper, phases)
    stuck = [slide for slide in slides if slide.end > NEVER_SLID * slide.middle]
    if len(stuck) > len(slides) / 2:
        least = max(slide.end / (2 * slide.force) for slide in stuck)
        raise InvalidInput("rub: slides", "forces that only rise", f"pads that slide; mu is {least:.2f} or more")
    readings = [
        Measurement("friction", s.coefficient, s.coefficient * math.hypot(SLIDE_SD, s.force_sd / s.force), "1")
        for s in slides
    ]
    fused = fuse(readings)
    normal = float(np.median([slide.force for slide in slides]))
    common = math.hypot(
        float(gripper.force_sd(np.array([normal]))[0]) / normal, math.sqrt(2) * arm.torque_gain_sd, PINCH_SD
    )
    mu, sd = fused.mean, math.hypot(fused.sd, common * fused.mean)
    interval = (max(mu - 1.96 * sd, 0.0), mu + 1.96 * sd)
    found = FrictionEstimate(mu, sd, interval, mu, math.nan, 0.0, normal, "pinched rub")
    return found, found.measurement()


def find_slides(arm: Arm, gripper: ParallelGripper, phases: Sequence[Phase]) -> tuple[Slide, ...]:
    """Return what every slide of a pinched rub came to.

    Raises:
        InvalidInput: if phases are missing or say nothing of the force.
    """
    free = [phase for phase in phases if phase.name == "air"]
    slides = [number for number, phase in enumerate(phases) if phase.name == "slide"]
    presses = [number for number, phase in enumerate(phases) if phase.name == "press"]
    if not free or not slides:
        raise InvalidInput("rub: phases", sorted({p.name for p in phases}), "phases named air and slide")
    air, _ = air_current([phase.gripper() for phase in phases if phase.name == "idle"], gripper)
    locked = _locked([sample.effort for number in slides for sample in phases[number].samples])
    baseline = _Baseline(arm, free[0].samples)
    found = []
    for number in slides:
        before = [p for p in presses if p < number]
        after = [p for p in presses if p > number]
        if not before or not after:
            raise InvalidInput("rub: phases", "a slide without a press before and after it", "both")
        first = _press(arm, gripper, phases[before[-1]].samples, baseline.first, air, locked)
        last = _press(arm, gripper, phases[after[0]].samples, baseline.last, air, locked)
        if first is None or last is None or min(first[1], last[0]) < FELT:
            continue
        pull = _running_mean(baseline.tangential(phases[number].samples), SMOOTH)
        count = len(pull)
        sliding = pull[round(count * (1 - SLIDING_SHARE)) :]
        end = float(np.median(pull[round(0.8 * count) :]))
        found.append(
            Slide(
                tangential=min(float(np.median(sliding)), CAUGHT * end),
                middle=float(np.median(pull[round(0.4 * count) : round(0.6 * count)])),
                end=end,
                before=first[1],
                after=last[0],
                force_sd=math.hypot(first[2], last[2]) / 2,
            )
        )
    if not found:
        raise InvalidInput("rub: force of the pads", f"less than {FELT:g} N", "pads that press on the object")
    return tuple(found)


class _Baseline:
    """What the joint torques are without contact, along a slide.

    Args:
        arm: its description.
        samples: of the motion in the air.
    """

    def __init__(self, arm: Arm, samples: Sequence[Sample]) -> None:
        self._arm = arm
        self._residual = _running_mean(np.array([s.tau - arm.gravity(s.q) for s in samples]), SMOOTH_AIR)
        self.first, self.last = self._residual[0], self._residual[-1]

    def tangential(self, samples: Sequence[Sample]) -> Array:
        """Return the force on the pads in their plane at every sample of a slide [N], (N,)."""
        at = np.linspace(0, len(self._residual) - 1, len(samples))
        rows = np.arange(len(self._residual))
        columns = [np.interp(at, rows, joint) for joint in self._residual.T]
        return np.array(
            [tangential(self._arm, s, free) for s, free in zip(samples, np.stack(columns, 1), strict=True)]
        )


def tangential(arm: Arm, sample: Sample, free: Array) -> float:
    """Return the force on the pads in their plane [N], by least squares of J^T f = tau - gravity - free.

    Args:
        arm: its description.
        sample: with the pads on the object.
        free: torque beyond gravity's at the same place without contact [N m], (nv,).
    """
    rotation = arm.tool_pose(sample.q)[:3, :3]
    jacobian = rotation @ arm.tool_jacobian(sample.q)[:3]
    force = np.linalg.lstsq(jacobian.T, sample.tau - arm.gravity(sample.q) - free, rcond=None)[0]
    closing = rotation[:, 1]
    return float(np.linalg.norm(force - closing * (closing @ force)))


def _press(
    arm: Arm, gripper: ParallelGripper, samples: Sequence[Sample], free: Array, air: float, locked: float
) -> tuple[float, float, float] | None:
    """Return the force of a pad at the start and the end of a closing and their sd [N]; None if it says nothing.

    A closing speeds up evenly at first, and slows down evenly at last: the force goes with the square of the time.
    """
    at = np.flatnonzero([s.effort > locked for s in samples])
    if not len(at):
        return None
    used = samples[at[0] : at[-1] + 1]
    motor = gripper.force_per_ampere * (np.array([s.effort for s in used]) - air) + gripper.friction_force
    swing = np.array([gripper.swing(s.opening) for s in used])
    force = motor - swing * np.array([tangential(arm, s, free) for s in used]) / 2
    steps = np.arange(1.0, len(force) + 1)
    start, start_sd = _intercept(steps[:NEAR] ** 2, force[:NEAR])
    end, end_sd = _intercept((steps[:NEAR] - 1) ** 2, force[::-1][:NEAR])
    return start, end, math.hypot(start_sd, end_sd) / math.sqrt(2)


def _intercept(x: Array, force: Array) -> tuple[float, float]:
    """Return the value at 0 of a line through forces and its standard deviation [N]; the mean of fewer than 3."""
    if len(force) < 3:
        return float(force.mean()), float(np.ptp(force)) / 2
    (slope, value), covariance = np.polyfit(x, force, 1), np.linalg.inv(_normal(x))
    residual = force - slope * x - value
    return float(value), math.sqrt(float(covariance[1, 1] * (residual @ residual)) / (len(force) - 2))


def _normal(x: Array) -> Array:
    design = np.stack([x, np.ones_like(x)], axis=1)
    normal: Array = design.T @ design
    return normal


def _locked(effort: Sequence[float]) -> float:
    """Return the current above which the gripper must be moving [A]."""
    values = np.asarray(effort)
    middle = float(np.median(values))
    return middle + 3 * 1.4826 * float(np.median(np.abs(values - middle)))


def _running_mean(series: Array, width: int) -> Array:
    """Return the mean over a sliding window along the first axis; as many as there were, the ends repeated."""
    if len(series) < width:
        return np.broadcast_to(series.mean(axis=0), series.shape).copy()
    half = width // 2
    padded = np.concatenate([series[:1].repeat(half, axis=0), series, series[-1:].repeat(half, axis=0)])
    total = np.cumsum(np.concatenate([np.zeros_like(padded[:1]), padded]), axis=0)
    mean: Array = (total[width:] - total[:-width]) / width
    return mean
