"""The nearest body exists, keeps mass and centre, and is the estimate itself where that exists."""

import numpy as np
import pytest
from scipy.optimize import minimize

from dynamics.errors import InvalidInput
from dynamics.payload import inertia_parameters, is_physical
from estimation.payload.nearest_body import nearest_body

BODY = inertia_parameters(1.2, [0.02, -0.03, 0.1], np.diag([2e-3, 3e-3, 2.5e-3]))
SD = np.array([0.02, *[0.003] * 3, *[0.02] * 6])
WEIGHT = np.diag(SD[4:] ** -2.0)


def test_a_possible_body_stays():
    found = nearest_body(BODY, WEIGHT)
    np.testing.assert_allclose((found - BODY) / SD, 0, atol=0.01)  # the barrier's gap, 1e-4, is 0.01 sd


def test_an_impossible_one_becomes_possible_at_least_cost():
    """Against a search over Cholesky factors of the central second moments."""
    rng = np.random.default_rng(0)
    for _ in range(8):
        estimate = BODY + SD * rng.normal(size=10)
        found = nearest_body(estimate, WEIGHT)
        assert is_physical(found)
        np.testing.assert_allclose(found[:4], estimate[:4], rtol=1e-12)

        def cost(entries, estimate=estimate):
            factor = np.zeros((3, 3))
            factor[np.tril_indices(3)] = entries
            second = factor @ factor.T
            inertia = np.trace(second) * np.eye(3) - second
            body = inertia_parameters(estimate[0], estimate[1:4] / estimate[0], inertia)
            return float(np.sum(((body - estimate) / SD)[4:] ** 2))

        starts = [0.05 * np.array([1, 0, 1, 0, 0, 1]) + 0.03 * rng.normal(size=6) for _ in range(3)]
        least = min(minimize(cost, start, method="BFGS").fun for start in starts)
        assert np.sum(((found - estimate) / SD)[4:] ** 2) < least + 1e-3


def test_no_body_has_no_mass():
    with pytest.raises(InvalidInput, match="mass > 0"):
        nearest_body(-BODY, WEIGHT)
