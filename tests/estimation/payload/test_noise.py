"""Outlier probabilities by brute-force Bayes, and rounding errors by Monte Carlo."""

from itertools import product

import numpy as np
import pytest
from scipy.stats import norm

from dynamics.errors import InvalidInput
from estimation.payload.noise import (
    OUTLIER_SCALE,
    POSE_OUTLIER_SHARE,
    JointNoise,
    quantisation_variance,
    responsibilities,
)


def test_responsibilities_are_bayes_rule():
    """Enumerate every assignment of good and bad to the joints of a pose, and the bad pose."""
    rng, rate = np.random.default_rng(0), 0.07
    residual, sd = rng.normal(size=(5, 3)) * np.array([0.5, 2.0, 5.0]), np.array([0.4, 0.5, 0.3])
    found = responsibilities(residual, sd, rate)
    share = POSE_OUTLIER_SHARE * rate
    for row, reading, pose in zip(residual, found.reading, found.pose, strict=True):
        good_pose, good_reading = 0.0, np.zeros(3)
        for classes in product([True, False], repeat=3):
            density = 1 - share
            for r, s, good in zip(row, sd, classes, strict=True):
                density *= (1 - rate) * norm.pdf(r, 0, s) if good else rate * norm.pdf(r, 0, OUTLIER_SCALE * s)
            good_pose += density
            good_reading += density * np.array(classes)
        total = good_pose + share * np.prod(norm.pdf(row, 0, OUTLIER_SCALE * sd))
        assert pose == pytest.approx(good_pose / total, rel=1e-9)
        np.testing.assert_allclose(reading, good_reading / total, rtol=1e-9, atol=1e-300)


def test_without_outliers_every_reading_counts_fully():
    found = responsibilities(np.full((2, 3), 1e3), np.ones(3), 0.0)
    assert np.all(found.reading == 1)
    assert np.all(found.precision == 1)


def test_far_readings_stay_finite():
    found = responsibilities(np.array([[1e8, 0.0]]), np.ones(2), 0.05)
    assert np.all(np.isfinite(found.precision))
    assert found.reading[0, 0] == 0


@pytest.mark.parametrize("sd", [0.0, 0.01, 0.02, 0.03])
def test_rounding_of_a_mean_is_dithered_by_noise(sd):
    rng, quantum = np.random.default_rng(1), 0.1
    truth = rng.uniform(0, quantum, 4000)
    samples = np.round((truth[:, None] + rng.normal(size=(4000, 400)) * sd) / quantum) * quantum
    error = np.var(samples.mean(axis=1) - truth) - np.mean(samples.var(axis=1)) / 400
    assert quantisation_variance(quantum, sd) == pytest.approx(error, rel=0.15, abs=2e-6)


@pytest.mark.parametrize(
    "bad",
    [
        {"sd": 0.0},
        {"sd": -1.0},
        {"sd": np.nan},
        {"sd": [0.1, np.inf]},
        {"sd": 0.1, "drift": -1},
        {"sd": 0.1, "outlier_rate": 0.5},
        {"sd": 0.1, "outlier_rate": np.nan},
        {"sd": 0.1, "quantum": np.inf},
        {"sd": np.ones((2, 2))},
    ],
)
def test_bad_noise_is_refused(bad):
    with pytest.raises(InvalidInput):
        JointNoise(**bad)


def test_noise_of_another_arm_is_refused():
    with pytest.raises(InvalidInput, match="one number, or 7"):
        JointNoise(np.ones(6)).per_joint("sd", 7)
