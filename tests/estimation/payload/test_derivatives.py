"""The smoother's derivatives against those of known motions."""

import numpy as np
import pytest

from dynamics.errors import InvalidInput
from estimation.payload.derivatives import smooth


def motion(time):
    return np.sin(2 * time), 2 * np.cos(2 * time), -4 * np.sin(2 * time)


@pytest.mark.parametrize("with_velocity", [False, True])
def test_derivatives_of_a_noisy_sine(with_velocity):
    rng = np.random.default_rng(0)
    time = np.cumsum(rng.uniform(0.008, 0.012, 600))  # clocks jitter
    q, dq, ddq = motion(time)
    read = q + 1e-3 * rng.normal(size=600)
    speed = (dq + 1e-2 * rng.normal(size=600))[:, None] if with_velocity else None
    found = smooth(time, read[:, None], speed)
    inner = slice(50, -50)
    assert np.std(found[0][inner, 0] - q[inner]) < 5e-4
    assert np.std(found[1][inner, 0] - dq[inner]) < 0.01  # raw differences: 0.14
    assert np.std(found[2][inner, 0] - ddq[inner]) < 0.15  # raw second differences: 24


def test_a_straight_line_has_no_acceleration():
    time = np.arange(0, 2, 0.01)
    _, dq, ddq = smooth(time, 0.3 * time[:, None])
    np.testing.assert_allclose(dq[20:-20], 0.3, atol=1e-4)
    np.testing.assert_allclose(ddq[20:-20], 0.0, atol=1e-2)


def test_bad_times_are_refused():
    with pytest.raises(InvalidInput, match="increas"):
        smooth(np.zeros(20), np.zeros((20, 1)))
    with pytest.raises(InvalidInput, match="at least 10"):
        smooth(np.arange(5.0), np.zeros((5, 1)))
