"""A rub along the sides of a pinched object: from made-up torques and currents, whose friction is known."""

import dataclasses

import numpy as np
import pytest

from dynamics.arm import Arm
from dynamics.errors import InvalidInput
from dynamics.gripper import robotiq_2f85
from dynamics.kinematics import solve_pose, tool_down
from dynamics.signals import Phase, Sample
from estimation.pinching import JUDDER_SD, LOSS, NET, NET_SD, SLIDE_SD, Slide, find_slides, measure_pinched_rub
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


def rub(mu, rng, *, force=8.0, slides=4, noise=0.0, current_noise=0.0, after=1.0, stuck=False, judder=0.0):
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
        steady = pulls[-1]
        pulls = pulls * (1 - judder * (rng.random(len(PATH)) < 0.1))  # pads jump off the sides now and then
        pressed = closing(PATH[0], offset, 1.0, force / 2, force, WIDTH)
        slide = [
            Sample(0.01 * k, q, np.zeros(7), torque(q, offset, pull, aside=2.0), WIDTH, LOCKED)
            for k, (q, pull) in enumerate(zip(PATH, pulls, strict=True))
        ]
        again = closing(PATH[-1], offset, float(steady), force * after, 1.4 * force * after, WIDTH)
        phases += [
            Phase("rub", "press", 2 * index, noisy(pressed)),
            Phase("rub", "slide", index, noisy(slide)),
            Phase("rub", "press", 2 * index + 1, noisy(again)),
        ]
    return phases


@pytest.mark.parametrize("mu", [0.2, 0.5, 1.0])
def test_without_noise_the_coefficient_is_exact(mu):
    # Whatever offset the torque sensors have, how the pads swing, and what presses on them aside.
    found, measurement = measure_rub(ARM, rub(mu, np.random.default_rng(0)), gripper=GRIPPER)
    assert found.coefficient * NET == pytest.approx(mu, rel=5e-3)
    assert found.normal == pytest.approx(8.0, rel=1e-3)
    assert (measurement.property, measurement.unit) == ("friction", "1")
    assert found.interval[0] < mu < found.interval[1]


@pytest.mark.parametrize("after", [0.85, 1.25])
def test_force_that_changes_on_the_way_counts_for_little(after):
    # T is that of the last half of the slide, F that at its end.
    found, _ = measure_rub(ARM, rub(0.5, np.random.default_rng(0), after=after), gripper=GRIPPER)
    assert found.coefficient * NET == pytest.approx(0.5, rel=0.1)
    assert found.normal == pytest.approx(8.0 * after, rel=1e-3)


def test_juddering_pads_are_read_by_the_upper_part_of_their_force():
    phases = rub(0.5, np.random.default_rng(0), judder=0.6)
    found, _ = measure_rub(ARM, phases, gripper=GRIPPER)
    net = np.median([slide.net for slide in find_slides(ARM, GRIPPER, phases)])
    assert NET - LOSS < net < NET - 0.1 * LOSS
    assert found.coefficient * net == pytest.approx(0.5, rel=0.03)


def test_the_further_the_pull_falls_the_less_of_it_is_left():
    quiet, juddering, torn = (Slide(8.0, 8.0, 8.0, 8.0, 8.0, 0.1, kept=kept) for kept in (1.0, 0.5, -0.1))
    assert (quiet.net, juddering.net, torn.net) == pytest.approx((NET, NET - LOSS / 2, NET - LOSS))
    assert juddering.coefficient == pytest.approx(8.0 / (2 * juddering.net * 8.0))


def test_readings_after_the_pads_have_jumped_say_nothing_of_the_force():
    phases = rub(0.5, np.random.default_rng(0))
    for number, phase in enumerate(phases):
        if phase.name == "press" and phase.index % 2:
            jumped = [dataclasses.replace(s, effort=AIR + 0.03) for s in phase.samples[4:]]
            phases[number] = dataclasses.replace(phase, samples=(*phase.samples[:4], *jumped))
    found, _ = measure_rub(ARM, phases, gripper=GRIPPER)
    assert found.coefficient * NET == pytest.approx(0.5, rel=5e-3)


def test_readings_of_the_sensors_are_within_the_uncertainty():
    # The noise of the simulator's sensors; calibration and method are exact here: only the readings' part counts.
    errors = []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        phases = rub(0.5, rng, noise=0.1, current_noise=0.01)
        errors.append(measure_pinched_rub(ARM, GRIPPER, phases)[0].coefficient * NET / 0.5 - 1)
    assert abs(np.mean(errors)) < 0.05  # the upper part of a noisy pull reads a little high
    assert np.std(errors) < 1.5 * SLIDE_SD / 2  # four slides, and what the force is read to


