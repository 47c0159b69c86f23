"""Offsets of the torque sensors: told apart from a wrong revision, zeroed, and taken off."""

import numpy as np
import pytest

from dynamics.arm import Arm
from dynamics.errors import InvalidInput, MotionRefused
from hw import torque_tare
from hw.emulator.kinematic import HOME, KinematicRobot
from hw.kortex.errors import CheckFailed
from hw.settings import KortexSettings
from hw.torque_tare import STEPS, TorqueTare, fit_tare, visit_poses
from tests.conformance import MOVE, motion
from tests.hw.conftest import driving, serving

ARMS = {"V12": Arm.gen3(), "BRAKES": Arm.gen3("BRAKES")}
OFFSET = np.array([-1.42, -0.45, -1.89, -0.85, -0.16, -1.45, 0.1])  # N m, of the size published for an arm


def tares(true, assumed, hysteresis, count=200):
    """Tares of arms with offsets, noise, and readings that depend on the direction of the last motion."""
    rng = np.random.default_rng(3)
    q = HOME + STEPS
    band = hysteresis * np.array([0.3] * 4 + [0.15] * 3)
    for _ in range(count):
        noise = 0.03 * rng.normal(size=q.shape) + band * rng.choice([-1, 1], q.shape)
        yield fit_tare(ARMS, assumed, q, np.array([ARMS[true].gravity(pose) for pose in q]) + OFFSET + noise)


@pytest.mark.parametrize("revision", ["V12", "BRAKES"])
def test_offsets_are_found_within_their_uncertainty(revision):
    found = list(tares(revision, revision, 0.0))
    errors = np.array([tare.offset - OFFSET for tare in found])
    assert np.std(errors) == pytest.approx(0.03 / np.sqrt(len(STEPS)), rel=0.1)
    assert np.mean([tare.sd**2 for tare in found]) == pytest.approx(0.03**2 / len(STEPS), rel=0.1)
    assert np.mean([tare.likelier is not None for tare in found]) < 0.015


@pytest.mark.parametrize(("true", "assumed"), [("V12", "BRAKES"), ("BRAKES", "V12")])
def test_a_wrong_revision_is_told_apart_from_offsets(true, assumed):
    assert np.mean([tare.likelier == true for tare in tares(true, assumed, 0.0)]) > 0.95


@pytest.mark.parametrize("hysteresis", [0.1, 0.3, 1.0])
def test_the_right_revision_is_not_doubted(hysteresis):
    assert np.mean([tare.likelier is not None for tare in tares("V12", "V12", hysteresis, 1000)]) < 0.015


def test_a_tare_says_when_it_cannot_tell_the_revision():
    assert np.mean([tare.telling for tare in tares("V12", "V12", 1.0)]) < 0.1


def test_too_few_poses():
    with pytest.raises(InvalidInput, match="2 poses"):
        fit_tare(ARMS, "V12", np.zeros((2, 7)), np.zeros((2, 7)))


def test_a_file_of_a_tare(tmp_path):
    tare = TorqueTare(OFFSET, np.full(7, 0.01), "V12", {"V12": 0.01, "BRAKES": 0.2}, {"BRAKES": -40.0}, 6)
    tare.save(tmp_path / "tare.json")
    found = TorqueTare.load(tmp_path / "tare.json")
    assert found.offset == pytest.approx(OFFSET)
    assert (found.revision, found.poses, found.misfit) == ("V12", 6, tare.misfit)


@pytest.mark.parametrize(
    "text",
    ["", "[]", "{}", '{"torque_offset_N_m": [1], "sd_N_m": [1], "revision": "V12", "misfit_N_m": {}, "poses": 6}'],
)
def test_a_file_that_is_no_tare(tmp_path, text):
    file = tmp_path / "tare.json"
    with pytest.raises(InvalidInput, match="torque tare"):
        TorqueTare.load(file)
    file.write_text(text)
    with pytest.raises(InvalidInput, match="torque tare"):
        TorqueTare.load(file)


def test_a_tare_makes_zeroing_unnecessary(monkeypatch):
    monkeypatch.setattr(torque_tare, "SETTLE", 0.05)
    monkeypatch.setattr(torque_tare, "AVERAGE", 0.1)
    monkeypatch.setattr(torque_tare, "SPEED", 1.0)
    with serving(KinematicRobot("BRAKES", torque_offset=OFFSET, torque_noise=0.01)) as emulator:
        with (
            driving(emulator, revision="BRAKES") as robot,
            pytest.raises(CheckFailed, match="joint 3 reads"),
        ):
            robot.follow(motion(robot, MOVE))
        with driving(emulator, torque_tolerance=(4.0,) * 7) as robot:
            readings = visit_poses(robot, STEPS[[0, 3, 5]] / 2)
        assert fit_tare(robot.arms, "V12", *readings).likelier == "BRAKES"
        tare = fit_tare(robot.arms, "BRAKES", *readings)
        assert np.abs(tare.offset - OFFSET).max() < 0.03
        with driving(emulator, revision="BRAKES", tare=tare) as robot:
            robot.follow(motion(robot, MOVE))
            assert np.abs(robot.read().tau - robot.arm.gravity(robot.read().q)).max() < 0.2
        with pytest.raises(InvalidInput, match=r"torques of a BRAKES arm.*valid: those of a V12"):
            KortexSettings(revision="V12", tare=tare)


def test_zeroing_in_the_candle_pose():
    with serving(KinematicRobot(q=np.zeros(7), torque_offset=OFFSET)) as emulator, driving(emulator) as robot:
        assert np.abs(robot.read().tau).max() > 1
        assert np.abs(robot.zero_torques()).max() < 1e-6


def test_zeroing_elsewhere_is_refused():
    with serving() as emulator, driving(emulator) as robot:
        with pytest.raises(MotionRefused, match=r"180\.0 deg away"):
            robot.zero_torques()
        assert robot.check().problems == ()
