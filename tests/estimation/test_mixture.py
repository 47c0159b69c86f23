"""Mixtures on both scales: moments, densities, quantiles and modes against dense grids."""

from __future__ import annotations

import numpy as np
import pytest

from dynamics.errors import InvalidInput
from estimation.mixture import Mixture

WEIGHTS, MEANS, SDS = np.array([0.5, 0.3, 0.2]), np.array([0.0, 1.0, 2.5]), np.array([0.4, 0.2, 0.5])
LINEAR, LOG = Mixture(WEIGHTS, MEANS, SDS), Mixture(WEIGHTS, MEANS, SDS, "log")


@pytest.mark.parametrize(("mixture", "low", "high"), [(LINEAR, -6.0, 9.0), (LOG, 1e-6, 400.0)])
def test_moments_and_masses(mixture: Mixture, low: float, high: float) -> None:
    x = np.linspace(low, high, 2_000_001)
    density = mixture.density(x)
    step = x[1] - x[0]
    assert density.sum() * step == pytest.approx(1, abs=1e-5)
    mean = (density * x).sum() * step
    assert mixture.mean == pytest.approx(mean, rel=1e-5)
    assert mixture.sd == pytest.approx(np.sqrt((density * (x - mean) ** 2).sum() * step), rel=1e-4)
    assert mixture.mode() == pytest.approx(x[np.argmax(density)], abs=2 * step)


@pytest.mark.parametrize("mixture", [LINEAR, LOG])
@pytest.mark.parametrize("probability", [1e-6, 0.05, 0.5, 0.95, 1 - 1e-6])
def test_quantiles_invert_the_cdf(mixture: Mixture, probability: float) -> None:
    assert float(mixture.cdf(mixture.quantile(probability))) == pytest.approx(probability, rel=1e-9)


def test_interval_holds_its_probability() -> None:
    low, high = LOG.interval(0.9)
    assert float(LOG.cdf(high) - LOG.cdf(low)) == pytest.approx(0.9, abs=1e-9)


def test_positive_quantities_are_never_negative() -> None:
    assert float(LOG.density(-1.0)) == 0
    assert float(LOG.cdf(0.0)) == 0
    assert LOG.quantile(1e-9) > 0


def test_many_components() -> None:
    count = 4096
    weights = np.full(count, 0.5 / (count - 1))
    weights[7] = 0.5
    mixture = Mixture(weights, np.arange(count, dtype=float), np.full(count, 0.3))
    assert mixture.mode() == pytest.approx(7.0, abs=1e-2)


def test_impossible_probability_is_refused() -> None:
    with pytest.raises(InvalidInput, match="probability"):
        LINEAR.quantile(1.0)
