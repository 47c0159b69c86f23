import dataclasses
import math

import numpy as np
import pytest

from dynamics.compression import Geometry, StressStrain, stress_strain
from dynamics.errors import InvalidInput
from estimation.stiffness import estimate_stiffness
from estimation.stiffness.cycle import hysteresis, rate_dependence, separate

WIDTH, AREA = 0.056, 0.056**2
BLOCK = Geometry("box", WIDTH, AREA)


def cycle(returned, noise=0.0, spikes=0.0, seed=0):
    """A linear block that gives back a share of its work."""
    rng = np.random.default_rng(seed)
    down = np.linspace(0.058, 0.046, 120)
    opening = np.concatenate([down, down[::-1]])
    share = np.concatenate([np.ones(120), np.full(120, returned)])
    force = 5e4 * np.maximum((WIDTH - opening) / WIDTH, 0.0) * AREA * share + noise * rng.standard_normal(240)
    force = force + (rng.random(240) < spikes) * 15.0
    return stress_strain(force, opening, BLOCK)


def test_loading_and_unloading_are_told_apart():
    first, second = separate(cycle(0.7))
    assert abs(len(first) - 120) <= 2
    assert len(first) + len(second) == 240


@pytest.mark.parametrize("returned", [0.5, 0.9])
def test_loss_is_the_share_of_the_work_that_is_lost(returned):
    found = hysteresis(cycle(returned, noise=0.1))
    assert found.loss == pytest.approx(1 - returned, abs=0.02)
    reached = (WIDTH - 0.046) / WIDTH
    assert found.work == pytest.approx(5e4 * reached**2 / 2, rel=0.03)


def test_spikes_are_no_work():
    assert hysteresis(cycle(0.7, noise=0.1, spikes=0.05)).loss == pytest.approx(0.3, abs=0.04)


def test_a_cycle_needs_both_ways():
    one = cycle(0.7)
    with pytest.raises(InvalidInput, match="unloading"):
        hysteresis(StressStrain(one.strain[:120], one.stress[:120], BLOCK))


def test_an_opening_renewed_late_tells_no_loss():
    one = cycle(0.7)
    held = one.strain[(np.arange(240) // 6) * 6] + 1e-6 * np.random.default_rng(0).random(40)[np.arange(240) // 6]
    with pytest.raises(InvalidInput, match="renewed less often"):
        hysteresis(StressStrain(held, one.stress, BLOCK))


def at_rate(rate, seed, exponent=0.15):
    rng = np.random.default_rng(seed)
    opening = np.linspace(0.062, 0.0476, 100)
    force = 3e4 * rate**exponent * np.maximum((WIDTH - opening) / WIDTH, 0.0) * AREA
    return estimate_stiffness(stress_strain(force + 0.3 * rng.standard_normal(100), opening, BLOCK))


def test_rate_dependence_finds_the_exponent():
    rates = [0.1, 0.3, 1.0, 3.0]
    found = rate_dependence([at_rate(r, k) for k, r in enumerate(rates)], rates, reference=1.0)
    assert abs(found.exponent - 0.15) < 3 * found.exponent_sd
    assert found.significant
    assert abs(found.modulus - 3e4) < 3 * found.modulus_sd
    assert found.at(3.0) == pytest.approx(found.modulus * 3.0**found.exponent)


def test_a_material_that_does_not_care_has_no_exponent():
    rates = [0.1, 0.3, 1.0, 3.0]
    found = rate_dependence([at_rate(r, 10 + k, exponent=0.0) for k, r in enumerate(rates)], rates)
    assert abs(found.exponent) < 3 * found.exponent_sd


def test_one_rate_or_a_bound_is_refused():
    estimate = at_rate(1.0, 0)
    with pytest.raises(InvalidInput, match="two different"):
        rate_dependence([estimate, estimate], [1.0, 1.0])
    bound = dataclasses.replace(estimate, bound=1e5, young_modulus=math.nan)
    with pytest.raises(InvalidInput, match="moduli"):
        rate_dependence([estimate, bound], [1.0, 2.0])
