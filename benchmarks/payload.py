"""How close payload estimates come to the statistical limit: ``python -m benchmarks.payload --json``.

Synthetic readings of a Gen3 with gripper at 8 poses without and 8 with a payload; noise 0.4 N m (joints 1-4) and
0.15 N m (5-7), bias uniform within 0.5 and 0.2 N m, torque in steps of 0.05 N m. ``ratio`` is the root mean square
error of the mass over the Cramer-Rao bound of the same noise, ``coverage`` the share of runs whose 95 % interval
holds the truth. Every estimate goes through the public function and the factor graph.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from dynamics.arm import Arm
from dynamics.signals import JointReadings, Phase, Sample
from estimation.payload import JointNoise, estimate_payload
from estimation.payload.batch import design_matrix, estimate_batch
from estimation.payload.poses import plan_poses
from estimation.weighing import measure_weighing

Array = NDArray[np.float64]
Maker = Callable[[np.random.Generator], tuple[Arm, Array]]

SD = np.array([0.4] * 4 + [0.15] * 3)  # N m
BIAS = np.array([0.5] * 4 + [0.2] * 3)  # N m
QUANTUM, OUTLIER_RATE, OUTLIER_SD, DRIFT, MODEL_ERROR = 0.05, 0.05, 6.0, 0.3, 0.05
MASS, CENTER = 0.8, np.array([0.01, -0.02, 0.04])
PAYLOAD = np.concatenate([[MASS], MASS * CENTER])


@dataclass(frozen=True)
class Case:
    """Poses, and what the readings would be without noise."""

    arm: Arm
    poses: Array
    matrix: Array
    clean: Array  # (16, 7) measured torque less the arm's own

    @property
    def own(self) -> Array:
        return np.array([self.arm.gravity(q) for q in self.poses])


def make_case(seed: int = 3, count: int = 8) -> Case:
    arm = Arm.gen3()
    rng = np.random.default_rng(seed)
    poses: list[Array] = []
    while len(poses) < count:
        q = rng.uniform(-np.pi / 2, np.pi / 2, arm.nv)
        if arm.within_limits(q):
            poses.append(q)
    stacked = np.array(poses)
    matrix = design_matrix(arm, stacked, stacked)
    clean = (matrix[:, :4] @ PAYLOAD).reshape(2 * count, arm.nv)
    return Case(arm, stacked, matrix, clean)


def draw(case: Case, rng: np.random.Generator, outliers: bool = False, drift: float = 0.0) -> Array:
    """Return noisy readings, (16, 7)."""
    noise = rng.normal(size=case.clean.shape) * SD
    if outliers:
        hit = rng.random(case.clean.shape) < OUTLIER_RATE
        noise = np.where(hit, rng.normal(size=case.clean.shape) * OUTLIER_SD, noise)
    bias = rng.uniform(-BIAS, BIAS) + np.cumsum(drift * rng.normal(size=case.clean.shape), axis=0)
    return np.round((case.clean + noise + bias) / QUANTUM) * QUANTUM


def bound(case: Case, outliers: bool) -> float:
    """Cramer-Rao bound of the mass: Fisher information of the readings' density, by quadrature."""
    information = []
    for sd in SD:
        sd = float(np.hypot(sd, QUANTUM / np.sqrt(12)))
        x = (
            np.linspace(-12 * OUTLIER_SD, 12 * OUTLIER_SD, 200_001)
            if outliers
            else np.linspace(-12, 12, 100_001) * sd
        )
        good = np.exp(-0.5 * (x / sd) ** 2) / sd
        bad = np.exp(-0.5 * (x / OUTLIER_SD) ** 2) / OUTLIER_SD
        share = OUTLIER_RATE if outliers else 0.0
        density = ((1 - share) * good + share * bad) / np.sqrt(2 * np.pi)
        slope = -((1 - share) * good * x / sd**2 + share * bad * x / OUTLIER_SD**2) / np.sqrt(2 * np.pi)
        information.append(np.trapezoid(slope**2 / np.maximum(density, 1e-300), x))
    weight = np.tile(information, 2 * len(case.poses))
    return float(np.sqrt(np.linalg.inv((case.matrix.T * weight) @ case.matrix)[0, 0]))


def drift_bound(case: Case) -> float:
    """Least possible sd of the mass where the bias walks: generalised least squares of the whole series."""
    count = 2 * len(case.poses)
    walk = np.minimum.outer(np.arange(1, count + 1), np.arange(1, count + 1)) * DRIFT**2
    spread = np.zeros((count * 7, count * 7))
    for joint, sd in enumerate(SD):
        spread[joint::7, joint::7] = walk + np.eye(count) * (sd**2 + QUANTUM**2 / 12)
    return float(np.sqrt(np.linalg.inv(case.matrix.T @ np.linalg.solve(spread, case.matrix))[0, 0]))


