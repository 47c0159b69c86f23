"""A rub along the sides of a pinched object: from made-up torques and currents, whose friction is known."""

import numpy as np
import pytest

from dynamics.arm import Arm
from dynamics.errors import InvalidInput
from dynamics.gripper import robotiq_2f85
from dynamics.kinematics import solve_pose, tool_down
from dynamics.signals import Phase, Sample
from estimation.pinching import SLIDE_SD, Slide, find_slides, measure_pinched_rub
from estimation.rubbing import measure_rub

ARM, GRIPPER = Arm.gen3(), robotiq_2f85()
WAY = np.linspace(0.0, -0.008, 60)
START = tool_down([0.5, 0.0, 0.16], 0.0)
NEAR = np.radians([0.0, 20.0, 180.0, -110.0, 0.0, -50.0, 90.0])
AIR, LOCKED = 0.09, 0.05  # A
WIDTH = 0.056


def path():
    near, positions = NEAR, []
    for z in WAY:
        pose = START.copy()
        pose[2, 3] += z
        near = solve_pose(ARM, pose, near)
        positions.append(near)
    return positions


PATH = path()


def torque(q, offset, pull=0.0, aside=0.0):
    """What the sensors read when the pads are pulled up and pressed aside, in the closing direction."""
    force = np.array([0.0, aside, -pull])  # of the tool on the object, base frame
    inside = ARM.tool_pose(q)[:3, :3].T @ force
    return ARM.gravity(q) + offset + ARM.tool_jacobian(q).T @ np.concatenate([inside, np.zeros(3)])


def closing(q, offset, pull, first, last, opening, count=10):
    """The samples of a closing from rest to rest, in which the force of a pad rises from one to another."""
    t = np.arange(1, count + 1) / count
    force = first + (last - first) * np.where(t < 0.5, 2 * t**2, 1 - 2 * (1 - t) ** 2)
    felt = force + GRIPPER.swing(opening) * pull / 2 - GRIPPER.friction_force
    return [
        Sample(0.01 * k, q, np.zeros(7), torque(q, offset, pull), opening, AIR + f / GRIPPER.force_per_ampere)
        for k, f in enumerate(felt)
    ]


def rub(mu, rng, *, force=8.0, slides=4, noise=0.0, current_noise=0.0, after=1.0, stuck=False):
    offset = rng.normal(0, 0.3, 7)

    def noisy(samples):
        return tuple(
            Sample(
                s.time, s.q, s.dq, s.tau + noise * rng.standard_normal(7), s.opening,
                s.effort + current_noise * rng.standard_normal(),
            )
            for s in samples
        )  # fmt: skip

    idle = [
        Sample(0.01 * k, PATH[0], np.zeros(7), torque(PATH[0], offset), 0.085 - 2e-4 * k, AIR) for k in range(60)
    ]
    air = [Sample(0.01 * k, q, np.zeros(7), torque(q, offset), 0.062, LOCKED) for k, q in enumerate(PATH)]
    phases = [Phase("rub", "idle", 0, noisy(idle)), Phase("rub", "air", 0, noisy(air))]
    for index in range(slides):
        dragged = np.linspace(0, 1, len(PATH)) if stuck else np.minimum(np.linspace(0, 4, len(PATH)), 1.0)
        pulls = 2 * mu * np.linspace(force, force * after, len(PATH)) * dragged
        pressed = closing(PATH[0], offset, 1.0, force / 2, force, WIDTH)
        slide = [
            Sample(0.01 * k, q, np.zeros(7), torque(q, offset, pull, aside=2.0), WIDTH, LOCKED)
            for k, (q, pull) in enumerate(zip(PATH, pulls, strict=True))
        ]
        again = closing(PATH[-1], offset, float(pulls[-1]), force * after, 1.4 * force * after, WIDTH)
        phases += [
            Phase("rub", "press", 2 * index, noisy(pressed)),
            Phase("rub", "slide", index, noisy(slide)),
            Phase("rub", "press", 2 * index + 1, noisy(again)),
        ]
    return phases


@pytest.mark.parametrize("mu", [0.2, 0.5, 1.0])
@pytest.mark.parametrize("after", [1.0, 1.5])
def test_without_noise_the_coefficient_is_exact(mu, after):
    # Whatever offset the torque sensors have, how the pads swing, and what presses on them aside.
    found, measurement = measure_rub(ARM, rub(mu, np.random.default_rng(0), after=after), gripper=GRIPPER)
    assert found.coefficient == pytest.approx(mu, rel=5e-3)
    assert found.normal == pytest.approx(8.0 * (1 + 0.75 * (after - 1)), rel=1e-3)  # of the second half of a slide
    assert (measurement.property, measurement.unit) == ("friction", "1")
    assert found.interval[0] < mu < found.interval[1]


def test_readings_of_the_sensors_are_within_the_uncertainty():
    # The noise of the simulator's sensors; calibration and method are exact here: only the readings' part counts.
    errors = []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        phases = rub(0.5, rng, noise=0.1, current_noise=0.01)
        errors.append(measure_pinched_rub(ARM, GRIPPER, phases)[0].coefficient / 0.5 - 1)
    assert abs(np.mean(errors)) < 0.04  # the limit of a noisy pull is read a little high
    assert np.std(errors) < SLIDE_SD / 2  # four slides


def test_a_slide_that_went_wrong_is_weighed_down():
    good = rub(0.5, np.random.default_rng(1))
    bad = rub(1.4, np.random.default_rng(1), slides=1)
    found, _ = measure_pinched_rub(ARM, GRIPPER, [*good, *bad[2:]])
    assert found.coefficient == pytest.approx(0.5, rel=0.02)


def test_force_is_that_of_the_second_half():
    assert Slide(8.0, 8.0, 8.0, 8.0, 8.4, 0.1).force == pytest.approx(8.3)
    assert Slide(16.0, 16.0, 16.0, 8.0, 12.0, 0.1).coefficient == pytest.approx(16 / 22)


def test_pads_that_never_slid_give_a_bound_in_words():
    phases = rub(0.5, np.random.default_rng(2), stuck=True)
    with pytest.raises(InvalidInput, match=r"mu is 0\.\d+ or more"):
        measure_pinched_rub(ARM, GRIPPER, phases)


def test_what_is_missing_is_named():
    phases = rub(0.5, np.random.default_rng(3))
    with pytest.raises(InvalidInput, match="air and slide"):
        find_slides(ARM, GRIPPER, [p for p in phases if p.name != "air"])
    with pytest.raises(InvalidInput, match="press before and after"):
        find_slides(ARM, GRIPPER, [p for p in phases if p.name != "press"])
    with pytest.raises(InvalidInput, match="pads that press"):
        measure_pinched_rub(ARM, GRIPPER, rub(0.5, np.random.default_rng(4), force=0.2))
