import dataclasses
import math

import numpy as np
import pytest

from benchmarks.squeezes import Squeeze, squeeze
from dynamics.compression import geometry_of
from dynamics.errors import InvalidInput
from dynamics.gripper import robotiq_2f85
from dynamics.signals import GripperReadings, Phase, Sample
from estimation.bounds import elasticity_at_least
from estimation.squeezing import between_steps, locked_current, measure_squeeze, moving
from estimation.stiffness import NoContact

FACE, PAD = robotiq_2f85("face"), robotiq_2f85("pad")
CUBE = (0.056, 0.056, 0.056)


def made(modulus, gripper, seed=0, **changes):
    geometry = geometry_of("box", CUBE, gripper)
    return squeeze(Squeeze(modulus, geometry, **changes), gripper, np.random.default_rng(seed))


@pytest.mark.parametrize("gripper", [FACE, PAD], ids=["face", "pad"])
@pytest.mark.parametrize("modulus", [2e4, 1e5, 1e6])
def test_without_noise_elasticity_and_width_are_exact(modulus, gripper):
    phases = made(modulus, gripper, quantised=False, current_sd=0.0, relative_sd=0.0)
    _, (elasticity, width) = measure_squeeze(gripper, "box", CUBE, phases)
    assert elasticity.property, elasticity.unit == ("elasticity", "Pa")
    assert elasticity.mean == pytest.approx(modulus, rel=0.01)
    assert width.property, width.unit == ("width", "m")
    assert width.mean == pytest.approx(0.056, abs=2e-4)


@pytest.mark.parametrize("modulus", [5e3, 1e5, 1e6])
def test_noise_steps_and_spikes_stay_within_what_is_said(modulus):
    errors, widths = [], []
    for seed in range(6):
        estimate, measurements = measure_squeeze(
            FACE, "box", CUBE, made(modulus, FACE, seed, spike_rate=0.05, max_strain=0.25)
        )
        if estimate.bound is not None:
            assert estimate.bound < modulus
            continue
        errors.append((estimate.young_modulus - modulus) / estimate.reading_sd)
        width = measurements[-1]
        widths.append((width.mean - 0.056) / width.sd)
    assert np.sqrt(np.mean(np.square(errors))) < 1.9  # of 6: exceeded once in 300
    assert np.sqrt(np.mean(np.square(widths))) < 1.9


def test_the_force_calibration_is_in_the_uncertainty():
    phases = made(5e4, FACE, gain=1.15)
    estimate, (elasticity, _) = measure_squeeze(FACE, "box", CUBE, phases)
    assert elasticity.sd > 0.1 * elasticity.mean
    assert abs(elasticity.mean - 5e4) < 2.2 * elasticity.sd
    assert estimate.reading_sd < 0.03 * elasticity.mean


def test_what_is_not_known_of_the_size_is_in_the_uncertainty():
    phases = made(5e4, FACE)
    _, (one, _) = measure_squeeze(FACE, "box", CUBE, phases)
    _, (other, _) = measure_squeeze(FACE, "box", CUBE, phases, size_sd=(0.002, 0.003, 0.004))
    extra = math.sqrt(sum(sd**2 for sd in (0.002, 0.003, 0.004))) / 0.056
    assert other.sd / other.mean == pytest.approx(math.hypot(one.sd / one.mean, extra), rel=0.02)


def test_a_missing_phase_is_named():
    phases = made(5e4, FACE)
    with pytest.raises(InvalidInput, match="a phase named air"):
        measure_squeeze(FACE, "box", CUBE, [p for p in phases if p.name != "air"])
    with pytest.raises(InvalidInput, match="a phase named compress"):
        measure_squeeze(FACE, "box", CUBE, [p for p in phases if p.name != "compress"])


def test_closing_on_nothing_is_no_contact():
    phases = made(5e4, FACE)
    air = [Phase("squeeze", name, 0, phases[0].samples) for name in ("air", "close", "compress")]
    with pytest.raises(NoContact):
        measure_squeeze(FACE, "box", CUBE, air)


