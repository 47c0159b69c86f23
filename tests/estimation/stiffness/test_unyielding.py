import numpy as np
import pytest

from dynamics.compression import geometry_of
from dynamics.gripper import robotiq_2f85
from estimation.stiffness import CurveNoise
from estimation.stiffness.unyielding import hardly_gives

GRIPPER = robotiq_2f85("face")
CUBE = geometry_of("box", (0.056,) * 3, GRIPPER)
QUANTUM = GRIPPER.opening_quantum
NOISE = CurveNoise(stress_sd=1.0, gain_sd=0.1)


def readings(modulus: float, rng: np.random.Generator, gain: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Eight closings from a tenth of the force to all of it, at 8 readings each, as reported."""
    force = np.tile(np.linspace(6.0, 55.0, 8), 8)
    width = CUBE.width + rng.uniform(-0.5, 0.5) * QUANTUM
    opening = width * (1 - force / (modulus * CUBE.area))
    sd = np.hypot(0.6, 0.02 * force)
    return np.round(opening / QUANTUM) * QUANTUM, gain * force + sd * rng.standard_normal(len(force)), sd


@pytest.mark.parametrize("modulus", [1.5e6, 1e7, 1e12])
def test_the_bound_holds_and_says_something(modulus: float) -> None:
    rng = np.random.default_rng(0)
    bounds = []
    for _ in range(200):
        found = hardly_gives(*readings(modulus, rng, 1 + 0.1 * rng.standard_normal()), QUANTUM, CUBE, NOISE)
        assert found is not None
        assert found.bound is not None
        assert abs(found.onset - CUBE.width) < 3 * found.onset_sd
        bounds.append(found.bound)
    # 95 % by the calibration alone; the steps that are taken in full make it safer
    assert np.mean(np.array(bounds) < modulus) >= 0.95
    # at the worst, two steps are seen and three counted
    least = 40.0 / CUBE.area / (3 * QUANTUM / CUBE.width)
    assert min(bounds) > 0.5 * least


def test_what_gives_is_left_to_the_line() -> None:
    rng = np.random.default_rng(1)
    assert hardly_gives(*readings(2e5, rng, 1.0), QUANTUM, CUBE, NOISE) is None


def test_without_steps_or_force_nothing_is_said() -> None:
    opening, force, sd = readings(1e7, np.random.default_rng(2), 1.0)
    assert hardly_gives(opening, force, sd, 0.0, CUBE, NOISE) is None
    assert hardly_gives(opening, 0.01 * force, sd, QUANTUM, CUBE, NOISE) is None
