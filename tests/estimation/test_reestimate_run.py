"""Whole simulated explorations: killed and resumed, and estimated again."""

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from estimation.recording import read_recording
from estimation.reestimate import main
from estimation.reestimation.batch import Request
from estimation.reestimation.report import changes, report_of

pytestmark = pytest.mark.slow


COMMAND = [sys.executable, "-m", "selection.run", "--quiet"]


def test_a_simulated_run_is_reproduced(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    subprocess.run([*COMMAND, "--seed", "4", "--out", str(tmp_path / "run")], check=True, timeout=300)
    assert main([str(tmp_path / "run"), "--json"]) == 0
    (report,) = json.loads(capsys.readouterr().out)
    values = [m for action in report["actions"] for m in action["measurements"]]
    assert len(values) >= 1
    for value in values:
        for key in ("mean", "sd"):
            assert value["now"][key] == pytest.approx(value["recorded"][key], rel=1e-9)
    for variable, probabilities in report["recorded_belief"].items():
        assert report["belief"][variable] == pytest.approx(probabilities, abs=1e-9)


def test_a_killed_run_goes_on_with_the_same_belief(tmp_path: Path) -> None:
    directory = tmp_path / "run"
    with subprocess.Popen([*COMMAND, "--seed", "4", "--out", str(directory)]) as process:
        deadline = time.monotonic() + 300
        while not list(directory.glob("measurements/*.json")):
            assert process.poll() is None
            assert time.monotonic() < deadline
            time.sleep(0.05)
        process.send_signal(signal.SIGKILL)
    killed = read_recording(directory)
    assert not killed.complete
    assert killed.measurements
    subprocess.run([*COMMAND, "--resume", str(directory)], check=True, timeout=300)
    recording = read_recording(directory)
    assert recording.measurements[: len(killed.measurements)] == killed.measurements
    after = recording.beliefs[len(killed.beliefs)]  # the first of the resumed part
    assert after.time > killed.measurements[-1].time
    if len(killed.measurements) == 1 and len(killed.beliefs) == 2:  # the belief after it reached the disk
        assert after.data == killed.beliefs[-1].data
    report = report_of(directory, Request())
    assert changes(report) == 0, report
