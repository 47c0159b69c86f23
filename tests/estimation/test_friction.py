import math

import numpy as np
import pytest

from dynamics.arm import Arm
from dynamics.errors import InvalidInput
from dynamics.kinematics import solve_pose, tool_down
from dynamics.signals import Phase, Sample
from estimation.friction import SHEAR_SD, Stroke, estimate_friction, estimate_friction_at_slip
from estimation.rubbing import measure_rub


def strokes(mu, rng, offset=0.0, noise=0.2, normal=5.0, ways=(1, -1), n=200):
    found = []
    for way in ways:
        press = normal + noise * rng.standard_normal(n)
        press[rng.random(n) < 0.1] = 0.0  # the contact chatters
        dragged = np.minimum(1.0, np.arange(n) / 60)  # and slides only after a while
        found.append(Stroke(way * mu * press * dragged + offset + noise * rng.standard_normal(n), press, way))
    return found


def test_without_noise_the_coefficient_is_exact():
    rng = np.random.default_rng(0)
    found = estimate_friction(strokes(0.6, rng, offset=3.0, noise=0.0))
    assert found.coefficient == pytest.approx(0.6, rel=1e-9)
    assert found.offset == pytest.approx(3.0, abs=0.05)
    assert found.forward == pytest.approx(0.6, abs=0.02)
    assert found.backward == pytest.approx(0.6, abs=0.02)
    assert found.measurement().unit == "1"


def test_uncertainty_of_the_readings_is_what_it_says():
    rng = np.random.default_rng(1)
    scores = []
    for _ in range(250):
        found = estimate_friction(strokes(0.5, rng, offset=rng.normal(0, 2)))
        reading = math.sqrt(found.sd**2 - (SHEAR_SD * found.coefficient) ** 2)
        scores.append((found.coefficient - 0.5) / reading)
    assert np.mean(scores) == pytest.approx(0.0, abs=0.25)
    assert np.std(scores) == pytest.approx(1.05, abs=0.2)  # batch means of 16 are a little narrow


def test_scaling_both_forces_changes_nothing():
    one = strokes(0.4, np.random.default_rng(2))
    other = [Stroke(7 * s.tangential, 7 * s.normal, s.direction) for s in one]
    assert estimate_friction(one).coefficient == pytest.approx(estimate_friction(other).coefficient)


def test_one_way_needs_to_know_the_offset():
    one_way = strokes(0.4, np.random.default_rng(3), ways=(1,))
    with pytest.raises(InvalidInput, match="both ways"):
        estimate_friction(one_way)
    found = estimate_friction(one_way, offset_sd=0.5)
    assert found.sd > 0.5 / 5.0 * 0.95
    backward = estimate_friction(strokes(0.4, np.random.default_rng(3), ways=(-1,)), offset_sd=0.5)
    assert backward.coefficient == pytest.approx(0.4, abs=0.05)


@pytest.mark.parametrize(
    "bad", [[], [Stroke(np.ones(30), -np.ones(30), 1), Stroke(np.ones(30), -np.ones(30), -1)]]
)
def test_no_strokes_and_no_pressing_are_refused(bad):
    with pytest.raises(InvalidInput, match="friction"):
        estimate_friction(bad)


def test_broken_strokes_are_refused():
    with pytest.raises(InvalidInput, match="24 or more"):
        Stroke(np.ones(5), np.ones(5), 1)
    with pytest.raises(InvalidInput, match="direction"):
        Stroke(np.ones(30), np.ones(30), 0)


def slide(mu, rng, mass=0.2):
    """A held object while the grip is loosened evenly: once 2 mu F < m g, it falls."""
    t = np.linspace(0.0, 4.0, 400)
    force = 8.0 - 1.9 * t
    fall = np.maximum(9.81 - 2 * mu * force / mass, 0.0)
    s = np.cumsum(np.cumsum(fall)) * (t[1] - t[0]) ** 2 + 1e-4 * rng.standard_normal(len(t))
    held = s < 0.02
    return t[held], s[held], force[held], mass


def test_slip_onset_gives_the_coefficient():
    rng = np.random.default_rng(4)
    errors = []
    for mu in np.linspace(0.3, 0.6, 8):
        found = estimate_friction_at_slip(*slide(mu, rng))
        assert abs(found.coefficient - mu) < 4 * found.sd + 0.01 * mu  # within the lag that noise hides
        errors.append(found.coefficient / mu - 1)
    assert np.sqrt(np.mean(np.square(errors))) < 0.03


def test_mass_is_in_the_uncertainty_of_a_slip():
    t, s, force, mass = slide(0.4, np.random.default_rng(5))
    one = estimate_friction_at_slip(t, s, force, mass)
    other = estimate_friction_at_slip(t, s, force, mass, mass_sd=0.02)
    assert other.sd == pytest.approx(math.hypot(one.sd, 0.1 * one.coefficient), rel=1e-6)


def test_what_does_not_slip_is_refused():
    t = np.linspace(0, 4, 400)
    still = 1e-4 * np.random.default_rng(6).standard_normal(400)
    with pytest.raises(InvalidInput, match="an object that slips"):
        estimate_friction_at_slip(t, still, 8 - 1.9 * t, 0.2)
    with pytest.raises(InvalidInput, match="in order"):
        estimate_friction_at_slip(t[::-1], still, 8 - 1.9 * t, 0.2)
    with pytest.raises(InvalidInput, match="mass"):
        estimate_friction_at_slip(t, still, 8 - 1.9 * t, 0.0)


def test_a_rub_is_read_off_the_joint_torques():
    arm, mu, press = Arm.gen3(), 0.55, 6.0
    near = np.radians([0.0, 20.0, 180.0, -110.0, 0.0, -50.0, 90.0])
    way = np.linspace(0.0, 0.04, 40)
    phases = []
    for index, direction in enumerate((1, -1)):
        paths = {"air": [], "slide": []}
        for k, x in enumerate(way if direction > 0 else way[::-1]):
            q = solve_pose(arm, tool_down([0.45, x, 0.10], 0.0), near)
            near = q
            dry = 0.3 * direction * np.ones(7)  # the joints' own friction
            tau = arm.gravity(q) + dry
            force = np.array([0.0, direction * mu * press, -press])  # on the object
            inside = arm.tool_pose(q)[:3, :3].T @ force
            pushing = tau + arm.tool_jacobian(q).T @ np.concatenate([inside, np.zeros(3)])
            for name, torque in (("air", tau), ("slide", pushing)):
                paths[name].append(Sample(0.01 * k, q, np.zeros(7), torque, 0.0, 0.0))
        phases += [Phase("rub", name, index, tuple(samples)) for name, samples in paths.items()]
    found, measurement = measure_rub(arm, phases)
    assert found.coefficient == pytest.approx(mu, rel=0.01)
    assert found.normal == pytest.approx(press, rel=0.01)
    assert measurement.property == "friction"
    with pytest.raises(InvalidInput, match="2 slide, 1 air"):
        measure_rub(arm, [p for p in phases if (p.name, p.index) != ("air", 1)])
