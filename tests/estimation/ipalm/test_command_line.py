"""Runs to the database and references from it, by command."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from dynamics.signals import Sample
from estimation.ipalm.__main__ import main
from estimation.measurement import Measurement
from estimation.recording import RunWriter


def make_run(directory: Path, name: str, density: float) -> Path:
    with RunWriter.create(directory, {"arm": "gen3", "gripper": {"name": "2f85"}}, name) as run:
        for k in range(4):
            run.sample(Sample(k / 10, np.ones(7), np.zeros(7), np.zeros(7), 0.05, 0.1))
        run.measurement(0.3, "weigh", Measurement("density", density, 5.0, "kg/m^3"))
        run.belief(0.3, {"belief": {"material": {"foam": 0.7, "wood": 0.3}}})
    return directory


def test_runs_go_to_the_database_and_references_come_from_it(
    database: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("IPALM_USER", "ada")
    monkeypatch.setenv("IPALM_PASSWORD", "lovelace")
    box = ["--outbox", str(tmp_path / "outbox.sqlite")]
    runs = [make_run(tmp_path / f"run{n}", name, 500 + 10 * n) for n, name in enumerate(["cube", "cube", "ball"])]
    (tmp_path / "scene.png").write_bytes(b"\x89PNG\r\n\x1a\n" + b"\0" * 9)
    assert main(["queue", str(runs[2]), "--image", str(tmp_path / "scene.png"), *box]) == 0
    assert main(["queue", *map(str, runs[:2]), *box]) == 0
    assert main(["queue", str(runs[0]), *box]) == 0  # twice
    database.lose = ["after"]
    assert main(["send", "--server", database.url, *box]) == 1
    assert main(["send", "--server", database.url, *box]) == 0
    assert main(["show", *box]) == 0
    assert capsys.readouterr().out.count("stored http") >= 3
    assert len(database.uploads()) == 3
    stored = database.uploads()[0]
    assert [entry["name"] for entry in stored["entries"]] == ["density", "material"]
    assert len(stored["sensor_outputs"]) == 2
    assert database.files == [("measurement png", 17)]
    out = tmp_path / "reference.json"
    assert main(["learn", "--server", database.url, "--class", "cube=foam", "--out", str(out)]) == 0
    classes = json.loads(out.read_text())["properties"]["density"]["classes"]
    assert classes["foam"]["mean"] == pytest.approx(505)
    assert classes["ball"]["mean"] == pytest.approx(520)


def test_wrong_input_is_told_on_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    box = ["--outbox", str(tmp_path / "outbox.sqlite")]
    assert main(["queue", str(tmp_path / "nothing"), *box]) == 2
    assert main(["learn", "--server", "http://127.0.0.1:1", "--out", "x"]) == 1
    assert capsys.readouterr().err.count("\n") == 2
