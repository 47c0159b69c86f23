"""Slip onset off a robot's signals: a made-up grip that is loosened, whose friction is known."""

import numpy as np
import pytest

from dynamics.arm import Arm
from dynamics.errors import InvalidInput
from dynamics.gripper import robotiq_2f85
from dynamics.signals import Phase, Sample
from estimation.slipping import measure_slip

ARM, GRIPPER = Arm.gen3(), robotiq_2f85()
Q = np.radians([0.0, 20.0, 180.0, -110.0, 0.0, -50.0, 90.0])
AIR, WIDTH, STIFFNESS = 0.09, 0.056, 5000.0  # A, m, N/m


def sample(time, load, opening, effort, rng, noise, offset):
    up = ARM.tool_pose(Q)[:3, :3].T @ np.array([0.0, 0.0, load])
    tau = ARM.gravity(Q) + offset + ARM.tool_jacobian(Q)[:3].T @ up + noise * rng.standard_normal(7)
    return Sample(time, Q, np.zeros(7), tau, opening, effort)


def pull(weight, force):
    """Return what a hanging weight takes off the force that the motor feels [N]."""
    return GRIPPER.swing(WIDTH - force / STIFFNESS) * weight / 2


def loosened(mu, rng, mass=0.3, noise=0.05, slips=True, lands=False):
    """Close to 12 N, then open so that the force falls evenly to nothing within 6 s."""
    offset = rng.normal(0, 0.3, 7)
    weight = 9.81 * mass
    air = [sample(0.01 * k, 0, 0.085 - 2e-4 * k, AIR, rng, noise, offset) for k in range(50)]
    tare = [sample(1 + 0.01 * k, 0, 0.07, 0.05, rng, noise, offset) for k in range(100)]
    forces = np.linspace(0.5, 12.0, 60)
    compress = [
        sample(
            3 + 0.01 * k, weight, WIDTH - f / STIFFNESS,
            AIR + (f - pull(weight, f) - GRIPPER.friction_force) / GRIPPER.force_per_ampere, rng, noise, offset,
        )
        for k, f in enumerate(forces)
    ]  # fmt: skip
    loosen, landed = [], 0
    for k, f in enumerate(np.linspace(12.0, 0.2 if slips else 8.0, 600)):
        load = min(weight, 2 * mu * f)
        if lands and load < 0.95 * weight:  # it falls, lies on the table, and leans on the pads ever less
            landed = landed or k
            load = 0.7 * weight * (600 - k) / (600 - landed)
        loosen.append(sample(5 + 0.01 * k, load, WIDTH - f / STIFFNESS, 0.05, rng, noise, offset))
    named = {"air": air, "tare": tare, "compress": compress, "loosen": loosen}
    return [Phase("slip", name, 0, tuple(samples)) for name, samples in named.items()]


@pytest.mark.parametrize("mu", [0.3, 0.6, 0.9])
def test_onset_gives_the_coefficient(mu):
    found, measurement = measure_slip(ARM, GRIPPER, loosened(mu, np.random.default_rng(0)))
    assert found.coefficient == pytest.approx(mu, rel=0.05)
    assert abs(found.coefficient - mu) < 3 * found.sd
    assert (found.method, measurement.property) == ("slip", "friction")


@pytest.mark.parametrize("mu", [0.3, 0.6, 0.9])
def test_what_lands_on_the_table_then_tells_nothing(mu):
    found, _ = measure_slip(ARM, GRIPPER, loosened(mu, np.random.default_rng(3), lands=True))
    assert found.coefficient == pytest.approx(mu, rel=0.1)
    assert abs(found.coefficient - mu) < 2.6 * found.sd


def test_weight_that_helped_the_motor_to_close_is_taken_into_account():
    # 1 kg: 2 N of the 12; a force that is a sixth too low is a coefficient that is a fifth too high.
    found, _ = measure_slip(ARM, GRIPPER, loosened(0.9, np.random.default_rng(4), mass=1.0, noise=0.01))
    assert found.coefficient == pytest.approx(0.9, rel=0.03)


def test_calibration_of_the_gripper_is_in_the_uncertainty():
    found, _ = measure_slip(ARM, GRIPPER, loosened(0.6, np.random.default_rng(1)))
    assert found.sd >= 0.09 * found.coefficient * (1 - GRIPPER.friction_force / found.normal)


def test_what_does_not_slip_or_is_missing_is_refused():
    phases = loosened(0.6, np.random.default_rng(2), slips=False)
    with pytest.raises(InvalidInput, match="slip"):
        measure_slip(ARM, GRIPPER, phases)
    with pytest.raises(InvalidInput, match="phases named tare"):
        measure_slip(ARM, GRIPPER, [p for p in phases if p.name != "tare"])
