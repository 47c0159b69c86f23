"""Predictive densities of log-normal quantities against a dense grid."""

from __future__ import annotations

import numpy as np
import pytest

from selection.log_density import log_columns


@pytest.mark.parametrize(("sd", "relative"), [(6.0, 0.0), (0.5, 0.0), (1.0, 0.12), (0.0, 0.2), (5.0, 0.4)])
@pytest.mark.parametrize("variance", [1e-4, 0.05, 0.5, 3.0])
def test_predictive_density_of_log_properties(sd: float, relative: float, variance: float) -> None:
    mean = np.array([np.log(20.0), np.log(7.0)])
    z = np.concatenate([np.linspace(-15, 15, 7), np.geomspace(16, 400, 9)])
    found = log_columns(mean, np.array([variance, 0.3]), z, sd, relative)
    for u, own in enumerate((variance, 0.3)):
        t = mean[u] + np.sqrt(own) * np.linspace(-10, 10, 40_001)
        x = np.exp(t)
        noise = np.hypot(sd, relative * x)
        prior = np.exp(-0.5 * ((t - mean[u]) ** 2) / own) / np.sqrt(2 * np.pi * own) * (t[1] - t[0])
        for value, density in zip(z, found[:, u], strict=True):
            kernel = np.exp(-0.5 * ((value - x) / noise) ** 2) / (noise * np.sqrt(2 * np.pi))
            assert density == pytest.approx(float(prior @ kernel), rel=1e-4, abs=1e-8)
