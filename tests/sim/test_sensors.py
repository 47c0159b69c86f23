"""The sensor model does what it declares, statistically. All tolerances are so many standard errors.

Of n independent normal draws of standard deviation s, the mean has the standard error s / sqrt(n) and the standard
deviation s / sqrt(2 n). With fixed seeds a test passes or fails for good; at 5 standard errors a right model fails
one seed in two million.
"""

import dataclasses

import numpy as np
import pytest
from scipy import stats

from sim.sensors import SensorModel, Sensors

NV = 7
LARGE, SMALL = slice(0, 4), slice(4, 7)
PERIOD = 0.01
SIGMAS = 5
RARE = stats.norm.sf(SIGMAS)  # probability beyond so many standard errors, on one side
Q = np.linspace(-1, 1, NV)
TAU = np.array([0.0, 20.0, 0.1, -15.0, 0.5, 3.0, -0.2])
NONE = SensorModel.none()


def only(**changed):
    """Return a model whose only errors are the given ones."""
    return dataclasses.replace(NONE, **changed)


def sensors(model, seed=0, period=PERIOD):
    return Sensors(model, np.random.default_rng(seed), NV, period)


def torques(model, count, seed=0, tau=TAU):
    """Return torque readings of a joint state that does not change, (count, NV)."""
    s = sensors(model, seed)
    return np.array([s.sample(0.0, Q, 0 * Q, tau, 0.08, None).tau for _ in range(count)])


def starts(model, count, tau=TAU):
    """Return the first torque readings of so many starts, (count, NV)."""
    return np.array([torques(model, 1, seed, tau)[0] for seed in range(count)])


def assert_normal(errors, sd):
    """Check mean and spread of independent errors, down the columns."""
    n = len(errors)
    assert np.all(np.abs(errors.mean(axis=0)) < SIGMAS * sd / np.sqrt(n))
    assert np.all(np.abs(errors.std(axis=0) / sd - 1) < SIGMAS / np.sqrt(2 * n))


def assert_variance(errors, sd):
    """Check the sum of squares of independent normal errors of mean 0 against its chi-square distribution."""
    scaled = np.asarray(errors) / sd
    probability = stats.chi2.cdf(float(np.sum(scaled**2)), scaled.size)
    assert RARE < probability < 1 - RARE


def test_the_checks_reject_what_is_wrong_by_a_little():
    n = 4000
    draws = np.random.default_rng(0).standard_normal((n, 1))
    assert_normal(draws, 1.0)
    assert_variance(draws, 1.0)
    # A tenth too wide, or off by a tenth, is several standard errors of 4000 draws: 1.1 % and 1.6 %.
    for wrong in (1.1 * draws, draws + 0.1):
        with pytest.raises(AssertionError):
            assert_normal(wrong, 1.0)
    with pytest.raises(AssertionError):
        assert_variance(1.1 * draws, 1.0)


def test_none_is_exact():
    s = sensors(NONE)
    rng = np.random.default_rng(1)
    for _ in range(100):
        q, dq, tau = rng.normal(size=(3, NV))
        opening, current = rng.uniform(0, 0.085), rng.uniform(0, 1)
        sample = s.sample(1.25, q, dq, tau, opening, current)
        assert (sample.time, sample.opening, sample.effort) == (1.25, opening, current)
        for found, true in ((sample.q, q), (sample.dq, dq), (sample.tau, tau)):
            np.testing.assert_array_equal(found, true)


def test_standing_current_says_nothing_of_force():
    model = only(holding_current=0.07)
    assert sensors(model).sample(0.0, Q, 0 * Q, TAU, 0.05, None).effort == 0.07
    assert sensors(NONE).sample(0.0, Q, 0 * Q, TAU, 0.05, None).effort == SensorModel().holding_current


def test_white_noise_of_torque():
    n = 4000
    errors = torques(only(torque_noise=(0.1, 0.04)), n) - TAU
    assert_normal(errors[:, LARGE], 0.1)
    assert_normal(errors[:, SMALL], 0.04)
    # White: neighbours in time, and joints, are uncorrelated; a correlation of nothing has the error 1/sqrt(n).
    scaled = errors / errors.std(axis=0)
    assert np.abs((scaled[1:] * scaled[:-1]).mean(axis=0)).max() < SIGMAS / np.sqrt(n)
    assert np.abs(np.corrcoef(scaled.T) - np.eye(NV)).max() < SIGMAS / np.sqrt(n)


