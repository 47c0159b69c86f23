import math

import numpy as np
import pytest

from dynamics.errors import InvalidInput
from dynamics.gripper import calibrate_force, robotiq_2f85

GRIPPER = robotiq_2f85()


def test_driver_angle_and_opening_agree_at_the_ends():
    assert GRIPPER.opening_at_driver(0.0) == pytest.approx(0.085)
    assert GRIPPER.opening_at_driver(GRIPPER.driver_range) == pytest.approx(0.0, abs=1e-12)
    assert GRIPPER.driver_range == pytest.approx(0.7929, abs=0.005)  # the maker's closed position


def test_opening_undoes_the_crank_angle():
    for opening in np.linspace(0.0, 0.085, 20):
        assert GRIPPER.opening(GRIPPER.crank_angle(opening)) == pytest.approx(opening, abs=1e-12)


def test_position_in_percent_is_linear():
    assert GRIPPER.opening_at_percent(0.0) == pytest.approx(0.085)
    assert GRIPPER.opening_at_percent(100.0) == 0.0
    with pytest.raises(InvalidInput, match="position"):
        GRIPPER.opening_at_percent(230.0)


def test_pad_force_does_the_work_of_the_torque():
    opening, torque, step = 0.05, 2.0, 1e-6
    driver = GRIPPER.crank_angle(GRIPPER.max_opening) - GRIPPER.crank_angle(opening)
    closed = GRIPPER.opening_at_driver(driver - step) - GRIPPER.opening_at_driver(driver + step)
    # Both pads travel half the closing each, under the force of one.
    assert GRIPPER.pad_force(torque, opening) * closed == pytest.approx(torque * 2 * step, rel=1e-6)


def test_force_of_a_current_counts_from_air():
    force = GRIPPER.force(np.array([0.05, 0.15]), air=0.1)
    np.testing.assert_allclose(force, [0.0, 60.0 * 0.05 + 0.5])
    assert GRIPPER.force_sd(force)[1] == pytest.approx(math.hypot(0.1 * 3.0, 0.3))


def test_calibration_finds_the_force_per_ampere():
    rng = np.random.default_rng(3)
    effort = np.linspace(0.1, 1.0, 40)
    found = []
    for _ in range(300):
        force = 55.0 * (effort - 0.08) - 2.0 + rng.normal(0, 1.0, 40)
        slope, sd = calibrate_force(force, effort, 0.08)
        found.append((slope - 55.0) / sd)
    assert np.mean(found) == pytest.approx(0.0, abs=4 / math.sqrt(300))
    assert np.std(found) == pytest.approx(1.0, abs=0.15)


def test_a_calibration_with_one_current_is_refused():
    with pytest.raises(InvalidInput, match="differ"):
        calibrate_force(np.arange(5.0), np.full(5, 0.3), 0.0)
