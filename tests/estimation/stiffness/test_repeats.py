import dataclasses
import math

import numpy as np
import pytest

from dynamics.compression import Geometry, stress_strain
from dynamics.errors import InvalidInput
from estimation.stiffness import CurveNoise, estimate_stiffness
from estimation.stiffness.repeats import calibrate_series_stiffness, fuse_stiffness

WIDTH, AREA = 0.056, 0.056**2
BLOCK = Geometry("box", WIDTH, AREA)


def repeat(seed, modulus=3e4, gain=1.0, gain_sd=0.0, noise=0.5):
    rng = np.random.default_rng(seed)
    opening = np.linspace(0.062, 0.0476, 100)
    force = gain * modulus * np.maximum((WIDTH - opening) / WIDTH, 0.0) * AREA + noise * rng.standard_normal(100)
    return estimate_stiffness(stress_strain(force, opening, BLOCK), CurveNoise(noise / AREA, gain_sd=gain_sd))


def test_fused_is_the_weighted_mean_of_the_logs():
    estimates = [repeat(seed) for seed in range(3)]
    fused = fuse_stiffness(estimates, same_width=False)
    logs = np.log([e.young_modulus for e in estimates])
    variance = np.array([(e.reading_sd / e.young_modulus) ** 2 for e in estimates]) + fused.scatter**2
    weight = (fused.weights + (1 - fused.weights) / 36) / variance
    assert math.log(fused.young_modulus) == pytest.approx(float(weight @ logs / weight.sum()), abs=1e-6)


def test_repeats_narrow_the_readings_but_not_the_calibration():
    estimates = [repeat(seed, gain_sd=0.1) for seed in range(6)]
    fused = fuse_stiffness(estimates)
    assert fused.sd / fused.young_modulus == pytest.approx(0.1, rel=0.05)
    without = fuse_stiffness([repeat(seed) for seed in range(6)])
    assert without.sd < 0.7 * min(repeat(seed).sd for seed in range(6))


def test_order_does_not_matter():
    estimates = [repeat(seed) for seed in range(4)]
    assert fuse_stiffness(estimates).young_modulus == pytest.approx(fuse_stiffness(estimates[::-1]).young_modulus)


def test_a_squeeze_that_went_wrong_is_weighed_down():
    estimates = [*(repeat(seed) for seed in range(4)), repeat(9, modulus=9e4)]
    fused = fuse_stiffness(estimates, same_width=False)
    assert fused.young_modulus == pytest.approx(3e4, rel=0.1)
    assert fused.weights[-1] < 0.1 < fused.weights[:-1].min()


def test_fused_intervals_hold_the_truth():
    runs, held = 25, 0
    for run in range(runs):
        fused = fuse_stiffness([repeat(100 * run + k) for k in range(3)])
        held += fused.interval[0] <= 3e4 <= fused.interval[1]
    assert held >= 20  # of 25 at 0.95: fewer once in 1000


def test_bounds_alone_give_a_bound():
    bound = dataclasses.replace(repeat(0), bound=2e5, young_modulus=math.nan, sd=math.inf)
    fused = fuse_stiffness([bound, dataclasses.replace(bound, bound=1e5)])
    assert fused.bound == 2e5
    assert fused.interval == (2e5, math.inf)
    with pytest.raises(InvalidInput, match="a bound"):
        fused.measurement()
    mixed = fuse_stiffness([bound, repeat(1)])
    assert mixed.bound is None
    assert mixed.weights.tolist() == [0.0, 1.0]


def test_nothing_to_fuse_is_refused():
    with pytest.raises(InvalidInput, match="at least one"):
        fuse_stiffness([])


def test_a_rigid_block_calibrates_gripper_and_pads():
    curves = []
    for seed in range(4):
        rng = np.random.default_rng(seed)
        opening = np.linspace(0.060, 0.0535, 80)
        force = 12e3 * np.maximum(0.056 - opening, 0.0) + 0.4 * rng.standard_normal(80)
        curves.append(stress_strain(force, opening, BLOCK))
    stiffness, sd = calibrate_series_stiffness(curves)
    assert abs(stiffness - 12e3) < 3 * sd
    assert sd < 0.05 * 12e3
