"""Calibration and weighing of moving arms on simulated currents, where the truth is known, and on real logs."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lfilter

from dynamics.arm import Arm
from dynamics.errors import InvalidInput
from estimation.calibrate import main
from estimation.payload.drives import Drives
from estimation.payload.drives_fit import calibrate_drives
from estimation.payload.motion import estimate_payload_motion
from estimation.payload.motion_rows import JointLog, motion_rows
from estimation.readers import LogMap, read_log

GAIN = np.array([9.0, 12.0, 10.0, 8.0, 8.0, 7.0])  # N m/A
COULOMB, VISCOUS = np.array([8, 9, 5, 2, 2, 1.5]), np.array([9, 9, 6, 2, 2, 1.5])
MASS, CENTER = 2.0, np.array([0.03, 0.05, 0.1])
BODY = np.concatenate([[MASS], MASS * CENTER, [0.03, -0.003, 0.026, -0.006, -0.01, 0.012]])


@pytest.fixture(scope="module")
def arm():
    return Arm.named("ur5")


@pytest.fixture(scope="module")
def true_arm(arm):
    """Return the arm as it is: its links differ from the description by a tenth."""
    rng, model = np.random.default_rng(0), arm.model.copy()
    for joint in range(1, model.njoints):
        body = model.inertias[joint]
        body.mass *= 1 + 0.1 * rng.normal()
        body.lever = body.lever * (1 + 0.1 * rng.normal(size=3))
        model.inertias[joint] = body
    return Arm(model, arm.tool_frame)


def record(true_arm, seed, payload=None, kind="current"):
    """Return a log of 20 s at 50 Hz on sums of harmonics, with correlated noise and a few spikes."""
    rng = np.random.default_rng(seed)
    time = np.arange(0, 20, 0.02)
    phase = 2 * np.pi * np.arange(1, 6)[:, None, None] / 20 * time[None, :, None]
    a, b = 0.5 * rng.normal(size=(2, 5, 1, 6)) / np.arange(1, 6)[:, None, None] ** 0.7
    w = 2 * np.pi * np.arange(1, 6)[:, None, None] / 20
    q = (a * np.sin(phase) + b * np.cos(phase)).sum(axis=0) + np.array([0, -1.2, 0.8, -0.5, 0.4, 0])
    dq = (w * (a * np.cos(phase) - b * np.sin(phase))).sum(axis=0)
    ddq = -(w**2 * (a * np.sin(phase) + b * np.cos(phase))).sum(axis=0)
    tau = np.array([true_arm.inverse_dynamics(*row) for row in zip(q, dq, ddq, strict=True)])
    if payload is not None:
        tau += np.array([true_arm.payload_regressor(*row) @ payload for row in zip(q, dq, ddq, strict=True)])
    tau += COULOMB * np.tanh(dq / 0.02) + VISCOUS * dq
    slow = lfilter([0.1], [1, -0.97], rng.normal(size=tau.shape), axis=0) * COULOMB * 0.1
    tau += slow + 0.05 * COULOMB * rng.normal(size=tau.shape)
    effort = tau / GAIN if kind == "current" else tau
    effort = effort + 5 * (rng.random(tau.shape) < 0.002)
    return JointLog(time, q + 1e-5 * rng.normal(size=q.shape), effort, kind, dq + 1e-3 * rng.normal(size=q.shape))


@pytest.fixture(scope="module")
def rows(arm, true_arm):
    other = 0.6 * BODY
    payloads = {"empty": None, "again": None, "reference": BODY, "other": other, "unseen": None}
    return {name: motion_rows(arm, record(true_arm, i, p)) for i, (name, p) in enumerate(payloads.items())}


@pytest.fixture(scope="module")
def drives(arm, rows):
    return calibrate_drives(arm, [rows["empty"], rows["again"]], [rows["reference"]], MASS)


def test_gains_come_from_a_known_mass(drives):
    loaded = slice(1, 4)  # shoulder, elbow, first wrist joint: those that the payload's weight loads
    assert np.all(np.abs(drives.gain - GAIN)[loaded] < 4 * drives.gain_sd[loaded])
    assert np.all(drives.gain_sd[loaded] < 0.06 * GAIN[loaded])


def test_another_payload_and_none_are_read_right(drives, rows):
    other = estimate_payload_motion(rows["other"], drives)
    assert abs(other.mass - 0.6 * MASS) < 3 * other.mass_sd
    assert other.mass_sd < 0.1
    np.testing.assert_allclose(other.center_of_mass, CENTER, atol=0.03)
    unseen = estimate_payload_motion(rows["unseen"], drives)
    assert abs(unseen.mass) < 3 * unseen.mass_sd
    empty = estimate_payload_motion(rows["again"], drives)
    assert not empty.mass_is_distinct
    assert "no payload" in empty.verdict
    assert np.all(np.isnan(empty.center_of_mass))


def test_bootstrap_agrees_with_the_formula(drives, rows):
    formula = estimate_payload_motion(rows["other"], drives)
    drawn = estimate_payload_motion(rows["other"], drives, bootstrap=np.random.default_rng(0))
    assert drawn.mass_sd == pytest.approx(formula.mass_sd, rel=0.25)
    assert drawn.mass == pytest.approx(formula.mass, abs=1e-9)


def test_without_a_reference_the_gains_admit_it(arm, rows):
    alone = calibrate_drives(arm, [rows["empty"], rows["again"]])
    assert np.all(alone.gain_sd[1:3] > 0.1 * alone.gain[1:3])
    found = estimate_payload_motion(rows["other"], alone)
    assert found.mass_sd > 0.1 * found.mass
    assert abs(found.mass - 0.6 * MASS) < 3 * found.mass_sd
    assert "inertia not identifiable" in found.verdict


def test_known_gains_do_as_well_as_a_reference(arm, rows):
    given = calibrate_drives(arm, [rows["empty"], rows["again"]], gain=GAIN)
    found = estimate_payload_motion(rows["reference"], given)
    assert abs(found.mass - MASS) < 3 * found.mass_sd < 0.3


def test_torque_sensors_need_no_reference(arm, true_arm):
    empty, loaded = (motion_rows(arm, record(true_arm, 10 + i, p, "torque")) for i, p in enumerate((None, BODY)))
    drives = calibrate_drives(arm, [empty])
    found = estimate_payload_motion(loaded, drives)
    assert abs(found.mass - MASS) < 3 * found.mass_sd < 0.3
    assert np.linalg.eigvalsh(found.covariance).min() > 0
    with pytest.raises(InvalidInput, match="as calibrated"):
        estimate_payload_motion(replace(loaded, effort_kind="current"), drives)


def test_calibration_survives_the_disk(drives, tmp_path):
    drives.save(tmp_path / "drives.json")
    back = Drives.from_file(tmp_path / "drives.json")
    np.testing.assert_array_equal(back.covariance, drives.covariance)
    assert back.robot == drives.robot
    (tmp_path / "bad.json").write_text('{"robot": "x"}')
    with pytest.raises(InvalidInput, match="calibrate"):
        Drives.from_file(tmp_path / "bad.json")


def test_bad_calibrations_are_refused(arm, rows, true_arm):
    with pytest.raises(InvalidInput, match="unloaded"):
        calibrate_drives(arm, [])
    with pytest.raises(InvalidInput, match="mass"):
        calibrate_drives(arm, [rows["empty"]], [rows["reference"]])
    with pytest.raises(InvalidInput, match="mass"):
        calibrate_drives(arm, [rows["empty"]], mass=1.0)
    with pytest.raises(InvalidInput, match="gain"):
        calibrate_drives(arm, [rows["empty"]], gain=[1, 2])
    reversed_sign = replace(rows["empty"], effort=-rows["empty"].effort)
    with pytest.raises(InvalidInput, match="torque_sign"):
        calibrate_drives(arm, [reversed_sign])
    log = record(true_arm, 0)
    with pytest.raises(InvalidInput, match="not degrees"):
        motion_rows(arm, replace(log, q=np.degrees(log.q)))
    with pytest.raises(InvalidInput, match="joints"):
        motion_rows(arm, replace(log, q=log.q[:, :5], dq=log.dq[:, :5], effort=log.effort[:, :5]))


def write(path, log):
    table = np.column_stack([log.time, log.q, log.effort])
    path.write_text("\n".join(",".join(f"{value:.8g}" for value in row) for row in table) + "\n")
    return str(path)


def test_command_line_refuses_in_one_line(tmp_path, capsys, true_arm):
    columns, bad = tmp_path / "map.toml", tmp_path / "bad.toml"
    columns.write_text("[columns]\ntime = 0\nq = [1,2,3,4,5,6]\ncurrent = [7,8,9,10,11,12]\n")
    bad.write_text("time = 0\n")
    short = record(true_arm, 0)
    short = JointLog(short.time[:200], short.q[:200], short.effort[:200], "current")
    log = write(tmp_path / "log.csv", short)
    given = ["--map", str(columns), "--unloaded", log]
    for arguments in (
        ["--robot", "hal", *given],
        ["--robot", "ur5", "--map", str(columns), "--unloaded", str(tmp_path / "none.csv")],
        ["--robot", str(tmp_path / "x.urdf"), *given],
        ["--robot", "gen3", *given],
        ["--robot", "ur5", "--map", str(bad), "--unloaded", log],
        ["--robot", "ur5", *given, "--mass", "2.0"],
        ["--robot", "ur5", *given, "--gain", "a,b"],
        ["--robot", "ur5", *given, "--output", str(tmp_path / "no" / "where.json")],
    ):
        assert main(arguments) == 2, arguments
        captured = capsys.readouterr()
        assert len(captured.err.splitlines()) == 1
        assert captured.err.startswith("calibrate: ")


def test_command_line_calibrates_and_checks(tmp_path, capsys, true_arm):
    columns = tmp_path / "map.toml"
    columns.write_text("[columns]\ntime = 0\nq = [1,2,3,4,5,6]\ncurrent = [7,8,9,10,11,12]\n")
    names = [write(tmp_path / f"{i}.csv", record(true_arm, i, p)) for i, p in enumerate((None, None, BODY))]
    output = tmp_path / "drives.json"
    runs = ["--unloaded", *names[:2], "--reference", names[2], "--mass", str(MASS), "--check", names[2]]
    assert main(["--robot", "ur5", "--map", str(columns), *runs, "--output", str(output)]) == 0
    printed = capsys.readouterr().out
    assert "shoulder_lift_joint" in printed
    low, high = Drives.from_file(output).gain[1:3] * [0.97, 1.03]
    found = float(printed.split("2.csv: ")[1].split(" kg")[0])
    assert found == pytest.approx(MASS, abs=0.1)
    assert low > 0.9 * GAIN[1] * 0.97
    assert high < 1.1 * GAIN[2] * 1.03


UR10E = Path(os.environ.get("PALPATE_DATA", "/nonexistent")) / "ur10e"
COLUMNS = {"time": 0, "q": tuple(range(1, 7)), "dq": tuple(range(7, 13)), "current": tuple(range(13, 19))}


@pytest.mark.skipif(not UR10E.is_dir(), reason="set PALPATE_DATA to the folder that holds ur10e/")
def test_real_logs_of_a_ur10e():
    arm = Arm.from_urdf(UR10E / "ur10e.urdf", "tool0")

    def read(name):
        return JointLog.of(read_log(UR10E / f"{name}.csv", LogMap(COLUMNS), arm))

    names = ["ur-20_02_12-50sec_12harm", "ur-20_02_19_14harm50sec", "ur-20_02_19_14harm50secLoad"]
    first, second, loaded = (motion_rows(arm, read(name)) for name in names)
    drives = calibrate_drives(arm, [first, second], [loaded], 2.805)
    found = estimate_payload_motion(loaded, drives)
    assert found.mass_interval[0] < 2.805 < found.mass_interval[1]
    assert found.mass_sd < 0.1
    for run in (first, second):
        assert abs(estimate_payload_motion(run, drives).mass) < 0.1
    # an unloaded run that the calibration has not seen
    held_out = calibrate_drives(arm, [first], [loaded], 2.805)
    assert abs(estimate_payload_motion(second, held_out).mass) < 0.1
    # half of the loaded run, its gains from the other half
    log = read(names[2])
    half = len(log) // 2
    parts = [
        motion_rows(arm, JointLog(log.time[s], log.q[s], log.effort[s], log.effort_kind, log.dq[s]))
        for s in (slice(half), slice(half, None))
    ]
    other = estimate_payload_motion(parts[1], calibrate_drives(arm, [first, second], parts[:1], 2.805))
    assert other.mass_interval[0] < 2.805 < other.mass_interval[1]
    assert other.mass == pytest.approx(2.805, rel=0.05)
    # without the known mass: the gains rest on the description, and the interval says how little that is worth
    blind = estimate_payload_motion(loaded, calibrate_drives(arm, [first, second]))
    assert blind.mass_interval[0] < 2.805 < blind.mass_interval[1]
    assert blind.mass_sd > 0.2
