"""Calibrate drives and links from runs without a payload and, for the gains, with a known mass.

The model of :mod:`estimation.payload.drives` is bilinear in gains and the rest; Gauss-Newton on a factor graph
solves it, with a broad prior about the arm's description. Unloaded runs tell the model in amperes but not the
gains, for all of it scales together: a run with a known mass, or gains given, sets the scale. Without either
only the masses of the description do, and the stated uncertainty of the gains says so.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dynamics.arm import Arm
from dynamics.errors import InvalidInput
from estimation.graph import LinearGraph, key
from estimation.payload.autocorrelation import independent_count, long_run_covariance, small_sample_widening
from estimation.payload.drives import Drives
from estimation.payload.motion_rows import MotionRows
from estimation.payload.noise import responsibilities

Array = NDArray[np.float64]

LINK_SHARE = 0.5  # sd of a link's inertial parameters about the description's, as a share
LINK_LENGTH = 0.3  # m by which a link's mass may lie elsewhere than described
FRICTION_SD = 100.0  # N m, N m s/rad, kg m^2: harmlessly broad
KNOWN_MASS_SHARE = 1e-3  # sd of a reference mass, as a share
PAYLOAD_LENGTH = 1.0  # m from the tool within which a reference payload surely lies
FIRST_GAIN_SD = 1.0  # sd of the logarithm of a gain about what the description alone makes of it
TRUSTED = 3.0  # described torque over what it leaves unexplained, from which a joint's first gain counts
MOST_FITTED = 0.1  # share of the residuals' freedom that is left at least
OUTLIER_RATE = 0.02
ROUNDS = 30


@dataclass(frozen=True)
class _Run:
    rows: MotionRows
    mass: float  # kg; 0 for none

    def jacobian(self, state: _State) -> Array:
        """Return the derivative of the effort by [model, log inverse gain, payload (if any)], (T, nv, ...)."""
        k = state.k[None, :, None]
        gains = (state.k * self.torque(state))[:, :, None] * np.eye(len(state.k))
        parts = [k * self.rows.model, gains] + ([k * self.rows.payload] if self.mass else [])
        return np.concatenate(parts, axis=2)

    def torque(self, state: _State) -> Array:
        torque: Array = self.rows.model @ state.model
        return torque + self.rows.payload @ state.payload if self.mass else torque

    def residual(self, state: _State) -> Array:
        residual: Array = self.rows.effort - state.k * self.torque(state)
        return residual


@dataclass(frozen=True)
class _State:
    model: Array
    log_k: Array  # inverse gains are positive
    payload: Array  # of the reference runs, which carry the same body

    @property
    def k(self) -> Array:
        return np.exp(self.log_k)


@dataclass(frozen=True)
class _Prior:
    mean: _State
    model_sd: Array
    log_k_sd: Array
    payload_sd: Array


def calibrate_drives(
    arm: Arm,
    unloaded: Sequence[MotionRows],
    reference: Sequence[MotionRows] = (),
    mass: float | None = None,
    gain: ArrayLike | None = None,
    gain_share: float = 0.01,
) -> Drives:
    """Calibrate drives and links.

    Args:
        arm: its description gives the links' inertias a broad prior.
        unloaded: runs without a payload.
        reference: runs with one payload of known mass; its centre of mass need not be known.
        mass: that payload's [kg].
        gain: drive gains, if known otherwise [N m/A], (nv,); nan for a joint whose gain is not.
        gain_share: sd of known gains, and of the gains of torque sensors, as a share.

    Raises:
        InvalidInput: if there is no unloaded run, the runs differ in kind, or a number is out of range.
    """
    kinds = {rows.effort_kind for rows in (*unloaded, *reference)}
    if not unloaded or len(kinds) != 1:
        raise InvalidInput(
            "calibration: runs", f"{len(unloaded)} unloaded, of {sorted(kinds)}", ">= 1, all of a kind"
        )
    if bool(reference) != (mass is not None) or (mass is not None and not (np.isfinite(mass) and mass > 0)):
        raise InvalidInput("calibration: mass", mass, "a mass > 0 [kg] with reference runs, none without")
    if not gain_share > 0:
        raise InvalidInput("calibration: gain_share", gain_share, "a share > 0")
    runs = [_Run(rows, 0.0) for rows in unloaded] + [_Run(rows, mass or 0.0) for rows in reference]
    prior = _prior(arm, runs, kinds.pop(), mass or 0.0, gain, gain_share)
    state = prior.mean
    sigma = np.std(np.concatenate([run.rows.effort for run in runs]), axis=0) + 1e-12
    precision: list[Array] = [np.broadcast_to(sigma**-2, run.rows.effort.shape) for run in runs]
    for _ in range(ROUNDS):
        previous, state = state, _step(runs, state, prior, precision)
        residuals = [run.residual(state) for run in runs]
        belief = [responsibilities(residual, sigma, OUTLIER_RATE) for residual in residuals]
        good, all_residuals = np.concatenate([b.reading for b in belief]), np.concatenate(residuals)
        sigma = np.sqrt((good * all_residuals**2).sum(axis=0) / good.sum(axis=0)) + 1e-12
        precision = [responsibilities(residual, sigma, OUTLIER_RATE).precision for residual in residuals]
        if np.all(np.abs(state.log_k - previous.log_k) < 1e-6):
            break
    covariance = _covariance(runs, state, prior, precision)
    return Drives(arm.name, runs[0].rows.effort_kind, state.k, state.model, covariance, sigma / state.k)


def _step(runs: list[_Run], state: _State, prior: _Prior, precision: list[Array]) -> _State:
    """Take one Gauss-Newton step on the graph of increments."""
    graph = LinearGraph()
    model, gain, body = key("x"), key("k"), key("p")
    edges = np.cumsum([len(state.model), len(state.log_k)])
    for run, weight in zip(runs, precision, strict=True):
        rows = np.concatenate([run.jacobian(state), run.residual(state)[:, :, None]], axis=2)
        factor = _compressed(rows * np.sqrt(weight)[:, :, None])
        blocks = np.split(factor[:, :-1], edges, axis=1)
        graph.add(
            dict(zip((model, gain, body) if run.mass else (model, gain), blocks, strict=False)),
            factor[:, -1],
            np.ones(len(factor)),
        )
    graph.add_prior(model, prior.mean.model - state.model, prior.model_sd)
    graph.add_prior(gain, prior.mean.log_k - state.log_k, prior.log_k_sd)
    if any(run.mass for run in runs):
        graph.add_prior(body, prior.mean.payload - state.payload, prior.payload_sd)
    step = graph.solve(last=gain)
    payload = state.payload + step[body] if any(run.mass for run in runs) else state.payload
    return _State(state.model + step[model], state.log_k + np.clip(step[gain], -1, 1), payload)


def _compressed(rows: Array) -> Array:
    """Return as few rows as there are columns, that say the same: the triangle of a QR decomposition."""
    flat = rows.reshape(-1, rows.shape[2])
    return np.asarray(np.linalg.qr(flat, mode="r") if len(flat) > flat.shape[1] else flat, np.float64)


def _covariance(runs: list[_Run], state: _State, prior: _Prior, precision: list[Array]) -> Array:
    """Return the covariance of [model, inverse gain]: H^-1 (correlated scores + prior) H^-1."""
    size = len(state.model) + len(state.log_k)
    spread = np.concatenate([prior.model_sd, prior.log_k_sd, prior.payload_sd])
    known = np.diag(spread**-2)
    bread, meat, worth = known.copy(), np.zeros_like(known), 0.0
    for run, weight in zip(runs, precision, strict=True):
        jacobian = run.jacobian(state)
        used = jacobian.shape[2]
        flat = (jacobian * np.sqrt(weight)[:, :, None]).reshape(-1, used)
        bread[:used, :used] += flat.T @ flat
        residual = run.residual(state)
        scores = np.einsum("tjp,tj->tp", jacobian, weight * residual)
        scores -= scores.mean(axis=0)
        meat[:used, :used] += long_run_covariance(scores) * small_sample_widening(scores) ** 2
        worth += independent_count(np.sqrt(weight) * residual)
    inverse = np.linalg.inv(bread)
    fitted = float(np.trace(inverse @ (bread - known)))  # parameters that the runs, not the prior, have set
    meat *= worth / max(worth - fitted, MOST_FITTED * worth)  # residuals are smaller than errors by that
    meat += known
    by_log = np.concatenate([np.ones(len(state.model)), state.k])  # d k = k d log k
    return np.asarray((inverse @ meat @ inverse)[:size, :size] * np.outer(by_log, by_log))


def _prior(
    arm: Arm, runs: list[_Run], kind: str, mass: float, gain: ArrayLike | None, gain_share: float
) -> _Prior:
    """Return what is known before the runs: the description, broadly, and gains where given."""
    bodies = list(arm.model.inertias)[1:]
    links = np.concatenate([body.toDynamicParameters() for body in bodies])
    masses = np.array([body.mass for body in bodies])
    share = LINK_SHARE * np.maximum(masses, np.median(masses))  # what is mounted on small links is not small
    links_sd = np.concatenate([m * np.array([1.0, *[LINK_LENGTH] * 3, *[LINK_LENGTH**2] * 6]) for m in share])
    friction = np.zeros(4 * arm.nv)
    friction[3 * arm.nv :] = arm.model.armature
    model = np.concatenate([links, friction])
    model_sd = np.concatenate([links_sd, np.full(4 * arm.nv, FRICTION_SD)])
    payload = np.zeros(10)
    payload[0] = mass
    scale = max(mass, 1e-3)
    payload_sd = scale * np.array([KNOWN_MASS_SHARE, *[PAYLOAD_LENGTH] * 3, *[PAYLOAD_LENGTH**2] * 6])
    if kind == "torque":
        k, log_k_sd = np.ones(arm.nv), np.full(arm.nv, gain_share)
    else:
        k = _first_gains(runs, model)
        log_k_sd = np.full(arm.nv, FIRST_GAIN_SD)
    if gain is not None:
        given = np.asarray(gain, float)
        if given.shape != (arm.nv,) or np.any(given <= 0):
            raise InvalidInput("calibration: gain", given.tolist(), f"{arm.nv} numbers > 0, nan where unknown")
        known = np.isfinite(given)
        k = np.where(known, 1 / np.where(known, given, 1.0), k)
        log_k_sd = np.where(known, gain_share, log_k_sd)
    return _Prior(_State(model, np.log(k), payload), model_sd, log_k_sd, payload_sd)


def _first_gains(runs: list[_Run], model: Array) -> Array:
    """Return inverse gains from the description alone: effort on described torque and friction, joint by joint."""
    rows = [run.rows for run in runs if not run.mass]
    joints = rows[0].effort.shape[1]
    inverse, trust = np.empty(joints), np.empty(joints)
    for joint in range(joints):
        matrix = np.concatenate([r.model[:, joint] for r in rows])
        effort = np.concatenate([r.effort[:, joint] for r in rows])
        own = [10 * joints + kind * joints + joint for kind in range(3)]
        columns = np.column_stack([matrix[:, : 10 * joints] @ model[: 10 * joints], matrix[:, own]])
        values, *_ = np.linalg.lstsq(columns, effort, rcond=None)
        residual = effort - columns @ values
        inverse[joint] = values[0]
        trust[joint] = values[0] * np.std(columns[:, 0]) / (np.std(residual) + 1e-12)
    strongest = np.argsort(-np.abs(trust))[: min(3, joints)]
    middle = float(np.median(inverse[strongest]))
    if middle <= 0:
        found = "efforts that fall as the described torque rises"
        raise InvalidInput(
            "calibration: sign", found, "efforts along the joints' axes; set torque_sign in the map"
        )
    return np.where((trust > TRUSTED) & (inverse > 0), inverse, middle)
