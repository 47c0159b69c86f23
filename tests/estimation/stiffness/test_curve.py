import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dynamics.compression import Geometry, StressStrain, stress_strain
from dynamics.errors import InvalidInput
from estimation.stiffness import CurveNoise, NoContact, TooLittleCompression, estimate_stiffness
from estimation.stiffness.fit import predict

WIDTH, AREA = 0.056, 0.056**2
BLOCK = Geometry("box", WIDTH, AREA)
OPENING = np.linspace(0.062, 0.0476, 100)  # m; to 15 % strain


def curve_of(modulus, noise=0.0, spikes=0.0, geometry=BLOCK, cubic=0.0, seed=0, opening=OPENING, series=math.inf):
    rng = np.random.default_rng(seed)
    low, high = opening.copy(), np.full_like(opening, 0.08)  # of the pads' faces, held apart by the gripper's give
    for _ in range(60):
        pads = (low + high) / 2
        h = geometry.law_of((geometry.width - pads) / geometry.width)
        force = modulus * (h + cubic * h**3) * geometry.area
        wide = pads - force / series > opening
        low, high = np.where(wide, low, pads), np.where(wide, pads, high)
    force = force + noise * rng.standard_normal(len(opening))
    force = force + (rng.random(len(opening)) < spikes) * rng.uniform(5, 30, len(opening))
    return stress_strain(force, opening, geometry)


@given(st.floats(5e3, 1e6), st.sampled_from(["linear", "hertz", "line"]))
@settings(max_examples=9, deadline=None)
def test_without_noise_the_modulus_is_exact(modulus, law):
    geometry = dataclasses.replace(BLOCK, law=law)
    estimate = estimate_stiffness(curve_of(modulus, geometry=geometry))
    assert estimate.young_modulus == pytest.approx(modulus, rel=2e-3)
    assert estimate.onset == pytest.approx(WIDTH, abs=1e-4)
    assert estimate.bound is None


@given(st.floats(0.1, 10.0))
@settings(max_examples=4, deadline=None)
def test_modulus_scales_with_force(factor):
    curve = curve_of(4e4, noise=0.4, spikes=0.05)
    scaled = StressStrain(curve.strain, factor * curve.stress, curve.geometry)
    one, other = estimate_stiffness(curve), estimate_stiffness(scaled)
    assert other.young_modulus == pytest.approx(factor * one.young_modulus, rel=1e-3)
    assert other.sd == pytest.approx(factor * one.sd, rel=1e-2)


def test_where_the_object_stands_in_the_pads_does_not_matter():
    curve = curve_of(4e4, noise=0.4)
    moved = StressStrain(curve.strain + 0.01, curve.stress, curve.geometry)
    one, other = estimate_stiffness(curve), estimate_stiffness(moved)
    assert other.young_modulus == pytest.approx(one.young_modulus, rel=1e-3)
    assert other.onset == pytest.approx(one.onset - 0.01 * WIDTH, abs=2e-5)


def test_a_force_offset_does_not_matter():
    curve = curve_of(4e4, noise=0.4)
    lifted = StressStrain(curve.strain, curve.stress + 300.0, curve.geometry)
    assert estimate_stiffness(lifted).young_modulus == pytest.approx(
        estimate_stiffness(curve).young_modulus, rel=0.01
    )


def test_intervals_hold_the_truth_as_often_as_they_say():
    runs, held, wide = 60, 0, []
    for seed in range(runs):
        estimate = estimate_stiffness(curve_of(3e4, noise=0.5, spikes=0.1, seed=seed))
        held += estimate.interval[0] <= 3e4 <= estimate.interval[1]
        wide.append(estimate.sd / 3e4)
    assert held / runs == pytest.approx(0.95, abs=3.3 * math.sqrt(0.95 * 0.05 / runs))
    assert np.mean(wide) < 0.05


