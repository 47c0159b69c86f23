"""Long-run covariances against the closed form of AR(1) series and against Monte Carlo."""

import numpy as np
import pytest
from scipy.signal import lfilter

from estimation.payload.autocorrelation import (
    bandwidth,
    block_bootstrap_covariance,
    independent_count,
    long_run_covariance,
)

COUNT = 2000


def series(rng, rho, count=COUNT):
    return lfilter([1.0], [1, -rho], rng.normal(size=(count + 300, 2)), axis=0)[300:]


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.9])
def test_covariance_of_a_sum_of_correlated_numbers(rho):
    rng = np.random.default_rng(0)
    truth = COUNT / (1 - rho) ** 2  # long-run variance of AR(1)
    hac, boot = [], []
    for _ in range(20):
        scores = series(rng, rho)
        hac.append(np.diag(long_run_covariance(scores)))
        length = max(2, int(np.ceil(bandwidth(scores))))
        boot.append(np.diag(block_bootstrap_covariance(scores, length, 300, rng)))
    # Bartlett's kernel is biased low by about (correlation time / reach): 10-15 % at rho = 0.9
    assert np.mean(hac) == pytest.approx(truth, rel=0.2)
    assert np.mean(boot) == pytest.approx(truth, rel=0.25)
    naive = COUNT / (1 - rho**2)
    assert rho < 0.4 or np.mean(hac) > 1.5 * naive


def test_lag_one_is_the_naive_covariance():
    scores = series(np.random.default_rng(1), 0.5)
    np.testing.assert_allclose(long_run_covariance(scores, lag=1.0), scores.T @ scores)


def test_covariance_is_positive_semidefinite_and_scales_with_units():
    rng = np.random.default_rng(2)
    scores = series(rng, 0.8, 200) @ rng.normal(size=(2, 2))
    assert np.linalg.eigvalsh(long_run_covariance(scores)).min() > 0
    units = np.array([1e3, 1e-3])
    scaled = long_run_covariance(scores * units)
    np.testing.assert_allclose(scaled, long_run_covariance(scores) * np.outer(units, units), rtol=1e-9)


def test_correlated_series_are_worth_less():
    rng = np.random.default_rng(3)
    assert independent_count(series(rng, 0.0)) == pytest.approx(2 * COUNT, rel=0.1)
    assert independent_count(series(rng, 0.9)) == pytest.approx(2 * COUNT * 0.1 / 1.9, rel=0.3)
