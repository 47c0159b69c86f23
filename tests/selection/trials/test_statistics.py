"""Intervals and tests against published figures, other implementations and simulation."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import binomtest, fisher_exact

from selection.trials.statistics import calibration_error, fisher, mean_interval, wilson


@pytest.mark.parametrize(("successes", "trials"), [(0, 5), (5, 5), (8, 10), (396, 400), (1, 1)])
def test_wilson(successes: int, trials: int) -> None:
    expected = binomtest(successes, trials).proportion_ci(method="wilson")
    assert wilson(successes, trials) == pytest.approx((expected.low, expected.high), abs=1e-12)


def test_wilson_of_nothing_says_nothing() -> None:
    assert wilson(0, 0) == (0.0, 1.0)


@pytest.mark.parametrize(("first", "second"), [((0, 5), (400, 400)), ((4, 5), (390, 400)), ((2, 2), (10, 30))])
def test_fisher(first: tuple[int, int], second: tuple[int, int]) -> None:
    table = [[first[0], first[1] - first[0]], [second[0], second[1] - second[0]]]
    assert fisher(first, second) == pytest.approx(fisher_exact(table).pvalue, rel=1e-9)


def test_mean_interval_covers() -> None:
    rng = np.random.default_rng(1)
    covered = 0
    for _ in range(400):
        _, low, high = mean_interval(rng.normal(2.0, 3.0, 50))
        covered += low <= 2.0 <= high
    assert 0.92 <= covered / 400 <= 0.98


def test_calibration_error_of_true_and_of_boasting_probabilities() -> None:
    rng = np.random.default_rng(2)
    top = rng.uniform(0.5, 1.0, 20_000)
    right = rng.random(20_000) < top
    honest, low, high = calibration_error(top, right)
    assert honest < 0.02
    assert low <= honest <= high
    assert calibration_error(np.full(1000, 0.9), rng.random(1000) < 0.7)[0] == pytest.approx(0.2, abs=0.05)
