"""Repeated squeezes of one object: one stiffness from many, and the gripper's own from a rigid block's.

The graph of a fusion is linear, over the log of the modulus and the opening at contact. Every squeeze reads both
with correlated errors: a contact guessed too early makes the object seem softer, and the width that all squeezes
share takes that back. The calibration of force is common to all, so it is not averaged away.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dynamics.compression import Geometry, StressStrain, stress_strain
from dynamics.errors import InvalidInput
from estimation.graph import LinearGraph, key
from estimation.measurement import Measurement
from estimation.stiffness import estimate_stiffness
from estimation.stiffness.estimate import StiffnessEstimate
from estimation.stiffness.fit import MODULUS, ONSET

Array = NDArray[np.float64]

ODD_RATE = 0.05  # share of squeezes that went wrong
ODD_SCALE = 6.0  # how much wider their errors are
ROUNDS = 30
TWO_SIDED, ONE_SIDED = 1.96, 1.645
LEAST_LEFT = 0.02  # of the compression, that the object must have had for a modulus
WELL_KNOWN = 0.3  # relative sd of a modulus
WEAK = 10.0  # sd of the log of a modulus of which nothing is known, and of the width in metres


@dataclass(frozen=True)
class FusedStiffness:
    """The stiffness of one object from repeated squeezes.

    Attributes:
        young_modulus, sd: [Pa]; NaN and infinite where all squeezes gave bounds.
        interval: of 95 % [Pa].
        bound: the largest of the bounds where there is nothing else [Pa], else None.
        width, width_sd: opening at contact [m].
        scatter: relative standard deviation between squeezes beyond what each one's readings explain.
        weights: probability of each squeeze to have gone right, (n,); 0 for bounds.
    """

    young_modulus: float
    sd: float
    interval: tuple[float, float]
    bound: float | None
    width: float
    width_sd: float
    scatter: float
    weights: Array

    def measurement(self) -> Measurement:
        """Return the measurement of elasticity.

        Raises:
            InvalidInput: if there is only a bound.
        """
        if self.bound is not None:
            raise InvalidInput("fused stiffness", f"a bound, E >= {self.bound:.3g} Pa", "a modulus")
        return Measurement("elasticity", self.young_modulus, self.sd, "Pa")


def fuse_stiffness(estimates: Sequence[StiffnessEstimate], *, same_width: bool = True) -> FusedStiffness:
    """Fuse the estimates of repeated squeezes of one object with one gripper.

    Minimises, over l = ln E and the width w, sum_i |(ln E_i, w_i) - (l + g, w)|^2 in each estimate's covariance,
    with the common log gain g ~ N(0, sd_gain^2). A squeeze that went wrong (it slipped, it met a finger) is
    weighed down by a mixture of a narrow and a wide Gaussian; scatter beyond the readings' own is estimated and
    added. Widths count only where every modulus is known well enough for its log to be Gaussian.

    Args:
        estimates: at least one; bounds count only if there is nothing else.
        same_width: whether the object was touched at the same place each time, so that its width is shared.

    Raises:
        InvalidInput: for no estimates.
    """
    if not estimates:
        raise InvalidInput("fused stiffness: estimates", "none", "at least one")
    valued = [e for e in estimates if e.bound is None]
    weights = np.zeros(len(estimates))
    if not valued:
        best = max(estimates, key=lambda e: e.bound or 0.0)
        bound = best.bound or 0.0
        return FusedStiffness(
            math.nan, math.inf, (bound, math.inf), bound, best.onset, best.onset_sd, 0.0, weights
        )
    read = np.array([[math.log(e.young_modulus), e.onset] for e in valued])
    noise = np.array([_covariance(e) for e in valued])
    same_width = same_width and all(e.reading_sd < WELL_KNOWN * e.young_modulus for e in valued)
    gain = max(
        math.sqrt(max((e.sd / e.young_modulus) ** 2 - (e.reading_sd / e.young_modulus) ** 2, 0.0)) for e in valued
    )
    # From the median on: a mean would take a squeeze that went wrong for scatter of all.
    mean = np.median(read, axis=0)
    scatter = _first_scatter(read, noise, mean)
    inlier = _inlier(read, noise, scatter, mean, same_width=False)
    mean, covariance = _solve(read, noise, inlier, scatter, gain, same_width)
    for _ in range(ROUNDS):
        before = scatter
        scatter = _scatter(read, noise, inlier, mean, same_width)
        inlier = _inlier(read, noise, scatter, mean, same_width)
        mean, covariance = _solve(read, noise, inlier, scatter, gain, same_width)
        if abs(scatter - before) < 1e-6:
            break
    relative = math.sqrt(covariance[0, 0])
    modulus = math.exp(mean[0])
    weights[[i for i, e in enumerate(estimates) if e.bound is None]] = inlier
    return FusedStiffness(
        young_modulus=modulus,
        sd=modulus * relative,
        interval=(modulus * math.exp(-TWO_SIDED * relative), modulus * math.exp(TWO_SIDED * relative)),
        bound=None,
        width=float(mean[1]),
        width_sd=math.sqrt(covariance[1, 1]),
        scatter=scatter,
        weights=weights,
    )


def without_gripper(
    fused: FusedStiffness, estimates: Sequence[StiffnessEstimate], stiffness: float, stiffness_sd: float
) -> FusedStiffness:
    """Take the give of gripper and pads off a fused stiffness.

    At the largest force F of the squeezes, the object is compressed by u = u_series - F / k, and
    E = F / (A h(u / L)). Fusing first keeps the scatter of single squeezes out of a correction that magnifies it.

    Args:
        fused: of estimates whose geometry has no series compliance.
        estimates: those estimates.
        stiffness, stiffness_sd: of gripper and pads [N/m].
    """
    valued = [e for e in estimates if e.bound is None]
    if not valued or fused.bound is not None:
        return fused
    geometry = valued[0].geometry
    force = float(np.median([e.stress(e.max_strain) for e in valued])) * geometry.area

    def object_alone(series: float, k: float) -> float:
        strains = np.linspace(0.0, 1.0, 20001)
        h = force / geometry.area / series
        total = float(np.interp(h, geometry.law_of(strains), strains)) * geometry.width
        left = total - force / k
        if left <= LEAST_LEFT * total:
            return math.inf
        return force / geometry.area / float(geometry.law_of(np.array([left / geometry.width]))[0])

    margin = min(TWO_SIDED * stiffness_sd, 0.95 * stiffness)
    modulus = object_alone(fused.young_modulus, stiffness)
    softer = (object_alone(fused.interval[0], stiffness), object_alone(fused.young_modulus, stiffness + margin))
    stiffer = (object_alone(fused.interval[1], stiffness), object_alone(fused.young_modulus, stiffness - margin))
    least = (fused.interval[0] / fused.young_modulus) ** (ONE_SIDED / TWO_SIDED)
    if math.isinf(modulus) or any(math.isinf(v) for v in stiffer):
        # One-sided: what the object must be if gripper and pads are as soft as they may not be.
        bound = object_alone(fused.young_modulus * least, stiffness + ONE_SIDED * stiffness_sd)
        bound = max(fused.young_modulus * least, bound if math.isfinite(bound) else 0.0)
        return dataclasses.replace(
            fused, young_modulus=math.nan, sd=math.inf, interval=(bound, math.inf), bound=bound
        )
    low = modulus * math.exp(-math.hypot(*(math.log(modulus / v) for v in softer)))
    high = modulus * math.exp(math.hypot(*(math.log(v / modulus) for v in stiffer)))
    sd = modulus * math.log(high / low) / (2 * TWO_SIDED)
    return dataclasses.replace(fused, young_modulus=modulus, sd=sd, interval=(low, high))


def calibrate_series_stiffness(rigid: Sequence[StressStrain], *, same_width: bool = True) -> tuple[float, float]:
    """Return the stiffness of gripper and pads and its standard deviation, from squeezes of a rigid block [N/m].

    A rigid block gives way by nothing, so the slope of force over opening is that of gripper and pads,
    F = k (opening at contact - opening). The standard deviation is that of a further squeeze: what differs between
    the squeezes of the block will differ in later ones.

    Args:
        rigid: the curves; their geometry does not matter.
        same_width: whether all are of the same block at the same place.

    Raises:
        InvalidInput: for no curves.
        NoContact: if one never rises.
    """
    if not rigid:
        raise InvalidInput("series stiffness: curves of a rigid block", "none", "at least one")
    estimates = []
    for curve in rigid:
        width = curve.geometry.width
        plain = Geometry("box", width, width)  # its modulus is the stiffness
        estimates.append(
            estimate_stiffness(
                stress_strain(curve.stress * curve.geometry.area, width * (1 - curve.strain), plain), max_degree=1
            )
        )
    fused = fuse_stiffness(estimates, same_width=same_width)
    if fused.bound is not None:
        raise InvalidInput(
            "series stiffness", f"a slope of at least {fused.bound:.3g} N/m", "curves that resolve it"
        )
    spread = math.hypot(fused.sd / fused.young_modulus, fused.scatter)
    return fused.young_modulus, fused.young_modulus * spread


def _covariance(estimate: StiffnessEstimate) -> Array:
    """Return the covariance of log modulus and opening at contact that the readings leave, (2, 2)."""
    c = estimate.fit.covariance
    log_sd = estimate.reading_sd / estimate.young_modulus
    onset_sd = max(estimate.onset_sd, 1e-6)
    full = math.sqrt(max(c[MODULUS, MODULUS] * c[ONSET, ONSET], 0.0))
    correlation = -c[MODULUS, ONSET] / full if full > 0 else 0.0  # the opening falls as the strain grows
    correlation = float(np.clip(correlation, -0.98, 0.98))
    return np.array([[log_sd**2, correlation * log_sd * onset_sd], [correlation * log_sd * onset_sd, onset_sd**2]])


def _with_scatter(noise: Array, scatter: float) -> Array:
    wider = noise.copy()
    wider[..., 0, 0] += scatter**2
    return wider


def _solve(
    read: Array, noise: Array, inlier: Array, scatter: float, gain: float, same_width: bool
) -> tuple[Array, Array]:
    """Return mean and covariance of log modulus and width, from the graph."""
    graph = LinearGraph()
    truth, common = key("x"), key("g")
    graph.add_prior(truth, [0.0, 0.0], [100 * WEAK, WEAK])
    graph.add_prior(common, [0.0], [max(gain, 1e-9)])
    for i, (z, c) in enumerate(zip(read, _with_scatter(noise, scatter), strict=True)):
        weight = math.sqrt(inlier[i] + (1 - inlier[i]) / ODD_SCALE**2)
        if same_width:
            white = np.linalg.inv(np.linalg.cholesky(c)) * weight
            blocks = {truth: white, common: white[:, :1]}
            graph.add(blocks, white @ z, np.ones(2))
        else:
            sd = np.array([math.sqrt(c[0, 0]), math.sqrt(c[1, 1]) + WEAK]) / weight
            graph.add({truth: np.eye(2), common: np.array([[1.0], [0.0]])}, z, sd)
    solution = graph.solve(truth)
    inverse = np.linalg.inv(solution.root)
    return solution[truth], inverse @ inverse.T


def _first_scatter(read: Array, noise: Array, mean: Array) -> float:
    """Return a first guess of the scatter, from the median of the residuals."""
    spread = 1.4826 * float(np.median(np.abs(read[:, 0] - mean[0])))
    return math.sqrt(max(spread**2 - float(np.median(noise[:, 0, 0])), 0.0))


def _scatter(read: Array, noise: Array, inlier: Array, mean: Array, same_width: bool) -> float:
    """Return the scatter of the log modulus with which the residuals are as large as they should be."""
    freedom = float(inlier.sum()) - 1
    if freedom <= 0.5:
        return 0.0
    given = _given_width(read, noise, mean) if same_width else (read[:, 0] - mean[0], noise[:, 0, 0])
    low, high = 0.0, 2.0
    if float(np.sum(inlier * given[0] ** 2 / given[1])) <= freedom:
        return 0.0
    for _ in range(50):
        middle = (low + high) / 2
        if float(np.sum(inlier * given[0] ** 2 / (given[1] + middle**2))) > freedom:
            low = middle
        else:
            high = middle
    return high


def _given_width(read: Array, noise: Array, mean: Array) -> tuple[Array, Array]:
    """Return the residual of the log modulus and its variance, given the shared width, (n,) each."""
    gain = noise[:, 0, 1] / noise[:, 1, 1]
    residual = read[:, 0] - mean[0] - gain * (read[:, 1] - mean[1])
    return residual, noise[:, 0, 0] - gain * noise[:, 0, 1]


def _inlier(read: Array, noise: Array, scatter: float, mean: Array, same_width: bool) -> Array:
    """Return each squeeze's probability to have gone right, (n,)."""
    if len(read) < 3:
        return np.ones(len(read))  # of two, none is the odd one
    c = _with_scatter(noise, scatter)
    offset = read - mean
    if same_width:
        distance = np.einsum("ni,nij,nj->n", offset, np.linalg.inv(c), offset)
        dimension = 2
    else:
        distance, dimension = offset[:, 0] ** 2 / c[:, 0, 0], 1
    odds = (
        math.log(ODD_RATE / (1 - ODD_RATE))
        - dimension * math.log(ODD_SCALE)
        + 0.5 * distance * (1 - 1 / ODD_SCALE**2)
    )
    probability: Array = 1 / (1 + np.exp(np.minimum(odds, 700.0)))
    return probability