def test_spikes_cost_little_and_are_told():
    clean = [estimate_stiffness(curve_of(3e4, 0.5, 0.0, seed=s)).young_modulus for s in range(16)]
    spiked = [estimate_stiffness(curve_of(3e4, 0.5, 0.1, seed=s)) for s in range(16)]
    line = [
        np.polyfit(c.strain[55:], c.stress[55:], 1)[0]
        for c in (curve_of(3e4, 0.5, 0.1, seed=s) for s in range(16))
    ]
    error = np.std([e.young_modulus for e in spiked])
    assert error < 2.0 * np.std(clean)
    assert error < 0.4 * np.sqrt(np.mean((np.array(line) - 3e4) ** 2))
    assert np.mean([e.spike_rate for e in spiked]) == pytest.approx(0.1, abs=0.04)


def test_unloading_does_not_count():
    opening = np.concatenate([OPENING, OPENING[::-1]])
    loading = curve_of(4e4)
    stress = np.concatenate([loading.stress, 0.6 * loading.stress[::-1]])
    both = StressStrain(np.concatenate([loading.strain, loading.strain[::-1]]), stress, BLOCK)
    assert estimate_stiffness(both).young_modulus == pytest.approx(4e4, rel=0.01)
    assert len(opening) == len(both)


def test_every_modulus_comes_from_the_curve():
    estimate = estimate_stiffness(curve_of(4e4, cubic=6.0, noise=0.02))
    e = 0.1
    assert estimate.tangent(e) == pytest.approx(4e4 * (1 + 18 * e**2), rel=0.03)
    assert estimate.secant(e) == pytest.approx(4e4 * (1 + 6 * e**2), rel=0.03)
    a, b = 0.02, 0.12
    assert estimate.chord(a, b) == pytest.approx(4e4 * (1 + 6 * (b**3 - a**3) / (b - a)), rel=0.03)
    assert estimate.max_slope == pytest.approx(estimate.tangent(estimate.max_strain), rel=1e-6)
    step = 1e-5
    by_differences = (estimate.stress(e + step) - estimate.stress(e - step)) / (2 * step)
    assert estimate.tangent(e) == pytest.approx(by_differences, rel=1e-5)
    assert abs(estimate.tangent(e) / (4e4 * 1.18) - 1) < 4 * estimate.tangent_sd(e) / 4.7e4


def test_gripper_and_pads_are_taken_off():
    k = 20e3  # N/m; the block's own is 56 N/mm at 1 MPa
    series = dataclasses.replace(BLOCK, series_stiffness=k, series_stiffness_sd=0.05 * k)
    curve = curve_of(3e5, noise=0.3, series=k)
    blind = estimate_stiffness(curve)
    seeing = estimate_stiffness(StressStrain(curve.strain, curve.stress, series))
    apparent = 1 / (1 / 3e5 + AREA / (k * WIDTH))
    assert blind.young_modulus == pytest.approx(apparent, rel=0.02)
    assert seeing.interval[0] < 3e5 < seeing.interval[1]
    # d ln E = (k_object / k) d ln k: 16.8 / 20 of 5 %.
    assert seeing.sd / seeing.young_modulus == pytest.approx(16.8 / 20 * 0.05, rel=0.25)


@pytest.mark.parametrize("noise", [0.02, 1.0])
def test_beside_a_stiff_gripper_the_interval_is_that_of_the_readings(noise):
    """However narrow or wide it is: the profile likelihood of a line is a parabola."""
    series = dataclasses.replace(BLOCK, series_stiffness=1e9)
    found = []
    for seed in range(20):
        curve = curve_of(4e4, noise=noise, seed=seed)
        one, other = (
            estimate_stiffness(StressStrain(curve.strain, curve.stress, geometry), CurveNoise(noise / AREA))
            for geometry in (BLOCK, series)
        )
        assert other.young_modulus == pytest.approx(one.young_modulus, abs=0.1 * one.sd)
        assert other.reading_sd == pytest.approx(one.reading_sd, rel=0.3)
        found.append(other)
    pulls = [(e.young_modulus - 4e4) / e.sd for e in found]
    assert abs(np.mean(pulls)) < 3 / math.sqrt(len(pulls))
    assert 0.5 < np.std(pulls) < 1.5  # three standard errors of a deviation from 20