def test_white_noise_is_gaussian_and_as_wide_as_declared():
    errors = torques(only(torque_noise=(0.1, 0.04)), 4000, seed=11) - TAU
    for joints, sd in ((LARGE, 0.1), (SMALL, 0.04)):
        assert_variance(errors[:, joints], sd)
        assert stats.kstest(errors[:, joints].ravel() / sd, "norm").pvalue > 2 * RARE


def test_noise_of_position_and_velocity():
    s = sensors(only(position_noise=1e-4, velocity_noise=2e-3))
    read = [s.sample(0.0, Q, Q, TAU, 0.08, None) for _ in range(4000)]
    assert_normal(np.array([r.q for r in read]) - Q, 1e-4)
    assert_normal(np.array([r.dq for r in read]) - Q, 2e-3)
    assert all(np.array_equal(r.tau, TAU) for r in read[:10])


def test_bias_is_drawn_once_a_start():
    model = only(torque_bias=(0.2, 0.1))
    assert np.ptp(torques(model, 50), axis=0).max() < 1e-12
    errors = starts(model, 1000) - TAU
    assert_normal(errors[:, LARGE], 0.2)
    assert_normal(errors[:, SMALL], 0.1)


def test_gain_is_a_share_of_the_torque_drawn_once_a_start():
    model = only(torque_gain=0.02)
    assert np.ptp(torques(model, 50), axis=0).max() < 1e-12
    loaded = TAU != 0
    found = starts(model, 1000)
    assert_normal((found / np.where(loaded, TAU, 1) - 1)[:, loaded], 0.02)
    assert np.all(found[:, ~loaded] == 0)
    # One gain a joint: twice the torque has twice the error.
    np.testing.assert_allclose(starts(model, 5, 2 * TAU), 2 * found[:5], rtol=1e-12)


@pytest.mark.parametrize("period", [0.02, 0.05])
def test_drift_is_a_random_walk(period):
    minute = round(60 / period)
    walks = []
    for seed in range(25):
        s = sensors(only(torque_drift=0.01), seed, period)
        walks.append([s.sample(0.0, Q, 0 * Q, TAU, 0.08, None).tau - TAU for _ in range(minute)])
    walk = np.array(walks).transpose(1, 0, 2).reshape(minute, -1)  # 25 starts of 7 joints
    # The sd after a time t in minutes is the drift times sqrt(t), whatever the sampling period.
    for share in (0.25, 1.0):
        assert_normal(walk[round(share * minute) - 1], 0.01 * np.sqrt(share))
    # Steps are independent of each other, (n - 1) x 175 of them.
    steps = np.diff(walk, axis=0) / (0.01 * np.sqrt(period / 60))
    assert_normal(steps.reshape(-1, 1), 1.0)
    n = steps[1:].size
    assert abs((steps[1:] * steps[:-1]).mean()) < SIGMAS / np.sqrt(n)


def test_drift_grows_with_the_square_root_of_time_at_every_lag():
    drift, period = 0.05, 0.02
    s = sensors(only(torque_drift=drift), 5, period)
    walk = np.array([s.sample(0.0, Q, 0 * Q, TAU, 0.08, None).tau for _ in range(8192)])
    for lag in (1, 4, 16, 64, 256):
        steps = np.diff(walk[::lag], axis=0)  # that do not overlap, so that they are independent
        assert_variance(steps, drift * np.sqrt(lag * period / 60))


def test_all_errors_together_add_up_at_a_start():
    """Independent errors add in squares: white noise, offset, gain and the first step of the drift."""
    model = SensorModel()
    errors = starts(model, 600) - TAU
    for joints, kind in ((LARGE, 0), (SMALL, 1)):
        variance = model.torque_noise[kind] ** 2 + model.torque_bias[kind] ** 2
        variance = variance + (model.torque_gain * TAU[joints]) ** 2 + model.torque_drift**2 * PERIOD / 60
        assert_variance(errors[:, joints], np.sqrt(variance))


def test_starts_are_independent_of_each_other():
    errors = starts(only(torque_bias=(1.0, 1.0)), 600)[:, 0] - TAU[0]
    assert abs(np.mean(errors[1:] * errors[:-1])) < SIGMAS / np.sqrt(len(errors) - 1)


