"""A weighing's phases become a measurement of the mass that holds the truth."""

import numpy as np
import pytest

from dynamics.arm import Arm
from dynamics.errors import InvalidInput
from dynamics.signals import Phase, Sample
from estimation.weighing import measure_weighing

MASS = 0.35
PAYLOAD = MASS * np.array([1.0, 0.01, -0.02, 0.03])
POSES = np.array(
    [[0.3, 0.6, 0, 1.2, 0.2, 0.8, 0.5], [0.3, 0.9, 0.4, 1.5, -0.8, 0.6, 0], [0.0, 0.4, -0.5, 1.8, 0.9, -0.7, 1.0]]
)


@pytest.fixture(scope="module")
def arm():
    return Arm.gen3()


def phase(arm, name, index, start, rng, payload, gain, bias):
    """Return a hold of 1 s at 100 Hz, on an arm whose gravity differs by 3 % from the described one."""
    q = POSES[index]
    tau = gain * (1.03 * arm.gravity(q) + arm.payload_regressor(q) @ payload) + bias + 0.03 * rng.normal(size=7)
    noise = rng.normal(size=(100, 7)) * 0.2
    samples = tuple(Sample(start + 0.01 * k, q, 0 * q, tau + e, 0.05, 0.0) for k, e in enumerate(noise))
    return Phase("weigh", name, index, samples)


def weigh(arm, rng, payload=PAYLOAD):
    gain, bias = 1 + 0.01 * rng.normal(size=7), rng.uniform(-0.5, 0.5, 7)
    steps = [("tare", 0 * payload), ("hold", payload), ("tare", 0 * payload)]
    phases, start = [Phase("weigh", "approach", 0, ())], 0.0
    for name, carried in steps:
        for index in range(len(POSES)):
            phases.append(phase(arm, name, index, start, rng, carried, gain, bias))
            start += 5
    return phases


def test_mass_lies_in_its_interval(arm):
    rng = np.random.default_rng(0)
    errors, sds = [], []
    for _ in range(40):
        estimate, (measurement,) = measure_weighing(arm, weigh(arm, rng))
        assert (measurement.property, measurement.unit) == ("mass", "kg")
        assert (measurement.mean, measurement.sd) == (estimate.mass, estimate.mass_sd)
        errors.append(measurement.mean - MASS)
        sds.append(measurement.sd)
    covered = np.mean(np.abs(errors) < 1.96 * np.array(sds))
    assert covered > 0.82  # binomial: 40 runs at 0.95, 99.9 %
    assert np.median(sds) < 0.03


def test_no_object_weighs_nothing(arm):
    estimate, _ = measure_weighing(arm, weigh(arm, np.random.default_rng(1), 0 * PAYLOAD))
    assert abs(estimate.mass) < 3 * estimate.mass_sd


def test_missing_phases_are_named(arm):
    phases = weigh(arm, np.random.default_rng(2))
    with pytest.raises(InvalidInput, match="0 named hold"):
        measure_weighing(arm, [p for p in phases if p.name != "hold"])
    with pytest.raises(InvalidInput, match="0 phases named tare"):
        measure_weighing(arm, [p for p in phases if p.name != "tare"])
