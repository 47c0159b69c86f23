"""How near stiffness comes to the smallest error there can be: Monte Carlo against the Cramer-Rao bound.

Every run squeezes a linear block as a 2F-85 would report it (opening and current in steps, noise, current spikes),
with the onset at an unknown place, and is estimated without being told the noise.

    ratio      root mean square error over the Cramer-Rao bound of the same readings with no spike among them
    coverage   of the 95 % interval
    onset_mm   root mean square error of the opening at contact

``python -m benchmarks.stiffness [--json] [--runs N]``
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from dynamics.compression import Geometry, StressStrain, stress_strain
from dynamics.gripper import robotiq_2f85
from estimation.stiffness import estimate_stiffness

Array = NDArray[np.float64]

WIDTH = 0.056  # m
MODULUS = 40e3  # Pa
READINGS = 90
START, DEPTH = 0.062, 0.20  # m; strain
FORCE_SD = 0.6  # N; 10 mA at 60 N/A
SPIKES = (1.0, 25.0)  # N; the smallest and largest spike
RATES = (0.0, 0.05, 0.10)
THESIS_WIDTH = 9  # readings of the moving mean that the thesis' filter is taken to be


def geometry() -> Geometry:
    return Geometry("box", WIDTH, robotiq_2f85().pad_area)


def make_curve(rng: np.random.Generator, rate: float, cubic: float = 0.0) -> tuple[StressStrain, float]:
    """Return a curve and the opening at which the block was touched [m]."""
    gripper, g = robotiq_2f85(), geometry()
    contact = WIDTH + rng.uniform(-0.001, 0.001)
    opening = np.linspace(START + rng.uniform(-0.001, 0.001), WIDTH * (1 - DEPTH), READINGS)
    strain = np.maximum((contact - opening) / WIDTH, 0.0)
    force = MODULUS * (strain + cubic * strain**3) * g.area + FORCE_SD * rng.standard_normal(READINGS)
    force += (rng.random(READINGS) < rate) * rng.uniform(*SPIKES, READINGS)
    step = gripper.effort_quantum * gripper.force_per_ampere
    force = np.round(force / step) * step
    opening = np.round(opening / gripper.opening_quantum) * gripper.opening_quantum
    return stress_strain(force, opening, g), contact


def bound(rate: float = 0.0) -> float:
    """Return the smallest standard deviation of the modulus, baseline and onset unknown too [Pa].

    The information of a reading is that of its noise's location: 1/sd^2 without spikes, else the integral of
    (d ln p / dx)^2 p over the density p of Gaussian noise with a share of uniform spikes added.
    """
    gripper, g = robotiq_2f85(), geometry()
    step = gripper.effort_quantum * gripper.force_per_ampere
    opening = np.linspace(START, WIDTH * (1 - DEPTH), READINGS)
    strain = (WIDTH - opening) / WIDTH
    touching = strain > 0
    jacobian = np.stack(
        [np.ones(READINGS), np.where(touching, -MODULUS, 0.0), np.where(touching, strain, 0.0)], axis=1
    )
    slope = MODULUS * g.area / WIDTH
    along = slope * gripper.opening_quantum / math.sqrt(12.0)
    sd = np.sqrt(FORCE_SD**2 + step**2 / 12 + np.where(touching, along, 0.0) ** 2)
    location = np.array([_location_information(s, rate) for s in sd])
    information = (jacobian.T * location * g.area**2) @ jacobian
    return float(np.sqrt(np.linalg.inv(information)[2, 2]))


def _location_information(sd: float, rate: float) -> float:
    if rate == 0.0:
        return 1 / sd**2
    x = np.linspace(-8 * sd, SPIKES[1] + 8 * sd, 20001)
    erf = np.vectorize(math.erf)
    upper, lower = (x - SPIKES[0]) / sd, (x - SPIKES[1]) / sd
    spike = 0.5 * (erf(upper / math.sqrt(2)) - erf(lower / math.sqrt(2))) / (SPIKES[1] - SPIKES[0])
    normal = np.exp(-0.5 * (x / sd) ** 2) / (sd * math.sqrt(2 * math.pi))
    density = (1 - rate) * normal + rate * spike
    slope = np.gradient(density, x)
    return float(np.trapezoid(slope**2 / np.maximum(density, 1e-300), x))


def in_contact(curve: StressStrain) -> tuple[Array, Array]:
    """Return strain and stress past the true onset and a margin: the baselines are told where contact is."""
    at = curve.strain > 0.03
    return curve.strain[at], curve.stress[at]


def ols(strain: Array, stress: Array) -> float:
    return float(np.polyfit(strain, stress, 1)[0])


def theil_sen(strain: Array, stress: Array) -> float:
    i, j = np.triu_indices(len(strain), 1)
    apart = strain[j] != strain[i]
    return float(np.median((stress[j] - stress[i])[apart] / (strain[j] - strain[i])[apart]))


def ransac(strain: Array, stress: Array) -> float:
    rng = np.random.default_rng(0)
    gate = 2.5 * FORCE_SD / geometry().area
    best = np.zeros(len(strain), dtype=np.bool_)
    for _ in range(100):
        i, j = rng.choice(len(strain), 2, replace=False)
        if strain[i] == strain[j]:
            continue
        slope = (stress[j] - stress[i]) / (strain[j] - strain[i])
        near = np.abs(stress - stress[i] - slope * (strain - strain[i])) < gate
        if near.sum() > best.sum():
            best = near
    return ols(strain[best], stress[best])


def filtered_ols(strain: Array, stress: Array) -> float:
    mean = np.convolve(stress, np.ones(THESIS_WIDTH) / THESIS_WIDTH, mode="valid")
    half = THESIS_WIDTH // 2
    return ols(strain[half : half + len(mean)], mean)


BASELINES: dict[str, Callable[[Array, Array], float]] = {
    "ols": ols,
    "theil_sen": theil_sen,
    "ransac": ransac,
    "filter_ols": filtered_ols,
}


def study(rate: float, runs: int, seed: int = 1) -> dict[str, float]:
    """Return ratio, coverage and the errors of one spike rate."""
    rng = np.random.default_rng(seed)
    smallest = bound()
    errors: dict[str, list[float]] = {name: [] for name in ("palpate", *BASELINES)}
    covered, onset, failed = 0, [], 0
    for _ in range(runs):
        curve, contact = make_curve(rng, rate)
        try:
            estimate = estimate_stiffness(curve)
        except Exception:
            failed += 1
            continue
        errors["palpate"].append(estimate.young_modulus - MODULUS)
        covered += estimate.interval[0] <= MODULUS <= estimate.interval[1]
        onset.append(estimate.onset - contact)
        strain, stress = in_contact(curve)
        for name, baseline in BASELINES.items():
            errors[name].append(baseline(strain, stress) - MODULUS)
    rms = {name: math.sqrt(float(np.mean(np.square(e)))) for name, e in errors.items()}
    return {
        "ratio": rms["palpate"] / smallest,
        "ratio_spiked_bound": rms["palpate"] / bound(rate),
        "coverage": covered / (runs - failed),
        "rmse_kpa": rms["palpate"] / 1e3,
        "bound_kpa": smallest / 1e3,
        "onset_mm": 1e3 * math.sqrt(float(np.mean(np.square(onset)))),
        "failed": failed,
        **{f"ratio_{name}": rms[name] / smallest for name in BASELINES},
    }


def cubic_study(rate: float, runs: int, seed: int = 2) -> dict[str, float]:
    """Return the error of the tangent modulus at 10 % strain of E (e + 6 e^3)."""
    rng = np.random.default_rng(seed)
    truth = MODULUS * (1 + 18 * 0.1**2)
    found = []
    for _ in range(runs):
        curve, _ = make_curve(rng, rate, cubic=6.0)
        found.append(estimate_stiffness(curve).tangent(0.1) / truth - 1)
    return {
        "tangent_bias": float(np.mean(found)),
        "tangent_rmse": math.sqrt(float(np.mean(np.square(found)))),
    }


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.stiffness", description=__doc__.splitlines()[0])
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--runs", type=int, default=800, help="Monte Carlo runs per spike rate")
    options = parser.parse_args(arguments)
    table = {f"{100 * rate:g}": study(rate, options.runs) for rate in RATES}
    cubic = cubic_study(0.05, min(options.runs, 300))
    if options.json:
        result = {key: {rate: row[key] for rate, row in table.items()} for key in ("ratio", "coverage")}
        print(json.dumps({"runs": options.runs, **result, "spikes": table, "cubic": cubic}))
        return 0
    names = list(next(iter(table.values())))
    print(f"{'':22}" + "".join(f"{rate + ' % spikes':>14}" for rate in table))
    for name in names:
        print(f"{name:22}" + "".join(f"{row[name]:14.3f}" for row in table.values()))
    for name, value in cubic.items():
        print(f"{name:22}{value:14.4f}   (cubic material, 10 % strain, 5 % spikes)")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