def test_slides_that_differ_more_than_is_known_of_them_widen_the_uncertainty():
    even = rub(0.5, np.random.default_rng(1))
    odd = [rub(mu, np.random.default_rng(1), slides=1)[2:] for mu in (0.35, 0.65, 0.4, 0.6)]
    found, _ = measure_pinched_rub(ARM, GRIPPER, even)
    other, _ = measure_pinched_rub(ARM, GRIPPER, [*even[:2], *(phase for phases in odd for phase in phases)])
    own, more = ((e.sd / e.coefficient) ** 2 - NET_SD**2 for e in (found, other))
    assert more > 1.44 * own


def test_a_slide_that_went_wrong_is_weighed_down():
    good = rub(0.5, np.random.default_rng(1))
    bad = rub(1.4, np.random.default_rng(1), slides=1)
    found, _ = measure_pinched_rub(ARM, GRIPPER, [*good, *bad[2:]])
    assert found.coefficient * NET == pytest.approx(0.5, rel=0.02)


def test_force_is_that_at_the_end():
    assert Slide(8.0, 8.0, 8.0, 8.0, 8.4, 0.1).force == 8.4
    assert Slide(16.0, 16.0, 16.0, 8.0, 12.0, 0.1).coefficient == pytest.approx(16 / 24 / NET)


@pytest.mark.parametrize("lost", [1.5, 3.0])
def test_pads_that_jumped_count_between_what_they_pulled_and_what_is_left(lost):
    # They slid with more force than is read after, and rest with less pull than that force could hold.
    force, mu = 8.0, 0.5
    slide = Slide(2 * mu * NET * force * lost, 0.0, 2 * mu * NET * force / lost, 0.0, force, 0.1)
    assert slide.coefficient == pytest.approx(mu)
    even = Slide(2 * mu * NET * force, 0.0, 2 * mu * NET * force, 0.0, force, 0.1)
    assert slide.relative_sd > 1.2 * even.relative_sd
    nothing_left = Slide(8.0, 8.0, -0.1, 8.0, 8.0, 0.1)
    assert 0 < nothing_left.coefficient < 0.25
    assert nothing_left.relative_sd > 0.5


@pytest.mark.parametrize("jumps", [2, 5])
def test_the_more_slides_jump_the_wider_is_the_uncertainty(monkeypatch, jumps):
    def sliding(kept):
        pull = 2 * 0.5 * (NET - LOSS * (1 - kept)) * 8.0
        return Slide(pull, pull, pull, 8.0, 8.0, 0.1, kept=kept)

    def found(slides):
        monkeypatch.setattr("estimation.pinching.find_slides", lambda *_: tuple(slides))
        return measure_pinched_rub(ARM, GRIPPER, ())[0]

    smooth = [sliding(0.8)] * 5
    jumping = [sliding(0.05)] * jumps + smooth[jumps:]
    wide, usual = found(jumping), found(smooth)
    assert wide.coefficient == pytest.approx(usual.coefficient) == pytest.approx(0.5)
    assert wide.sd**2 - usual.sd**2 == pytest.approx((0.5 * JUDDER_SD * jumps / 5) ** 2)
    # Thrown about, it may be pulled at more in the end than on the way: no sign of pads that never slid.
    rising = [dataclasses.replace(slide, middle=0.2 * slide.sliding) for slide in jumping]
    if jumps < 3:
        with pytest.raises(InvalidInput, match="or more"):
            found(rising)
    else:
        assert found(rising).coefficient == pytest.approx(0.5)


def test_a_slide_tells_whether_the_pads_jumped():
    assert not any(slide.jumped for slide in find_slides(ARM, GRIPPER, rub(0.5, np.random.default_rng(1))))


def test_pads_that_never_slid_give_a_bound_in_words():
    phases = rub(0.5, np.random.default_rng(2), stuck=True)
    with pytest.raises(InvalidInput, match=r"mu is 0\.\d+ or more"):
        measure_pinched_rub(ARM, GRIPPER, phases)


def test_what_is_missing_is_named():
    phases = rub(0.5, np.random.default_rng(3))
    with pytest.raises(InvalidInput, match="air and slide"):
        find_slides(ARM, GRIPPER, [p for p in phases if p.name != "air"])
    with pytest.raises(InvalidInput, match="without a press after it"):
        find_slides(ARM, GRIPPER, [p for p in phases if p.name != "press"])
    with pytest.raises(InvalidInput, match="pads that press"):
        measure_pinched_rub(ARM, GRIPPER, rub(0.5, np.random.default_rng(4), force=0.2))