@pytest.mark.parametrize(("cubic", "straight"), [(0.1, True), (6.0, False)])
def test_a_curve_that_a_line_follows_to_a_hundredth_is_a_line(cubic, straight):
    # However sure the readings are of it: E (h + 0.1 h^3) is 0.2 % off a line at 15 % strain, E (h + 6 h^3) 14 %.
    estimate = estimate_stiffness(curve_of(4e4, noise=0.01, cubic=cubic))
    assert bool(np.all(estimate.fit.parameters[5:] == 0)) == straight
    assert estimate.young_modulus == pytest.approx(4e4, rel=0.02)


def test_what_gives_less_than_the_gripper_is_a_bound():
    k = 5e3
    series = dataclasses.replace(BLOCK, series_stiffness=k, series_stiffness_sd=0.15 * k)
    opening = np.linspace(0.060, 0.047, 60)
    for seed in range(2):
        curve = curve_of(1e8, noise=0.3, series=k, opening=opening, seed=seed)
        estimate = estimate_stiffness(StressStrain(curve.strain, curve.stress, series))
        assert estimate.bound is not None
        assert math.isnan(estimate.young_modulus)
        assert estimate.interval == (estimate.bound, math.inf)
        assert k * WIDTH / AREA * 0.9 < estimate.bound < 1e8  # at least what all three give together


def test_few_steps_of_the_opening_give_no_modulus():
    quantum = 0.085 / 227
    opening = np.round(np.linspace(0.058, 0.0545, 80) / quantum) * quantum
    curve = stress_strain(np.maximum(0.056 - np.linspace(0.058, 0.0545, 80), 0) * 5.6e4, opening, BLOCK)
    with pytest.raises(TooLittleCompression, match=r"steps of the opening.*at least 10") as raised:
        estimate_stiffness(curve)
    bound = raised.value.estimate.bound
    assert bound is not None
    assert 0.3e6 < bound < 1e6


def test_air_is_not_an_object():
    refused = 0
    for seed in range(30):
        rng = np.random.default_rng(seed)
        force = 0.6 * rng.standard_normal(90) + (rng.random(90) < 0.05) * rng.uniform(2, 20, 90)
        try:
            estimate_stiffness(stress_strain(force, np.linspace(0.08, 0.04, 90), BLOCK))
        except NoContact:
            refused += 1
    assert refused >= 28  # a slope of five of its standard deviations, over many onsets


def test_readings_that_never_change_are_no_contact():
    with pytest.raises(NoContact):
        estimate_stiffness(stress_strain(np.zeros(30), np.linspace(0.06, 0.05, 30), BLOCK))


def test_an_opening_that_never_changes_is_no_contact():
    with pytest.raises(NoContact, match="opening"):
        estimate_stiffness(stress_strain(np.linspace(0, 9, 30), np.full(30, 0.05), BLOCK))


@pytest.mark.parametrize("at", [0, 30, 70, 99])
def test_one_huge_spike_among_clean_readings_changes_nothing(at):
    curve = curve_of(5e4)
    stress = curve.stress.copy()
    stress[at] += 60e3
    estimate = estimate_stiffness(StressStrain(curve.strain, stress, BLOCK))
    assert estimate.young_modulus == pytest.approx(5e4, rel=1e-3)


def test_contact_wider_than_the_object_is_refused():
    curve = curve_of(5e4, noise=0.2)
    narrow = dataclasses.replace(BLOCK, width=0.040)
    with pytest.raises(InvalidInput, match=r"about the object's width, 0\.04"):
        estimate_stiffness(stress_strain(curve.stress * AREA, WIDTH * (1 - curve.strain), narrow))


