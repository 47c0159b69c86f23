"""What a rub along the sides of a pinched object tells: a coefficient of friction, by gripper and joint torques.

The object stands on the table between the pads, which press on it from both sides with a force F and are then
driven down along its sides. Where all of a pad slides the same way the arm feels T = 2 mu F, whatever the object
weighs. Pads that judder slide in several ways at once, and hold with less: T is taken from the upper part of its
readings, and what it still falls short by is known from how far the pull falls on the way, ``net``.

F rises with T, for pads that are dragged along lean in, and is lost again where they jump. So what they pulled
before a jump belongs to a larger F than is read after it, and what they pull at rest to no more than mu F: T is
the geometric mean of the two.

F is read when the gripper begins to close again, right after the slide, for a locked gripper's current says
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
from estimation.squeezing import CURRENT_RELATIVE_SD, CURRENT_SD, air_current

Array = NDArray[np.float64]

LATE = 0.5  # share of the time of a slide from which it counts: before, the object is sheared and does not slide
RESTING = 0.1  # share of the time of a slide in which the pads have come to rest, at its end
UPPER = 0.7  # quantile of the readings between: judder lets the pads slide several ways and pull less
FALL_SD = 0.25  # of one slide, per logarithm of the pull there over that at rest
JUMP = 0.2  # share of its pull to which it falls where pads jump
JUDDER_SD = 0.5  # of the method where they jump in all slides: very light things are thrown about between the pads
LEAST_LEFT = 0.05  # share of the pull that counts as left at rest at least
SMOOTH, SMOOTH_AIR = 5, 7  # samples of a running mean of the torques, with contact and without
NET, LOSS = 0.985, 0.1  # T over 2 mu F in a quiet slide, and how much less where judder takes all of the pull,
NET_SD = 0.05  # and what objects differ by in it, in simulation: see docs/stiffness.md
SUNK_SD = 1.0  # relative, per share of the width that pads sink in by: sides no longer upright
SLIDE_SD, SLIDE_KNOWN = 0.07, 4.0  # relative; of one slide, and how many slides would tell as much as is known
NEVER_SLID = 1.8  # ratio of the force at the end over that in the middle of the way; 2 where nothing slides
NEAR = 5  # readings of a closing that tell the force at its start
FELL = 0.2  # share of the force by which it may not fall as the gripper closes, or the pads have jumped
ROSE = 1.2  # times the force at the start, beyond noise, to which a closing tells of it
MET = 0.03  # A over that in air, at which the pads have met the object
FELT = 0.5  # N; smaller forces cannot be told from the gripper's own friction


@dataclass(frozen=True)
class Slide:
    """One slide of the pads along the object's sides.

    Attributes:
        sliding: tangential force while it slid, on both pads together [N].
        middle, end: tangential force half way and at the end, when the pads have come to rest [N].
        before, after: force of a pad when it began, roughly, and when it was over [N].
        force_sd: of the force when it was over, by the noise of the readings [N].
        sunk: share of the object's width by which the pads have sunk in [-].
        kept: least share of the pull reached before that it fell to on the way [-].
    """

    sliding: float
    middle: float
    end: float
    before: float
    after: float
    force_sd: float
    sunk: float = 0.0
    kept: float = 1.0

    @property
    def force(self) -> float:
        """Force of a pad while it slid [N]: that when it was over, better known and longer there than before."""
        return self.after

    @property
    def left(self) -> float:
        """Share of the pull that is left at rest [-]."""
        return max(self.end / self.sliding, LEAST_LEFT)

    @property
    def tangential(self) -> float:
        """Tangential force that belongs to the force of the pads [N]."""
        return self.sliding * math.sqrt(self.left)

    @property
    def net(self) -> float:
        """Share of 2 mu F that the pads pull with [-]."""
        return NET - LOSS * (1 - max(self.kept, 0.0))

    @property
    def coefficient(self) -> float:
        """Coefficient of friction [-]."""
        return self.tangential / (2 * self.net * self.force)

    @property
    def relative_sd(self) -> float:
        """Relative standard deviation of the coefficient, as far as slides differ in it [-]."""
        return math.hypot(SLIDE_SD, self.force_sd / self.force, FALL_SD * math.log(self.left))

    @property
    def jumped(self) -> bool:
        """Tell whether the pads lost hold of the object on the way."""
        return self.kept < JUMP


def measure_pinched_rub(
    arm: Arm, gripper: ParallelGripper, phases: Sequence[Phase]
) -> tuple[FrictionEstimate, Measurement]:
    """Estimate friction from slides of closed pads down the sides of an object.

    mu = T / (2 net F) of every slide; slides are fused with odd ones weighed down. Their variance is in part
    what is known of slides and in part how these differ, by (n0 + sum r^2) / (n0 + n - 1) with their residuals r
    over what is known. The uncertainty of the force's calibration, of the torque sensors' scale and of the
    method are common to all and added after.

    Args:
        arm, gripper: their descriptions.
        phases: ``idle`` (the gripper closes in air), ``air`` (the slide's motion with nothing between the pads),
            and for every ``slide`` a ``touch`` or ``press`` (the gripper closes on the object) before it, and a
            ``press`` after it.

    Raises:
        InvalidInput: if phases are missing, the pads press too little to tell, or never slid.
    """
    slides = find_slides(arm, gripper, phases)
    stuck = [slide for slide in slides if slide.end > NEVER_SLID * slide.middle and not slide.jumped]
    if len(stuck) > len(slides) / 2:
        least = max(slide.end / (2 * slide.force) for slide in stuck)
        raise InvalidInput("rub: slides", "forces that only rise", f"pads that slide; mu is {least:.2f} or more")
    found = np.array([slide.coefficient for slide in slides])
    middle = float(np.median(found))
    own = np.array([slide.relative_sd for slide in slides])
    fused = fuse([Measurement("friction", c, middle * sd, "1") for c, sd in zip(found, own, strict=True)])
    spread = fused.sd * _differ((found / fused.mean - 1) / own)
    normal = float(np.median([slide.force for slide in slides]))
    sunk = float(np.median([slide.sunk for slide in slides]))
    calibration = float(gripper.force_sd(np.array([normal]))[0]) / normal
    judder = JUDDER_SD * sum(slide.jumped for slide in slides) / len(slides)
    common = math.hypot(calibration, math.sqrt(2) * arm.torque_gain_sd, NET_SD, SUNK_SD * sunk, judder)
    mu, sd = fused.mean, math.hypot(spread, common * fused.mean)
    interval = (max(mu - 1.96 * sd, 0.0), mu + 1.96 * sd)
    estimate = FrictionEstimate(mu, sd, interval, mu, math.nan, 0.0, normal, "pinched rub")
    return estimate, estimate.measurement()


def find_slides(arm: Arm, gripper: ParallelGripper, phases: Sequence[Phase]) -> tuple[Slide, ...]:
    """Return what every slide of a pinched rub came to.

    Raises:
        InvalidInput: if phases are missing or say nothing of the force.
    """
    free = [phase for phase in phases if phase.name == "air"]
    slides = [number for number, phase in enumerate(phases) if phase.name == "slide"]
    presses = [number for number, phase in enumerate(phases) if phase.name == "press"]
    touches = [number for number, phase in enumerate(phases) if phase.name == "touch"]
    if not free or not slides:
        raise InvalidInput("rub: phases", sorted({p.name for p in phases}), "phases named air and slide")
    air, _ = air_current([phase.gripper() for phase in phases if phase.name == "idle"], gripper)
    locked = _locked([sample.effort for number in slides for sample in phases[number].samples])
    baseline = _Baseline(arm, free[0].samples)
    found = []
    for number in slides:
        before = [p for p in (*touches, *presses) if p < number]
        after = [p for p in presses if p > number]
        if not before or not after:
            raise InvalidInput("rub: phases", "a slide without a press after it, or a touch before it", "both")
        pressed = _pressed(arm, gripper, phases[min(after)].samples, baseline.last, air, locked)
        if pressed is None or pressed[0] < FELT:
            continue
        met = max((p for p in touches if p < number), default=max(before))
        pull = _running_mean(baseline.tangential(phases[number].samples), SMOOTH)
        count = len(pull)
        resting = round((1 - RESTING) * count)
        found.append(
            Slide(
                sliding=float(np.quantile(pull[round(LATE * count) : resting], UPPER)),
                middle=float(np.median(pull[round(0.4 * count) : round(0.6 * count)])),
                end=float(np.median(pull[resting:])),
                before=_closed(gripper, phases[max(before)].samples, air),
                after=pressed[0],
                force_sd=pressed[1],
                kept=_least_kept(pull[:resting]),
                sunk=_sunk(phases[met].samples, phases[number].samples, air),
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


def _pressed(
    arm: Arm, gripper: ParallelGripper, samples: Sequence[Sample], free: Array, air: float, locked: float
) -> tuple[float, float] | None:
    """Return the force of a pad as a gripper begins to close and its sd [N]; None if the readings do not say.

    A closing speeds up evenly at first: the force rises with the square of the time, F(t) = F + c t^2, until the
    pads jump.
    """
    at = np.flatnonzero([s.effort > locked for s in samples])
    if not len(at):
        return None
    used = samples[at[0] : at[-1] + 1][:NEAR]
    effort = np.array([s.effort for s in used])
    pull = np.array([tangential(arm, s, free) for s in used])
    swing = np.array([gripper.swing(s.opening) for s in used])
    force = gripper.force_per_ampere * (effort - air) + gripper.friction_force - swing * pull / 2
    noise = math.hypot(
        CURRENT_SD, gripper.effort_quantum / math.sqrt(12.0), CURRENT_RELATIVE_SD * float(effort[0])
    )
    sd = gripper.force_per_ampere * noise
    ends = (force < (1 - FELL) * np.maximum.accumulate(force) - 2 * sd) | (force > ROSE * force[0] + 2 * sd)
    if ends.any():
        force = force[: max(int(np.argmax(ends)), 1)]
    squares = np.arange(1.0, len(force) + 1) ** 2
    spread = float(np.sum((squares - squares.mean()) ** 2))
    rise = float((squares - squares.mean()) @ force) / spread if spread else 0.0
    if rise <= 0:
        return float(force.mean()), sd / math.sqrt(len(force))
    start = float(force.mean() - rise * squares.mean())
    return start, sd * math.sqrt(1 / len(force) + squares.mean() ** 2 / spread)


def _least_kept(pull: Array) -> float:
    """Return the least share of the largest pull before that is left on the way, once it has begun [-]."""
    share = pull / np.maximum(np.maximum.accumulate(pull), 1e-9)
    return float(share[len(share) // 4 :].min())


def _sunk(touch: Sequence[Sample], slide: Sequence[Sample], air: float) -> float:
    """Return by what share of the object's width pads have closed since they met it [-]."""
    met = [sample.opening for sample in touch if sample.effort > air + MET]
    now = float(np.median([sample.opening for sample in slide]))
    return max(1 - now / met[0], 0.0) if met and met[0] > 0 else 0.0


def _closed(gripper: ParallelGripper, samples: Sequence[Sample], air: float) -> float:
    """Return about what a pad pressed with at the end of a closing [N]."""
    effort = max(s.effort for s in samples[len(samples) // 2 :])
    return gripper.force_per_ampere * max(effort - air, 0.0) + gripper.friction_force


def _differ(residual: Array) -> float:
    """Return by how much slides differ more than is known of slides, from residuals over their sd.

    One that went wrong counts as three standard deviations: it is weighed down where slides are fused.
    """
    usual = np.clip(residual, -3.0, 3.0)
    return math.sqrt((SLIDE_KNOWN + float(usual @ usual)) / (SLIDE_KNOWN + len(usual) - 1))


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
