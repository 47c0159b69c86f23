"""The command line: what it promises to people and to other programs."""

import json
import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from estimation.recording import read_recording
from models import objects
from selection.run import main

GOOD_OBJECT = (objects.FOLDER / "soft-cube.toml").read_text()


def refused(capsys, *arguments: str) -> str:
    """Run with wrong arguments and return the one line that says so."""
    try:
        code = main(list(arguments))
    except SystemExit as stopped:
        code = stopped.code
    out, err = capsys.readouterr()
    assert code == 2
    assert out == ""
    assert err.count("\n") == 1, err
    assert "Traceback" not in err
    return err


def test_result_has_the_promised_form(default_result):
    assert set(default_result) == {
        "object", "truth", "belief", "properties", "actions", "stopped_because", "seconds", "versions",
    }  # fmt: skip
    material = default_result["belief"]["material"]
    assert sum(material.values()) == pytest.approx(1, abs=1e-9)
    for value in default_result["properties"].values():
        assert set(value) >= {"mean", "sd", "unit"}
        assert math.isfinite(value["mean"])
        assert value["sd"] > 0
    for action in default_result["actions"]:
        assert set(action) >= {"action", "scores", "measurements", "seconds", "ok"}
        assert action["action"] in action["scores"]
        assert all(bits >= 0 for bits in action["scores"].values())
    total = sum(action["seconds"] for action in default_result["actions"])
    assert default_result["seconds"] == pytest.approx(total, abs=1e-3)
    assert default_result["stopped_because"]


def test_default_run_uses_both_actions_and_is_right(default_result):
    assert {action["action"] for action in default_result["actions"]} == {"weigh", "squeeze"}
    assert all(action["ok"] for action in default_result["actions"])
    material = default_result["belief"]["material"]
    assert max(material, key=material.get) == default_result["truth"]["material"]
    truth = default_result["truth"]["properties"]
    for name in ("mass", "elasticity", "volume"):
        found = default_result["properties"][name]
        assert abs(found["mean"] - truth[name]["value"]) < 4 * found["sd"]
    mass = default_result["properties"]["mass"]["mean"]
    assert abs(mass - truth["mass"]["value"]) < max(0.005, 0.02 * truth["mass"]["value"])


def test_run_directory_is_complete(default_run, default_result):
    assert {path.name for path in default_run.iterdir()} >= {
        "run.mcap",
        "config.toml",
        "result.json",
        "measurements",
    }
    recording = read_recording(default_run)
    taken = [m for action in default_result["actions"] for m in action["measurements"]]
    assert [(r.measurement.property, r.measurement.mean) for r in recording.measurements] == [
        (m["property"], m["mean"]) for m in taken
    ]
    assert len(recording.decisions) == len(default_result["actions"]) + 1
    assert {mark.name for mark in recording.marks} >= {"tare", "hold", "air", "grasp", "compress", "release"}
    assert len(recording.samples.time) > 100 * 60  # 100 Hz over more than a minute


def test_help_names_every_option(capsys):
    with pytest.raises(SystemExit) as stopped:
        main(["--help"])
    assert stopped.value.code == 0
    out = capsys.readouterr().out
    options = (
        "object",
        "reference",
        "prior",
        "seed",
        "out",
        "noise",
        "confidence",
        "budget",
        "robot",
        "list",
        "quiet",
    )
    assert all(f"--{option}" in out for option in options)


