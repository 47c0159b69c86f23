"""The nearest body exists, and is the estimate itself where that exists."""

import numpy as np
import pytest
from scipy.optimize import minimize

from dynamics.errors import InvalidInput
from dynamics.payload import from_log_cholesky, inertia_parameters, is_physical, to_log_cholesky
from estimation.nearest_body import nearest_body

BODY = inertia_parameters(1.2, [0.02, -0.03, 0.1], np.diag([2e-3, 3e-3, 2.5e-3]))
SD = np.array([0.02, *[0.003] * 3, *[0.02] * 6])


def test_a_possible_body_stays():
    found = nearest_body(BODY, np.diag(SD**-2.0))
    np.testing.assert_allclose((found - BODY) / SD, 0, atol=1e-4)


def test_an_impossible_one_becomes_possible_at_least_cost():
    rng = np.random.default_rng(0)
    for _ in range(5):
        estimate = BODY + SD * rng.normal(size=10)
        if is_physical(estimate):
            continue
        found = nearest_body(estimate, np.diag(SD**-2.0))
        assert is_physical(found)

        def cost(at, estimate=estimate):
            return float(np.sum(((from_log_cholesky(at) - estimate) / SD) ** 2))

        start = to_log_cholesky(inertia_parameters(1.2, estimate[1:4] / estimate[0], 5e-3 * np.eye(3)))
        other = min(
            minimize(cost, start + 0.3 * rng.normal(size=10), method="L-BFGS-B", bounds=[(-12, 3)] * 10).fun
            for _ in range(3)
        )
        assert cost(to_log_cholesky(found)) < other + 0.05


def test_no_body_has_no_mass():
    with pytest.raises(InvalidInput, match="mass > 0"):
        nearest_body(-BODY, np.eye(10))