def wrong_arm(arm: Arm, rng: np.random.Generator) -> Arm:
    """Return the arm with every link's mass and centre of mass wrong by MODEL_ERROR."""
    model = arm.model.copy()
    for joint in range(1, model.njoints):
        body = model.inertias[joint]
        scale = 1 + MODEL_ERROR * rng.normal(size=4)
        model.inertias[joint] = pin.Inertia(body.mass * scale[0], body.lever * scale[1:], body.inertia)
    return Arm(model, arm.tool_frame)


def run(case: Case, runs: int, noise: JointNoise, make: Maker, seed: int) -> tuple[Array, Array]:
    """Return errors of the mass and the sd that the estimate states, (runs,) each."""
    rng = np.random.default_rng(seed)
    own, half = case.own, len(case.poses)
    errors, sds = np.empty(runs), np.empty(runs)
    for k in range(runs):
        arm, readings = make(rng)
        tare = JointReadings(case.poses, own + readings[:half])
        load = JointReadings(case.poses, own + readings[half:])
        estimate = estimate_payload(arm, tare, load, noise)
        errors[k], sds[k] = estimate.mass - MASS, estimate.mass_sd
    return errors, sds


def summary(errors: Array, sds: Array, limit: float) -> dict[str, float]:
    rmse = float(np.sqrt(np.mean(errors**2)))
    return {
        "ratio": rmse / limit,
        "coverage": float(np.mean(np.abs(errors) < 1.96 * sds)),
        "rmse_g": 1e3 * rmse,
        "bound_g": 1e3 * limit,
    }


def baselines(case: Case, runs: int, outliers: bool, limit: float, seed: int) -> dict[str, dict[str, float]]:
    """Estimators that others use, on the same kind of readings."""
    rng = np.random.default_rng(seed)
    torque = np.array([draw(case, rng, outliers).ravel() for _ in range(runs)])
    matrix, sigma = case.matrix, np.tile(SD, 2 * len(case.poses))
    table: dict[str, dict[str, float]] = {}
    # one joint, one pose, centre of mass assumed in the tool frame's origin +- 2 cm: the thesis' Eq. 3.5
    half = len(case.poses) * 7
    lever = matrix[half:, 0].reshape(-1, 7)
    pose, joint = np.unravel_index(np.argmax(np.abs(lever) / SD), lever.shape)
    row = pose * 7 + joint
    assumed = matrix[half + row, 1:4] @ (CENTER + rng.normal(size=(runs, 3)) * 0.02).T
    table["single joint"] = summary(
        (torque[:, half + row] - torque[:, row]) / (lever[pose, joint] + assumed) - MASS,
        np.full(runs, np.sqrt(2) * sigma[row] / abs(lever[pose, joint])),
        limit,
    )
    for name, weight in (("OLS", np.ones_like(sigma)), ("WLS", sigma**-2)):
        covariance = np.linalg.inv((matrix.T * weight) @ matrix)
        values = torque @ (covariance @ (matrix.T * weight)).T
        residual = torque - values @ matrix.T
        scale = (
            np.sqrt((weight * residual**2).sum(axis=1) / (len(sigma) - matrix.shape[1])) if name == "OLS" else 1.0
        )
        sds = np.sqrt(covariance[0, 0]) * scale * np.ones(runs)
        table[name] = summary(values[:, 0] - MASS, sds, limit)
    values, residual = torque @ (covariance @ (matrix.T * weight)).T, residual
    for _ in range(30):  # Huber, by reweighting
        w = sigma**-2 / np.maximum(np.abs(residual) / sigma / 1.345, 1.0)
        information = np.einsum("ra,ai,aj->rij", w, matrix, matrix, optimize=True)
        values = np.linalg.solve(information, ((w * torque) @ matrix)[..., None])[..., 0]
        residual = torque - values @ matrix.T
    table["Huber"] = summary(values[:, 0] - MASS, np.sqrt(np.linalg.inv(information)[:, 0, 0]), limit)
    return table


def weighing(case: Case, runs: int, seed: int) -> dict[str, float]:
    """Holds as an exploration makes them, nothing known of the noise: 4 poses, tare before and after.

    A hold is 1.5 s at 100 Hz of AR(1) noise (0.7 a sample) with 0.3 and 0.1 N m, an error of its own of 0.06 and
    0.03 N m (stiction), gains 1 % and the arm's gravity 3 % wrong.
    """
    rng = np.random.default_rng(seed)
    poses, arm = case.poses[:4], case.arm
    own = np.array([arm.gravity(q) for q in poses])
    body = np.array([arm.payload_regressor(q) for q in poses]) @ PAYLOAD
    errors, sds = np.empty(runs), np.empty(runs)
    for k in range(runs):
        gain, bias = 1 + 0.01 * rng.normal(size=7), rng.uniform(-BIAS, BIAS)
        phases = []
        for step, (name, carried) in enumerate((("tare", 0.0), ("hold", 1.0), ("tare", 0.0))):
            for index, q in enumerate(poses):
                mean = gain * (1.03 * own[index] + carried * body[index]) + bias
                white = rng.normal(size=(180, 7)) * np.sqrt(1 - 0.7**2)
                for row in range(1, 180):
                    white[row] += 0.7 * white[row - 1]
                tau = mean + white[30:] * SD * 0.75 + rng.normal(size=7) * SD * 0.18
                start = 10.0 * (step * len(poses) + index)
                samples = (Sample(start + 0.01 * n, q, 0 * q, t, 0.05, 0.0) for n, t in enumerate(tau))
                phases.append(Phase("weigh", name, index, tuple(samples)))
        estimate, _ = measure_weighing(arm, phases)
        errors[k], sds[k] = estimate.mass - MASS, estimate.mass_sd
    return {
        "coverage": float(np.mean(np.abs(errors) < 1.96 * sds)),
        "rmse_g": 1e3 * float(np.sqrt(np.mean(errors**2))),
        "stated_sd_g": 1e3 * float(np.median(sds)),
    }


