"""The payload estimate against numpy, against the truth of simulated readings, and against bad input."""

import numpy as np
import pytest

from dynamics.arm import Arm
from dynamics.errors import InvalidInput
from dynamics.signals import JointReadings
from estimation.payload import JointNoise, estimate_payload

SD = np.array([0.4] * 4 + [0.15] * 3)
MASS, CENTER = 0.8, np.array([0.02, -0.01, 0.05])
PAYLOAD = np.concatenate([[MASS], MASS * CENTER])


@pytest.fixture(scope="module")
def arm():
    return Arm.gen3()


@pytest.fixture(scope="module")
def poses():
    return np.random.default_rng(0).uniform(-1.5, 1.5, (8, 7))


def readings(arm, poses, payload, bias, rng, sd=SD):
    tau = np.array([arm.gravity(q) + arm.payload_regressor(q) @ payload for q in poses])
    return JointReadings(poses, tau + bias + rng.normal(size=tau.shape) * sd)


def test_without_outliers_equals_numpy(arm, poses):
    rng = np.random.default_rng(1)
    bias = rng.uniform(-0.5, 0.5, 7)
    tare, load = readings(arm, poses, 0 * PAYLOAD, bias, rng), readings(arm, poses, PAYLOAD, bias, rng)
    found = estimate_payload(arm, tare, load, JointNoise(SD, outlier_rate=0.0))
    body = np.array([arm.payload_regressor(q) for q in poses])
    own = np.array([arm.gravity(q) for q in poses])
    rows = np.block([[0 * body.reshape(56, 4), body.reshape(56, 4)], [body.reshape(56, 4)] * 2])
    rows = np.hstack([rows, np.tile(np.eye(7), (16, 1))]) / np.tile(SD, 16)[:, None]
    right = np.concatenate([(tare.tau - own).ravel(), (load.tau - own).ravel()]) / np.tile(SD, 16)
    weak = np.concatenate([np.full(8, 1 / 100.0), np.full(7, 1 / 100.0)])
    rows, right = np.vstack([rows, np.diag(weak)]), np.concatenate([right, np.zeros(15)])
    expected = np.linalg.lstsq(rows, right, rcond=None)[0]
    np.testing.assert_allclose(found.parameters, expected[:4], atol=1e-10)
    np.testing.assert_allclose(found.covariance, np.linalg.inv(rows.T @ rows)[:4, :4], atol=1e-10)


def test_reversed_sign_is_named_and_fixed(arm, poses):
    rng = np.random.default_rng(2)
    tare, load = readings(arm, poses, 0 * PAYLOAD, 0.3, rng), readings(arm, poses, PAYLOAD, 0.3, rng)
    straight = estimate_payload(arm, tare, load, JointNoise(SD))
    tare, load = JointReadings(poses, -tare.tau), JointReadings(poses, -load.tau)
    with pytest.raises(InvalidInput, match="torque_sign=-1"):
        estimate_payload(arm, tare, load, JointNoise(SD))
    assert estimate_payload(arm, tare, load, JointNoise(SD), torque_sign=-1).mass == pytest.approx(straight.mass)
