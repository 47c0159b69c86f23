"""Streamed readings give the batch's answer, whatever the order."""

import numpy as np
import pytest

from dynamics.arm import Arm
from dynamics.errors import InvalidInput
from dynamics.signals import JointReadings
from estimation.payload import JointNoise, estimate_payload
from estimation.payload.stream import PayloadStream

SD = np.array([0.4] * 4 + [0.15] * 3)
PAYLOAD = 0.8 * np.array([1.0, 0.01, -0.02, 0.05])


@pytest.fixture(scope="module")
def arm():
    return Arm.gen3()


def series(arm, rng, drift):
    """Return (kind, q, tau) in the order tare, load, tare, with drift and outliers."""
    poses, bias = rng.uniform(-1.5, 1.5, (8, 7)), rng.uniform(-0.3, 0.3, 7)
    steps = [("tare", q) for q in poses[:4]] + [("load", q) for q in poses] + [("tare", q) for q in poses[4:]]
    for kind, q in steps:
        bias = bias + drift * rng.normal(size=7)
        noise = np.where(rng.random(7) < 0.05, 6 * rng.normal(size=7), rng.normal(size=7) * SD)
        yield kind, q, arm.gravity(q) + arm.payload_regressor(q) @ PAYLOAD * (kind == "load") + bias + noise


@pytest.mark.parametrize("drift", [0.0, 0.1])
def test_stream_equals_batch_at_every_step(arm, drift):
    noise = JointNoise(SD, quantum=0.05, drift=drift)
    for seed in range(4):
        stream, seen = PayloadStream(arm, noise), []
        for row in series(arm, np.random.default_rng(seed), drift):
            stream.add(*row)
            seen.append((*row, float(len(seen))))
            if len(seen) < 6:
                continue
            parts = [
                JointReadings(*(np.array([r[i] for r in seen if r[0] == kind]) for i in (1, 2)), time=times)
                for kind in ("tare", "load")
                for times in [np.array([r[3] for r in seen if r[0] == kind])]
            ]
            batch, online = estimate_payload(arm, *parts, noise), stream.estimate()
            np.testing.assert_allclose(online.parameters, batch.parameters, atol=1e-6)
            np.testing.assert_allclose(online.covariance, batch.covariance, atol=1e-6)
            np.testing.assert_allclose(online.weights, batch.weights, atol=1e-4)


def test_weighing_stops_when_the_mass_is_known(arm):
    stream = PayloadStream(arm, JointNoise(SD))
    known = []
    for row in series(arm, np.random.default_rng(5), 0.0):
        stream.add(*row)
        known.append(stream.known_to(0.12))
    assert not known[3]
    assert known[-1]
    first = known.index(True)
    assert all(known[first:]) or known.count(True) > 0.8 * (len(known) - first)


def test_bad_streams_are_refused(arm):
    with pytest.raises(InvalidInput, match="given sd"):
        PayloadStream(arm, JointNoise())
    with pytest.raises(InvalidInput, match="pose_sd"):
        PayloadStream(arm, JointNoise(SD, pose_sd=1.0))
    stream = PayloadStream(arm, JointNoise(SD))
    with pytest.raises(InvalidInput, match="one of each"):
        stream.estimate()
    with pytest.raises(InvalidInput, match="tare, load"):
        stream.add("full", np.zeros(7), np.zeros(7))
    with pytest.raises(InvalidInput, match="degrees"):
        stream.add("tare", np.full(7, 90.0), np.zeros(7))