def test_hysteresis_follows_the_last_direction_across_a_band():
    width, large, small = 0.02, 0.3, 0.1
    s = sensors(only(torque_hysteresis=(large, small), hysteresis_width=width))
    band = np.array([large] * 4 + [small] * 3)

    def offset_at(travel):
        return s.sample(0.0, Q + travel, 0 * Q, TAU, 0.08, None).tau - TAU

    np.testing.assert_array_equal(offset_at(0.0), 0)  # nothing has moved yet
    for travel in np.linspace(0, 0.1, 21):
        up = offset_at(travel)
    np.testing.assert_allclose(up, band)
    np.testing.assert_allclose(offset_at(0.1), band)  # standing still changes nothing
    # Reversed, it is in the middle after the width, and at the other end after twice that, in steps or at once.
    np.testing.assert_allclose(offset_at(0.1 - width / 2), band / 2)
    np.testing.assert_allclose(offset_at(0.1 - width), 0, atol=1e-12)
    np.testing.assert_allclose(offset_at(0.1 - 2 * width), -band)
    np.testing.assert_allclose(offset_at(0.0), -band)
    # The same place from the other side reads differently by the whole band.
    np.testing.assert_allclose(offset_at(0.1) - offset_at(0.1 - 5 * width), 2 * band)


def test_each_joint_has_its_own_direction():
    s = sensors(only(torque_hysteresis=(0.3, 0.3)))
    s.sample(0.0, Q, 0 * Q, TAU, 0.08, None)
    signs = np.array([1, -1, 0, 1, 0, -1, 1])
    read = s.sample(0.0, Q + 0.5 * signs, 0 * Q, TAU, 0.08, None).tau - TAU
    np.testing.assert_allclose(read, 0.3 * signs)


def test_quantisation():
    quantum, step = 0.085 / 227, 0.01
    s = sensors(only(opening_quantum=quantum, effort_quantum=step))
    rng = np.random.default_rng(2)
    openings, currents = rng.uniform(0, 0.085, 3000), rng.uniform(0, 1, 3000)
    read = [s.sample(0.0, Q, Q, TAU, o, c) for o, c in zip(openings, currents, strict=True)]
    for found, true, q in (
        (np.array([r.opening for r in read]), openings, quantum),
        (np.array([r.effort for r in read]), currents, step),
    ):
        np.testing.assert_allclose(found / q, np.round(found / q), atol=1e-9)
        error = found - true
        assert np.abs(error).max() <= q / 2 * (1 + 1e-9)
        # Uniform over a step: sd q/sqrt(12), whose kurtosis of 1.8 makes the error of the sd 0.45/sqrt(n).
        assert error.std() == pytest.approx(q / np.sqrt(12), rel=SIGMAS * 0.45 / np.sqrt(len(read)))


def test_noise_of_the_gripper_current():
    model = only(effort_noise=0.01, effort_proportional=0.05)
    for current in (0.0, 0.2, 1.0):
        s = sensors(model)
        errors = np.array([s.sample(0.0, Q, Q, TAU, 0.05, current).effort for _ in range(3000)]) - current
        assert_normal(errors, np.hypot(0.01, 0.05 * current))


def test_gain_of_the_gripper_current():
    model = only(effort_gain=0.05)
    first = [sensors(model, seed).sample(0.0, Q, Q, TAU, 0.05, 0.4).effort for seed in range(1000)]
    assert_normal(np.array(first) / 0.4 - 1, 0.05)
    s = sensors(model)
    ratios = [s.sample(0.0, Q, Q, TAU, 0.05, current).effort / current for current in (0.1, 0.4, 0.9)]
    np.testing.assert_allclose(ratios, ratios[0])
    assert s.sample(0.0, Q, Q, TAU, 0.05, None).effort == model.holding_current  # not a reading of force


def test_same_seed_same_readings():
    model = SensorModel()
    np.testing.assert_array_equal(torques(model, 20, seed=3), torques(model, 20, seed=3))
    assert np.all(torques(model, 1, seed=3) != torques(model, 1, seed=4))


def test_default_has_every_error():
    assert all(np.all(np.array(value) > 0) for value in dataclasses.astuple(SensorModel()))


def test_readings_do_not_share_memory_with_the_truth():
    q, tau = Q.copy(), TAU.copy()
    sample = sensors(NONE).sample(0.0, q, q, tau, 0.08, None)
    q[:], tau[:] = 9.0, 9.0
    assert np.array_equal(sample.q, Q)
    assert np.array_equal(sample.tau, TAU)
