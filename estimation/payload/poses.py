"""Which poses to weigh at, and in which order, so that the mass becomes known best.

With tare and load at the same poses only their differences tell the payload, and the information adds up over the
poses: J = sum_i B_i^T S^-1 B_i / 2. The poses that minimise the mass' entry of J^-1 are found by greedy choice and
exchange among many feasible candidates (Fedorov, Theory of Optimal Experiments, 1972). With a drifting bias the
order counts too, and the graph itself says what each order would give.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dynamics.arm import Arm
from dynamics.errors import InvalidInput
from estimation.payload.graph import design_readings, solve
from estimation.payload.holds import StaticReadings
from estimation.payload.noise import JointNoise, quantisation_variance

Array = NDArray[np.float64]
Step = tuple[Literal["tare", "load"], int]

CENTER_SD = 0.1  # m: what is thought of the centre of mass while too few poses are chosen to tell
EXCHANGES, SWAP_ROUNDS = 10, 3
TILT = 1e-3  # kg^-2: keeps the first greedy steps solvable


@dataclass(frozen=True)
class PosePlan:
    """Poses to weigh at.

    Attributes:
        poses: joint positions [rad], (N, nv).
        order: what to do in turn: tare or load, at which pose.
        mass_sd: standard deviation of the mass to be expected [kg].
        sd_by_order: the same for every order that was compared [kg].
        random_sd: the median of random feasible poses, in the same number and order [kg].
        single_sd: of the strongest joint alone at the best single pose, its centre of mass known [kg].
    """

    poses: Array
    order: tuple[Step, ...]
    mass_sd: float
    sd_by_order: dict[str, float]
    random_sd: float
    single_sd: float


def plan_poses(
    arm: Arm,
    count: int,
    noise: JointNoise,
    rng: np.random.Generator,
    *,
    max_mass: float = 1.0,
    candidates: int = 400,
    allowed: Callable[[Array], bool] | None = None,
) -> PosePlan:
    """Choose the poses of a weighing.

    Args:
        arm: gives limits of position and torque.
        count: number of poses, N; each is held once without and once with the payload.
        noise: of the torques; its sd must be given.
        rng: draws the candidates.
        max_mass: no pose may overload a joint with this mass at the tool [kg].
        candidates: number of feasible poses to choose from.
        allowed: further condition on a pose, such as freedom from collisions.

    Raises:
        InvalidInput: if hardly any pose is feasible, or the noise is not given.
    """
    if count < 1 or candidates < 2 * count:
        raise InvalidInput(
            "pose plan: count, candidates", (count, candidates), "count >= 1, candidates >= 2 count"
        )
    if noise.sd is None:
        raise InvalidInput("pose plan: noise", "sd None", "a given sd")
    pool = _candidates(arm, candidates, rng, max_mass, allowed)
    variance = noise.per_joint("sd", arm.nv) ** 2 + quantisation_variance(noise.per_joint("quantum", arm.nv), 0.0)
    body = np.array([arm.payload_regressor(q) for q in pool])
    information = np.einsum("nji,j,njk->nik", body, 0.5 / variance, body)
    chosen = _exchange(information, count)
    poses = pool[chosen]
    drifts = bool(np.any(noise.per_joint("drift", arm.nv) > 0))
    arranged = {
        name: _arranged(arm, poses, order, noise) if drifts else poses for name, order in _orders(count).items()
    }
    sds = {name: _expected_sd(arm, arranged[name], order, noise) for name, order in _orders(count).items()}
    best = min(sds, key=lambda name: round(sds[name], 6))  # of equals, the first
    drawn = [rng.choice(len(pool), count, replace=False) for _ in range(21)]
    random = [_expected_sd(arm, pool[i], _orders(count)[best], noise) for i in drawn]
    lever = np.abs(body[:, :, 0]) / np.sqrt(2 * variance)
    return PosePlan(
        arranged[best], _orders(count)[best], sds[best], sds, float(np.median(random)), float(1 / lever.max())
    )


def _candidates(
    arm: Arm, count: int, rng: np.random.Generator, max_mass: float, allowed: Callable[[Array], bool] | None
) -> Array:
    low = np.where(np.isfinite(arm.lower), arm.lower, -np.pi)
    high = np.where(np.isfinite(arm.upper), arm.upper, np.pi)
    found: list[Array] = []
    for _ in range(50 * count):
        q = rng.uniform(low, high)
        own, carried = arm.gravity(q), max_mass * arm.payload_regressor(q)[:, 0]
        strong = np.all(np.abs(own) <= arm.effort_limit) and np.all(np.abs(own + carried) <= arm.effort_limit)
        if strong and (allowed is None or allowed(q)):
            found.append(q)
            if len(found) == count:
                return np.array(found)
    raise InvalidInput(
        "pose plan", f"{len(found)} feasible poses in {50 * count}", f"{count}; relax the conditions"
    )


def _exchange(information: Array, count: int) -> NDArray[np.int_]:
    """Return the candidates that minimise the variance of the mass: greedy, then exchanged one by one."""
    start = np.diag([TILT, *[TILT / CENTER_SD**2] * 3])
    chosen: list[int] = []
    for _ in range(count):
        chosen.append(_best(start + information[chosen].sum(axis=0), information, chosen))
    for _ in range(EXCHANGES):
        before = list(chosen)
        for place in range(count):
            others = [c for i, c in enumerate(chosen) if i != place]
            chosen[place] = _best(start + information[others].sum(axis=0), information, others)
        if chosen == before:
            break
    return np.array(chosen)


def _best(so_far: Array, information: Array, taken: list[int]) -> int:
    """Return the candidate that helps most; no pose twice, for a bad one must not spoil all."""
    variance = _mass_variance(so_far + information)
    variance[taken] = np.inf
    return int(np.argmin(variance))


def _mass_variance(information: Array) -> Array:
    return np.asarray(np.linalg.inv(information)[..., 0, 0], np.float64)


def _orders(count: int) -> dict[str, tuple[Step, ...]]:
    """Return the orders to compare; each holds every pose once empty and once loaded."""
    tares: list[Step] = [("tare", i) for i in range(count)]
    loads: list[Step] = [("load", i) for i in range(count)]
    if count == 1:
        return {"tare, load": (*tares, *loads)}
    half = count // 2
    return {
        "tare, load": (*tares, *loads),
        "tare, load backwards": (*tares, *loads[::-1]),
        "tare, load, tare": (*tares[:half], *loads, *tares[half:]),
        "tare, load backwards, tare": (*tares[:half], *loads[:half][::-1], *loads[half:][::-1], *tares[half:]),
    }


def _arranged(arm: Arm, poses: Array, order: tuple[Step, ...], noise: JointNoise) -> Array:
    """Return the poses in the sequence that suffers least from drift: swapped two by two while it helps."""
    best, least = poses, _expected_sd(arm, poses, order, noise)
    for _ in range(SWAP_ROUNDS):
        before = least
        for i, j in combinations(range(len(poses)), 2):
            trial = best.copy()
            trial[[i, j]] = trial[[j, i]]
            sd = _expected_sd(arm, trial, order, noise)
            if sd < least:
                best, least = trial, sd
        if least == before:
            break
    return best


def _expected_sd(arm: Arm, poses: ArrayLike, order: tuple[Step, ...], noise: JointNoise) -> float:
    """Return the sd of the mass that the graph gives for an order."""
    where, joints = np.asarray(poses, float), arm.nv
    parts = []
    for kind in ("tare", "load"):
        at = [(time, index) for time, (name, index) in enumerate(order) if name == kind]
        none = np.zeros((len(at), joints))
        q = where[[index for _, index in at]]
        ones, time = np.ones(len(at), int), np.array([t for t, _ in at], float)
        parts.append(StaticReadings(q, none, none, none, ones, time))
    design = design_readings(arm, parts[0], parts[1], friction=False)
    sd = np.sqrt(
        noise.per_joint("sd", joints) ** 2 + quantisation_variance(noise.per_joint("quantum", joints), 0.0)
    )
    pose_sd = np.zeros(joints) if noise.pose_sd is None else noise.per_joint("pose_sd", joints)
    root = solve(design, np.tile(sd, (len(order), 1)), noise.per_joint("drift", joints), pose_sd).root
    return float(np.linalg.norm(np.linalg.inv(root)[0]))
