"""A hold's mean and standard error against Monte Carlo, with correlated noise and spikes."""

import numpy as np
import pytest
from scipy.signal import lfilter

from dynamics.errors import InvalidInput
from dynamics.signals import JointReadings
from estimation.payload.holds import reduce_holds

Q = np.array([0.3, -0.2])


def hold(tau, q=Q):
    return JointReadings(np.tile(q, (len(tau), 1)), tau)


def correlated(rng, count, rho, sd):
    white = rng.normal(size=(count + 200, 2))
    return sd * lfilter([np.sqrt(1 - rho**2)], [1, -rho], white, axis=0)[200:]


@pytest.mark.parametrize("rho", [0.0, 0.8])
def test_standard_error_knows_correlation(rho):
    rng = np.random.default_rng(0)
    means, errors = [], []
    for _ in range(60):
        reduced = reduce_holds([hold(correlated(rng, 400, rho, 0.3)) for _ in range(8)], "tare")
        means.append(reduced.tau)
        errors.append(reduced.error)
    actual = np.std(np.array(means))
    stated = np.sqrt(np.mean(np.square(errors)))
    # 960 means: their sd is known to 2.3 %; blocks of 40 samples miss (1 + rho) rho / (1 - rho)^2 / 40 at most
    assert stated == pytest.approx(actual, rel=0.15)
    assert (rho == 0) == (actual < 0.3 / np.sqrt(400) * 1.5)


def test_spikes_do_not_move_the_mean():
    rng = np.random.default_rng(1)
    tau = correlated(rng, 500, 0.0, 0.1) + 5.0
    spiked = tau.copy()
    spiked[::50] += 40.0
    clean, dirty = (reduce_holds([hold(t)], "load").tau[0] for t in (tau, spiked))
    np.testing.assert_allclose(
        dirty, clean, atol=0.02
    )  # 2 % of the samples, pulled in to 4 sd: 0.8 % of an sd of 1
    assert np.all(np.abs(spiked.mean(axis=0) - tau.mean(axis=0)) > 0.5)


def test_constant_readings_have_no_error():
    reduced = reduce_holds([hold(np.full((50, 2), 3.0))], "tare")
    np.testing.assert_array_equal(reduced.tau, [[3.0, 3.0]])
    np.testing.assert_array_equal(reduced.error, [[0.0, 0.0]])


def test_single_readings_stay_as_they_are():
    tau = np.arange(6.0).reshape(3, 2)
    reduced = reduce_holds(hold(tau), "tare")
    np.testing.assert_array_equal(reduced.tau, tau)
    assert np.all(reduced.count == 1)


def test_bad_holds_are_named():
    moving = JointReadings(np.linspace(0, 1, 20)[:, None] * np.ones(2), np.zeros((20, 2)))
    with pytest.raises(InvalidInput, match=r"load, hold 1.*moves by"):
        reduce_holds([hold(np.zeros((20, 2))), moving], "load")
    with pytest.raises(InvalidInput, match="no sample"):
        reduce_holds([hold(np.zeros((0, 2)))], "load")
    other = JointReadings(np.zeros((5, 3)), np.zeros((5, 3)))
    with pytest.raises(InvalidInput, match="hold 1: found '3 joints'"):
        reduce_holds([hold(np.zeros((20, 2))), other], "load")
