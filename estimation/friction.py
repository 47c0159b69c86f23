"""Friction of an object's surface: from rubbing over it, or from the grip at which it begins to slip.

rub          mu = mean |tangential force| / mean normal force, over strokes forward and backward
slip onset   mu = m g / (2 F), at the grip force F at which a held object of mass m begins to slide
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dynamics.errors import InvalidInput
from estimation.measurement import Measurement

Array = NDArray[np.float64]

GRAVITY = 9.81  # m/s^2
USED_SHARE = 0.5  # of a stroke, its end: before, the surface is dragged along and does not slide yet
BATCHES = 8  # stretches of a stroke whose means are taken as independent
MIN_READINGS = 24  # of a stroke
SHEAR_SD = 0.03  # relative; what a surface that tilts under the pad takes off, not known better
SLIP_POWERS = (1.0, 2.0, 3.0)  # of time, that a slide may grow with
SLIP_EVIDENCE = 5.0  # length of the slide over the noise of the displacement
SCAN = 120  # candidate onsets


@dataclass(frozen=True)
class Stroke:
    """One stroke of a rub in one direction.

    Attributes:
        tangential: force on the object along a fixed axis, with its sign, offsets and all [N], (N,).
        normal: force into the surface [N], (N,).
        direction: 1 where the pad moves along the axis, -1 where it moves against it.
    """

    tangential: Array
    normal: Array
    direction: int

    def __post_init__(self) -> None:
        for name in ("tangential", "normal"):
            series = getattr(self, name)
            if np.ndim(series) != 1 or len(series) < MIN_READINGS or not np.all(np.isfinite(series)):
                raise InvalidInput(
                    f"stroke: {name} force [N]",
                    f"shape {np.shape(series)}",
                    f"{MIN_READINGS} or more finite numbers",
                )
        if len(self.tangential) != len(self.normal):
            raise InvalidInput(
                "stroke", f"{len(self.tangential)} and {len(self.normal)} forces", "as many of both"
            )
        if self.direction not in (-1, 1):
            raise InvalidInput("stroke: direction", self.direction, "1 or -1")


@dataclass(frozen=True)
class FrictionEstimate:
    """A coefficient of friction.

    Attributes:
        coefficient, sd: [-].
        interval: of 95 % [-].
        forward, backward: coefficients by direction, offset of the tangential force taken off; NaN where one is
            missing [-].
        offset: the tangential force that does not change sign with the direction [N].
        normal: mean normal force, or grip force at the onset of slip [N].
        method: ``rub`` or ``slip``.
    """

    coefficient: float
    sd: float
    interval: tuple[float, float]
    forward: float
    backward: float
    offset: float
    normal: float
    method: str

    def measurement(self) -> Measurement:
        """Return the measurement of friction."""
        return Measurement("friction", self.coefficient, self.sd, "1")


def estimate_friction(
    strokes: Sequence[Stroke], *, gain_sd: float = 0.0, offset_sd: float = math.inf
) -> FrictionEstimate:
    """Estimate the coefficient of friction from strokes of a rub.

    The ratio of means, not the mean of ratios: single contact forces fall to 0 on a stiff surface. With strokes
    both ways, mu = (mean T forward - mean T backward) / (mean N forward + mean N backward), so that a constant
    offset of the tangential force cancels. With one way only, the offset is in the uncertainty.

    Args:
        strokes: at least one.
        gain_sd: relative standard deviation of tangential over normal force, common to all strokes.
        offset_sd: of the tangential force [N]; needed where all strokes go the same way.

    Raises:
        InvalidInput: for no strokes, a normal force that is not positive, or one direction and no ``offset_sd``.
    """
    if not strokes:
        raise InvalidInput("friction: strokes", "none", "at least one")
    ways = {way: [s for s in strokes if s.direction == way] for way in (1, -1)}
    both = bool(ways[1]) and bool(ways[-1])
    if not both and not math.isfinite(offset_sd):
        raise InvalidInput("friction: strokes", "one direction", "strokes both ways, or the offset's sd")
    means = {way: _means(found) for way, found in ways.items() if found}
    normal = sum(m[0][1] for m in means.values()) / len(means)
    if not normal > 0:
        raise InvalidInput("friction: normal force [N]", normal, "a mean > 0")
    if both:
        (up, up_cov), (down, down_cov) = means[1], means[-1]
        pull, press = up[0] - down[0], up[1] + down[1]
        mu = pull / press
        covariance = up_cov + np.array([[1.0, -1.0], [-1.0, 1.0]]) * down_cov
        offset = (up[0] + down[0]) / 2 - mu * (up[1] - down[1]) / 2
        forward, backward = (up[0] - offset) / up[1], (offset - down[0]) / down[1]
        drift = 0.0
    else:
        way, ((tangential, press), covariance) = next(iter(means.items()))
        mu, offset = way * tangential / press, 0.0
        covariance = covariance * np.array([[1.0, way], [way, 1.0]])
        forward, backward = (mu, math.nan) if way > 0 else (math.nan, mu)
        drift = offset_sd / press
    row = np.array([1.0, -mu]) / press  # of the ratio by its two means
    sd = math.sqrt(float(row @ covariance @ row) + drift**2 + (mu * math.hypot(gain_sd, SHEAR_SD)) ** 2)
    return FrictionEstimate(mu, sd, (mu - 1.96 * sd, mu + 1.96 * sd), forward, backward, offset, normal, "rub")


def estimate_friction_at_slip(
    time: Array,
    displacement: Array,
    grip_force: Array,
    mass: float,
    *,
    mass_sd: float = 0.0,
    force_sd: float = 0.0,
) -> FrictionEstimate:
    """Estimate the coefficient of friction from the grip force at which a held object begins to slip.

    While the grip is loosened slowly, mu = m g / (2 F) at the onset. The onset is that of a hinge
    s(t) = s0 + a max(0, t - t0)^p fitted to the displacement, with p = 1, 2 or 3: a threshold would find it late,
    and the coefficient too high.

    Args:
        time: [s], (N,), in order.
        displacement: of the object against the pads [m], (N,).
        grip_force: of one pad [N], (N,), falling.
        mass, mass_sd: of the object [kg].
        force_sd: of the grip force, common to all readings [N].

    Raises:
        InvalidInput: for wrong shapes, unsorted time, a mass that is not positive, or an object that never slips.
    """
    series = [np.asarray(v, dtype=np.float64) for v in (time, displacement, grip_force)]
    if any(v.ndim != 1 or v.shape != series[0].shape or not np.all(np.isfinite(v)) for v in series):
        raise InvalidInput("slip", [v.shape for v in series], "equal shapes (N,) of finite numbers")
    t, s, force = series
    if len(t) < MIN_READINGS or np.any(np.diff(t) <= 0):
        raise InvalidInput("slip: time [s]", f"{len(t)} readings", f"{MIN_READINGS} or more, in order")
    if not mass > 0:
        raise InvalidInput("slip: mass [kg]", mass, "a number > 0")
    noise = max(float(np.median(np.abs(np.diff(s)))) / 0.954, 1e-9)
    pressed = t[force > 0]
    if len(pressed) < MIN_READINGS:
        raise InvalidInput("slip: grip force [N]", f"{len(pressed)} readings over 0", f"{MIN_READINGS} or more")
    candidates = np.linspace(pressed[0], pressed[-1], SCAN)
    loss = np.full((len(SLIP_POWERS), SCAN), np.inf)
    for i, power in enumerate(SLIP_POWERS):
        for j, onset in enumerate(candidates[1:-3], start=1):
            h = np.maximum(t - onset, 0.0) ** power
            design = np.stack([np.ones_like(t), h], axis=1)
            fitted, *_ = np.linalg.lstsq(design, s, rcond=None)
            loss[i, j] = float(np.sum((s - design @ fitted) ** 2))
    i, j = divmod(int(np.argmin(loss)), SCAN)
    flat = float(np.sum((s - s.mean()) ** 2))
    if (
        not abs(float(np.mean(s[-3:]) - np.median(s[: len(s) // 4]))) > SLIP_EVIDENCE * noise
        or loss[i, j] > 0.5 * flat
    ):
        raise InvalidInput(
            "slip: displacement [m]", f"{np.ptp(s):.2g} over noise {noise:.2g}", "an object that slips"
        )
    variance = max(loss[i, j] / (len(t) - 4), 1e-18)
    share = np.exp(-(loss - loss[i, j]) / (2 * variance))
    share /= share.sum()
    found = mass * GRAVITY / (2 * np.interp(candidates, t, force))
    mu = float(np.sum(share * found))
    at_onset = mass * GRAVITY / (2 * mu)
    grid = float(found[min(j + 1, SCAN - 1)] - found[max(j - 1, 0)]) / 2 / math.sqrt(12.0)
    spread = math.sqrt(float(np.sum(share * (found - mu) ** 2)) + grid**2)
    sd = math.hypot(spread, mu * mass_sd / mass, mu * force_sd / at_onset)
    return FrictionEstimate(mu, sd, (mu - 1.96 * sd, mu + 1.96 * sd), math.nan, math.nan, 0.0, at_onset, "slip")


def _means(strokes: Sequence[Stroke]) -> tuple[Array, Array]:
    """Return mean tangential and normal force of the strokes' ends and their covariance, (2,) and (2, 2)."""
    batches = []
    for stroke in strokes:
        start = round(len(stroke.tangential) * (1 - USED_SHARE))
        pair = np.stack([stroke.tangential[start:], stroke.normal[start:]], axis=1)
        batches += [part.mean(axis=0) for part in np.array_split(pair, BATCHES)]
    table = np.array(batches)
    return table.mean(axis=0), np.atleast_2d(np.cov(table.T)) / len(table)