def planned_poses(arm: Arm) -> dict[str, dict[str, float]]:
    """What planned poses gain over random ones, and over the strongest joint alone at its best pose."""
    table = {}
    for drift in (0.0, DRIFT):
        noise = JointNoise(SD, quantum=QUANTUM, drift=drift)
        plan = plan_poses(arm, 8, noise, np.random.default_rng(0))
        table[f"drift {drift}"] = {
            "planned_sd_g": 1e3 * plan.mass_sd,
            "random_sd_g": 1e3 * plan.random_sd,
            "single_joint_sd_g": 1e3 * plan.single_sd,
            **{f"sd_g {order}": 1e3 * sd for order, sd in plan.sd_by_order.items()},
        }
    return table


def measure(runs: int, seed: int) -> dict[str, Any]:
    """Return every figure."""
    case, arm = make_case(), Arm.gen3()
    clean, dirty = bound(case, False), bound(case, True)
    noise = JointNoise(SD, quantum=QUANTUM)
    chain = JointNoise(SD, quantum=QUANTUM, drift=DRIFT)

    def readings(outliers: bool = False, drift: float = 0.0) -> Maker:
        return lambda rng: (arm, draw(case, rng, outliers, drift))

    return {
        "clean": summary(*run(case, runs, noise, readings(), seed), clean),
        "outliers": summary(*run(case, runs, noise, readings(outliers=True), seed + 1), dirty),
        "model_error": summary(
            *run(case, runs, noise, lambda rng: (wrong_arm(arm, rng), draw(case, rng)), seed + 2), clean
        ),
        "drift": summary(*run(case, runs, chain, readings(drift=DRIFT), seed + 3), drift_bound(case)),
        "drift_ignored": summary(*run(case, runs, noise, readings(drift=DRIFT), seed + 3), drift_bound(case)),
        "weighing": weighing(case, max(runs // 5, 1), seed + 6),
        "baselines": {
            "clean": baselines(case, runs, False, clean, seed + 4),
            "outliers": baselines(case, runs, True, dirty, seed + 5),
        },
        "poses": planned_poses(arm),
        **timing(case, noise),
    }


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.payload", description=__doc__)
    parser.add_argument("--json", action="store_true", help="print one JSON object and nothing else")
    parser.add_argument("--runs", type=int, default=2000, help="Monte Carlo runs of every row")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    result = measure(given.runs, given.seed)
    if given.json:
        sys.stdout.write(json.dumps(result, indent=2) + "\n")
        return
    sys.stdout.write(f"{'':28s} rmse/bound  coverage  rmse [g]\n")
    rows = {name: result[name] for name in ("clean", "outliers", "model_error", "drift", "drift_ignored")}
    for kind, table in result["baselines"].items():
        rows.update({f"{name}, {kind}": row for name, row in table.items()})
    for name, row in rows.items():
        sys.stdout.write(f"{name:28s} {row['ratio']:10.3f} {row['coverage']:9.3f} {row['rmse_g']:9.1f}\n")
    for name in ("weighing", "poses", "ms_per_estimate", "ms_per_estimate_batched"):
        sys.stdout.write(f"{name}: {json.dumps(result[name], indent=2)}\n")


def timing(case: Case, noise: JointNoise) -> dict[str, float]:
    """Milliseconds of processor time of one estimate by the graph, and of one within a batch."""
    rng = np.random.default_rng(0)
    own, half = case.own, len(case.poses)
    taken = []
    for _ in range(50):
        readings = draw(case, rng, outliers=True)
        tare, load = (JointReadings(case.poses, own + part) for part in (readings[:half], readings[half:]))
        start = time.process_time()
        estimate_payload(case.arm, tare, load, noise)
        taken.append(time.process_time() - start)
    torque = np.array([draw(case, rng, outliers=True).ravel() for _ in range(1000)])
    start = time.process_time()
    estimate_batch(case.matrix, torque, SD)
    return {
        "ms_per_estimate": 1e3 * float(np.median(taken)),
        "ms_per_estimate_batched": time.process_time() - start,
    }


if __name__ == "__main__":
    main()
