"""Series of signals: what is refused at the door, and how samples become series."""

import dataclasses

import numpy as np
import pytest

from dynamics.errors import InvalidInput
from dynamics.signals import GripperReadings, JointReadings, Phase, Sample

N, NV = 5, 7


def joints(**changed):
    rng = np.random.default_rng(0)
    series = {name: rng.normal(size=(N, NV)) for name in ("q", "tau", "dq", "ddq")}
    return JointReadings(**{**series, "time": np.arange(N) / 100, **changed})


def gripper(**changed):
    series = {"opening": np.linspace(0.08, 0.05, N), "effort": np.full(N, 0.1), "time": np.arange(N) / 100}
    return GripperReadings(**{**series, **changed})


def test_good_readings():
    assert len(joints()) == N
    assert len(joints(dq=None, ddq=None, time=None)) == N
    assert len(gripper()) == N
    assert len(joints(time=np.zeros(N))) == N  # two samples may carry one time


@pytest.mark.parametrize("name", ["q", "tau", "dq", "ddq"])
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_joint_numbers_that_are_not_finite_are_named_with_their_place(name, bad):
    series = np.zeros((N, NV))
    series[3, 2] = bad
    with pytest.raises(InvalidInput, match=rf"joint readings: {name}: .*\(3, 2\)"):
        joints(**{name: series})


@pytest.mark.parametrize("name", ["tau", "dq", "ddq"])
@pytest.mark.parametrize("shape", [(N, NV - 1), (N + 1, NV), (N,), (N, NV, 1), ()])
def test_joint_series_of_another_shape(name, shape):
    with pytest.raises(InvalidInput, match=f"joint readings: {name}: .*shape"):
        joints(**{name: np.zeros(shape)})


@pytest.mark.parametrize("shape", [(), (N,), (N, NV, 1)])
def test_positions_that_are_no_table(shape):
    with pytest.raises(InvalidInput, match=r"joint readings: q: .*shape"):
        joints(q=np.zeros(shape))


@pytest.mark.parametrize("make", [joints, gripper])
def test_time(make):
    times = np.array([0.0, 1.0, 0.5, 2.0, 3.0])
    with pytest.raises(InvalidInput, match="backwards at sample 2"):
        make(time=times)
    with pytest.raises(InvalidInput, match="time"):
        make(time=np.arange(N + 1.0))
    times[2] = np.nan
    with pytest.raises(InvalidInput, match="nan"):
        make(time=times)


@pytest.mark.parametrize("name", ["opening", "effort"])
def test_gripper_series(name):
    with pytest.raises(InvalidInput, match=f"gripper readings: {name}: .*nan"):
        gripper(**{name: np.array([0.0, np.nan, 0, 0, 0])})
    with pytest.raises(InvalidInput, match=r"gripper readings: .*shape"):
        gripper(**{name: np.zeros(N + 1)})
    with pytest.raises(InvalidInput, match=r"gripper readings: .*shape"):
        gripper(**{name: np.zeros((N, 1))})


def sample(i):
    base = np.arange(NV) + 100.0 * i
    return Sample(time=0.01 * i, q=base, dq=base + 0.1, tau=base + 0.2, opening=0.08 - 0.001 * i, effort=0.1 * i)


def test_phase_becomes_series():
    samples = tuple(sample(i) for i in range(4))
    phase = Phase("weigh", "tare", 0, samples)
    series, grip = phase.joints(), phase.gripper()
    assert len(series) == len(grip) == 4
    for i, s in enumerate(samples):
        for name in ("q", "dq", "tau", "time"):
            np.testing.assert_array_equal(getattr(series, name)[i], getattr(s, name))
        for name in ("opening", "effort", "time"):
            assert getattr(grip, name)[i] == getattr(s, name)
    assert series.ddq is None


def test_phase_without_samples_is_refused_when_read():
    with pytest.raises(InvalidInput):
        Phase("weigh", "tare", 0, ()).joints()


def test_signals_cannot_be_changed():
    with pytest.raises(dataclasses.FrozenInstanceError):
        sample(1).time = 2.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        joints().q = np.zeros((N, NV))