def test_too_few_readings_are_refused():
    with pytest.raises(InvalidInput, match="at least 7"):
        estimate_stiffness(stress_strain(np.arange(5.0), np.linspace(0.06, 0.05, 5), BLOCK))


@pytest.mark.parametrize(
    "change", [{"stress_sd": 0.0}, {"stress_sd": math.nan}, {"baseline_sd": 0.0}, {"gain_sd": -0.1}]
)
def test_noise_that_cannot_be_is_refused(change):
    with pytest.raises(InvalidInput, match=next(iter(change))):
        CurveNoise(**({"stress_sd": 100.0} | change))


def test_calibration_widens_the_interval_and_nothing_else():
    curve = curve_of(4e4, noise=0.4)
    noise = CurveNoise(0.4 / AREA)
    one, other = (
        estimate_stiffness(curve, noise),
        estimate_stiffness(curve, dataclasses.replace(noise, gain_sd=0.1)),
    )
    assert other.young_modulus == pytest.approx(one.young_modulus)
    assert other.reading_sd == pytest.approx(one.reading_sd)
    assert other.sd == pytest.approx(math.hypot(one.sd, 0.1 * one.young_modulus))


def test_what_friction_swallows_moves_the_onset():
    swallowed = 0.5
    plain = curve_of(1e4, noise=0.02)
    dead = StressStrain(plain.strain, np.maximum(plain.stress - swallowed / AREA, 0.0), BLOCK)
    noise = CurveNoise(0.02 / AREA, deadband=swallowed / AREA, deadband_sd=0.05 / AREA)
    blind, seeing = estimate_stiffness(dead), estimate_stiffness(dead, noise)
    late = swallowed / (1e4 * AREA / WIDTH)
    assert blind.onset == pytest.approx(WIDTH - late, abs=2e-4)
    assert seeing.onset == pytest.approx(WIDTH, abs=2e-4)
    assert seeing.onset_sd == pytest.approx(late * 0.1, rel=0.3)


@pytest.mark.parametrize("law", ["linear", "hertz", "line"])
def test_derivatives_of_the_curve_are_right(law):
    geometry = dataclasses.replace(BLOCK, law=law)
    x = np.array([50.0, 0.02, 4e4, 120.0, 2e-7, 1.5, 4.0])
    strain = np.linspace(0.08, 0.25, 30)
    _, jacobian = predict(x, strain, geometry)
    for k in range(len(x)):
        step = np.zeros(len(x))
        step[k] = 1e-5 * max(abs(x[k]), 1e-3 if k != 4 else 1e-8)
        up, down = predict(x + step, strain, geometry)[0], predict(x - step, strain, geometry)[0]
        column = (up - down) / (2 * step[k])
        np.testing.assert_allclose(jacobian[:, k], column, rtol=0.05, atol=0.02 * np.max(np.abs(column)))


def test_an_opening_that_is_renewed_late_is_fitted_by_its_renewals():
    rng = np.random.default_rng(5)
    found = []
    for _ in range(10):
        true = np.linspace(0.060, 0.040, 80)
        force = 6e4 * np.maximum((WIDTH - true) / WIDTH, 0) * AREA + 0.05 * rng.standard_normal(80)
        held, last = true.copy(), true[0]
        for i in range(80):
            if rng.random() < 0.25:
                last = true[i] + rng.normal(0, 2e-4)
            held[i] = last
        estimate = estimate_stiffness(stress_strain(force, held, BLOCK))
        found.append((estimate.young_modulus / 6e4 - 1, estimate.interval[0] < 6e4 < estimate.interval[1]))
    error, covered = np.array(found).T
    assert abs(np.mean(error)) < 0.04
    assert covered.mean() >= 0.7  # of ten at 0.95: fewer than 7 once in 30 000