def test_only_moving_pads_tell_of_force():
    time = np.arange(10) * 0.01
    opening = np.array([5.0, 5, 5, 4.8, 4.6, 4.4, 4.2, 4.2, 4.2, 4.2]) * 1e-2
    readings = GripperReadings(opening, np.full(10, 0.05), time)
    assert np.flatnonzero(moving(readings)).tolist() == [5, 6]  # the first two of the motion left out
    pressed = GripperReadings(opening, np.where(np.arange(10) > 2, 0.5, 0.05), time)
    assert np.flatnonzero(moving(pressed, locked=0.1)).tolist() == [5, 6, 7, 8, 9]
    still = GripperReadings(np.full(10, 0.05), np.full(10, 0.5), time)
    assert not moving(still, locked=0.1).any()


def test_locked_current_comes_from_the_dwells():
    dwell = GripperReadings(np.full(50, 0.05), np.full(50, 0.05), np.arange(50) * 0.01)
    assert 0.05 < locked_current([dwell]) < 0.15
    assert locked_current([]) == math.inf


def test_between_its_steps_the_opening_is_known_better():
    quantum = FACE.opening_quantum
    time = np.arange(60) * 0.01
    true = 0.05 - 0.02 * time
    readings = GripperReadings(np.round(true / quantum) * quantum, np.zeros(60), time)
    raw = np.std(readings.opening - true)
    assert np.std(between_steps(readings) - true) < raw / 2


def test_where_contact_is_left_open_there_is_no_width(monkeypatch):
    phases = made(1e6, FACE)
    known, measurements = measure_squeeze(FACE, "box", CUBE, phases)
    assert [m.property for m in measurements] == ["elasticity", "width"]
    nowhere = dataclasses.replace(known, young_modulus=math.nan, sd=math.inf, bound=5e5, onset_sd=math.inf)
    monkeypatch.setattr("estimation.squeezing._estimate", lambda *_: nowhere)
    assert measure_squeeze(FACE, "box", CUBE, phases) == (nowhere, (elasticity_at_least(5e5),))


@pytest.mark.parametrize("pushed", [0.0, 0.08])
def test_a_rigid_object_gives_a_bound_and_its_width(pushed):
    """Also where one pad pushed it along the table, with so many amperes, before the other one met it."""
    quantum, rng, phases = FACE.opening_quantum, np.random.default_rng(0), []
    stands = round(0.056 / quantum) * quantum

    def read(name, openings, currents, index=0):
        noisy = np.round((np.asarray(currents) + 0.01 * rng.standard_normal(len(openings))) / 0.01) * 0.01
        none = np.zeros(7)
        samples = [
            Sample(i / 100, none, none, none, o, c) for i, (o, c) in enumerate(zip(openings, noisy, strict=True))
        ]
        phases.append(Phase("squeeze", name, index, tuple(samples)))

    read("air", np.round(np.linspace(0.08, 0.06, 100) / quantum) * quantum, np.full(100, 0.05))
    way = np.round(np.linspace(0.06, 0.0565, 40) / quantum) * quantum
    read("grasp", [*way, *[stands] * 3], 0.05 + np.array([*np.linspace(0, pushed, 40), 0.1, 0.2, 0.3]))
    for index in range(8):
        read("compress", np.full(8, stands), 0.05 + np.linspace(0.0, 0.9, 8), index)
        read("dwell", np.full(15, stands), np.full(15, 0.05), index)
    estimate, (compliance, width) = measure_squeeze(FACE, "box", CUBE, phases)
    assert compliance == elasticity_at_least(estimate.bound)
    # about 40 N over at most one step: E >= F L / (A q), less the calibration's doubt
    assert 0.5 < estimate.bound / (40.0 * 0.056 / (0.056**2 * quantum)) < 1.1
    assert abs(width.mean - 0.056) < 2 * width.sd
