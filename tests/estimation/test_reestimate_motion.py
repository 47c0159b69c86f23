"""Logs of an arm that moves all the time, by the command line."""

import json
import os
from pathlib import Path

import numpy as np
import pytest

from dynamics.arm import Arm
from estimation.reestimate import main

MASS = 2.0  # kg
MAP = """[columns]
time = 0
q = [1, 2, 3, 4, 5, 6]
dq = [7, 8, 9, 10, 11, 12]
tau = [13, 14, 15, 16, 17, 18]
"""


def write_motion(path: Path, arm: Arm, mass: float, seed: int) -> Path:
    """Write a motion of several harmonics, its torques from the equations of motion, with friction and noise."""
    random = np.random.default_rng(seed)
    time = np.arange(0, 12, 0.01)
    rates = 2 * np.pi * 0.15 * np.arange(1, 4)
    phases, sizes = random.uniform(0, 2 * np.pi, (3, 6)), random.uniform(0.1, 0.3, (3, 6))
    angle = rates[:, None, None] * time[None, :, None] + phases[:, None, :]
    q = np.sum(sizes[:, None, :] * np.sin(angle), axis=0)
    dq = np.sum(sizes[:, None, :] * rates[:, None, None] * np.cos(angle), axis=0)
    ddq = -np.sum(sizes[:, None, :] * rates[:, None, None] ** 2 * np.sin(angle), axis=0)
    body = np.array([mass, 0.0, 0.0, 0.05 * mass, *np.zeros(6)])
    body[[4, 6]] = 0.05**2 * mass  # a point mass on the tool's z axis
    rows = []
    for k in range(len(time)):
        torque = arm.inverse_dynamics(q[k], dq[k], ddq[k], rotors=False)
        torque = torque + arm.payload_regressor(q[k], dq[k], ddq[k]) @ body
        torque += 0.3 * np.sign(dq[k]) + 0.2 * dq[k] + random.normal(0, 0.1, 6)
        rows.append([time[k], *q[k], *dq[k], *torque])
    lines = [",".join(f"{x:.9g}" for x in row) for row in rows]
    lines[77] = lines[77][:50]  # a corrupt line
    path.write_text("\n".join(lines) + "\n")
    return path


def test_a_moving_arm_is_weighed_by_its_drives(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arm = Arm.named("ur5")
    load = write_motion(tmp_path / "load.csv", arm, MASS, 1)
    empty = write_motion(tmp_path / "empty.csv", arm, 0.0, 2)
    (tmp_path / "map.toml").write_text(MAP)
    options = ["--map", str(tmp_path / "map.toml"), "--robot", "ur5", "--json"]
    assert main([str(load), "--tare", str(empty), *options]) == 0
    (report,) = json.loads(capsys.readouterr().out)
    assert report["rejected"]["count"] == 1
    assert "line 78" in report["rejected"]["reasons"][0]
    (mass,) = report["actions"][0]["measurements"]
    assert mass["now"]["mean"] == pytest.approx(MASS, abs=4 * mass["now"]["sd"])
    assert mass["now"]["sd"] < 0.2 * MASS
    assert main([str(load), *options]) == 2
    assert "--tare" in capsys.readouterr().err


UR10E = Path(os.environ.get("PALPATE_DATA", "/nonexistent")) / "ur10e"


@pytest.mark.skipif(not UR10E.is_dir(), reason="set PALPATE_DATA to the folder that holds ur10e/")
def test_a_real_log_of_currents(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """2.805 kg, by drives that other runs and the description of the arm calibrate."""
    (tmp_path / "map.toml").write_text(MAP.replace("tau", "current"))
    empty = [UR10E / f"{name}.csv" for name in ("ur-20_02_12-50sec_12harm", "ur-20_02_19_14harm50sec")]
    tares = [option for log in empty for option in ("--tare", str(log))]
    arguments = [
        "--map",
        str(tmp_path / "map.toml"),
        "--robot",
        str(UR10E / "ur10e.urdf"),
        "--tool-frame",
        "tool0",
    ]
    assert main([str(UR10E / "ur-20_02_19_14harm50secLoad.csv"), *tares, *arguments, "--json"]) == 0
    (report,) = json.loads(capsys.readouterr().out)
    (mass,) = report["actions"][0]["measurements"]
    assert abs(mass["now"]["mean"] - 2.805) < 2 * mass["now"]["sd"]
    assert any("currents" in note for note in report["notes"])