def test_list_shows_objects_and_references(capsys):
    assert main(["--list"]) == 0
    out = capsys.readouterr().out
    for name in ("soft-cube", "black-cube", "white-cube", "yellow-sponge", "very-soft", "soft", "medium", "hard"):
        assert name in out
    assert "soft-cubes" in out


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["--object", "nonesuch"], "yellow-sponge"),
        (["--object", "missing.toml"], "missing.toml"),
        (["--reference", "nonesuch"], "soft-cubes"),
        (["--reference", "missing.json"], "missing.json"),
        (["--robot", "toaster"], "sim"),
        (["--noise", "loud"], "default"),
        (["--noise", "missing.toml"], "missing.toml"),
        (["--prior", "granite=0.5"], "sponge"),
        (["--prior", "sponge"], "NAME=P"),
        (["--prior", "sponge=2"], "between 0 and 1"),
        (["--prior", "sponge=0.1,sponge=0.2"], "twice"),
        (["--reference", "/"], "readable"),
        (["--reference", "/dev/zero"], "bytes"),
        (["--object", "/dev/zero"], "TOML"),
        (["--prior", "sponge=x"], "between 0 and 1"),
        (["--prior", "sponge=0.7,gel=0.7"], "at most 1"),
        (["--confidence", "1.5"], "probability"),
        (["--confidence", "nan"], "finite"),
        (["--budget", "-3"], "negative"),
        (["--target", "colour"], "density"),
        (["--lookahead", "maybe"], "never"),
        (["--vision", "missing.json"], "missing.json"),
        (["--seed", "x"], "--seed"),
        (["--seed", "-1"], "seed"),
        (["--frobnicate"], "--frobnicate"),
        (["--resume", "nowhere"], "config.toml"),
    ],
)
def test_wrong_arguments(capsys, tmp_path, arguments, named):
    out = tmp_path / "out"
    assert named in refused(capsys, *arguments, "--out", str(out))
    assert not out.exists()


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        ("mass_kg = 0.088", "mass_kg = -0.1", "mass_kg"),
        ("mass_kg = 0.088", "mass_kg = nan", "mass_kg"),
        ("mass_kg = 0.088", "mass_kg = 'heavy'", "mass_kg"),
        ("mass_kg = 0.088", "masskg = 0.1", "mass_kg"),
        ("friction = 0.8", "friction = 0.8\ncolour = 'red'", "colour"),
        ("young_modulus_pa = 45e3", "young_modulus_pa = inf", "young_modulus_pa"),
        ("size_m = [0.056, 0.056, 0.056]", "size_m = [0.09, 0.09, 0.056]", "size_m"),
        ("size_m = [0.056, 0.056, 0.056]", "size_m = [0.056, 0.056]", "size_m"),
        ("position_m = [0.5, 0.0]", "position_m = [0.7, 0.4]", "out of reach"),
        ("position_m = [0.5, 0.0]", "position_m = [-0.5, 0.0]", "on the table"),
        ("[declared]", "[declared", "TOML"),
        ("[truth]", "[other]", "other"),
    ],
)
def test_malformed_object(capsys, tmp_path, old, new, named):
    assert old in GOOD_OBJECT
    path = tmp_path / "object.toml"
    path.write_text(GOOD_OBJECT.replace(old, new))
    assert named in refused(capsys, "--object", str(path), "--out", str(tmp_path / "out"))
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "content", [b"", b"\x00\xff\xfe binary", b"{}", b"[1, 2]", b'{"materials": "x"}', b"{" * 100_000]
)
def test_malformed_reference(capsys, tmp_path, content):
    path = tmp_path / "reference.json"
    path.write_bytes(content)
    assert "reference.json" in refused(capsys, "--reference", str(path), "--out", str(tmp_path / "out"))
    assert not (tmp_path / "out").exists()


def test_existing_directory_is_left_alone(capsys, default_run):
    before = (default_run / "result.json").read_bytes()
    assert "default" in refused(capsys, "--out", str(default_run))
    assert (default_run / "result.json").read_bytes() == before


def test_budget_and_prior_are_kept_to_and_a_seed_gives_the_same_bytes(tmp_path):
    arguments = ["--budget", "35", "--prior", "gel=0.6", "--quiet"]
    outs = tmp_path / "first", tmp_path / "again"
    for out in outs:
        assert main([*arguments, "--out", str(out)]) == 0
    first, again = ((out / "result.json").read_bytes() for out in outs)
    assert first == again
    result = json.loads(first)
    assert result["seconds"] <= 35
    assert [action["action"] for action in result["actions"]] == ["squeeze"]  # weighing takes longer


def test_interrupted_run_is_resumed(default_result, tmp_path):
    out = tmp_path / "run"
    command = [sys.executable, "-m", "selection.run", "--out", str(out), "--quiet"]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, cwd=Path(__file__).parents[2], env={**os.environ})
    measured = out / "measurements" / "001-mass.json"
    deadline = time.monotonic() + 120
    while not measured.exists():
        assert process.poll() is None
        assert time.monotonic() < deadline
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    error = process.communicate(timeout=30)[1].decode()
    assert process.returncode == 130
    assert error.count("\n") == 1
    assert not (out / "result.json").exists()
    assert main(["--resume", str(out), "--quiet"]) == 0
    result = json.loads((out / "result.json").read_text())
    assert [action["action"] for action in result["actions"]] == ["squeeze"]
    # The mass was not measured anew: it is believed as in the run that was not interrupted.
    assert result["properties"]["mass"]["mean"] == pytest.approx(
        default_result["properties"]["mass"]["mean"], rel=0.02
    )
