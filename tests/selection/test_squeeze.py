"""The command line of the bench: what it prints, keeps and draws, and what it refuses."""

import json
import subprocess
import sys
import xml.etree.ElementTree as ET

import pytest

from estimation.recording import read_recording
from estimation.reestimation import known_of, reestimate
from models import objects
from selection.squeeze import main
from selection.squeeze_presets import CLASSES, PRESETS


def moduli(directory, squeeze=0):
    found = json.loads((directory / "result.json").read_text())["squeezes"][squeeze]["moduli"]
    return {one["name"].split(" at ")[0].split(" to ")[0].split(" 2")[0]: one for one in found}


def test_prints_moduli_next_to_the_truth_and_keeps_everything(tmp_path, capsys):
    out = tmp_path / "run"
    assert main(["--object", "soft-cube", "--depth", "0.006", "--fast", "--out", str(out)]) == 0
    printed = capsys.readouterr().out
    for word in ("Young's modulus", "tangent", "chord", "secant", "largest slope", "hysteresis", "true 45 kPa"):
        assert word in printed, word
    result = json.loads((out / "result.json").read_text())
    assert result["truth"]["properties"]["elasticity"]["value"] == 45e3
    for modulus in result["squeezes"][0]["moduli"]:
        assert modulus["value_pa"] == pytest.approx(45e3, rel=0.02), modulus["name"]
    # Kelvin and Voigt: work tau rate E strain more on the way in and less on the way out.
    tau, rate, strain = 0.002, 0.005 / 0.056, 0.006 / 0.056
    assert result["squeezes"][0]["loss"] == pytest.approx(4 * tau * rate / strain, abs=0.01)


def test_pictures_are_complete(tmp_path):
    out = tmp_path / "run"
    main(["--fast", "--out", str(out), "--quiet", "--speed", "0.01", "0.03"])
    image = (out / "squeeze.png").read_bytes()
    assert image[:8] == b"\x89PNG\r\n\x1a\n"
    assert image[-8:-4] == b"IEND"
    drawing = ET.parse(out / "squeeze.svg").getroot()
    text = (out / "squeeze.svg").read_text()
    for word in ("force [N]", "opening [mm]", "stress [kPa]", "strain [%]", "10 mm/s", "30 mm/s", "true: 45 kPa"):
        assert word in text, word
    assert drawing.tag.endswith("svg")


def test_recordings_are_estimated_again_to_the_same_numbers(tmp_path):
    out = tmp_path / "run"
    given = ["--object", "medium", "--fast", "--noise", "default", "--speed", "0.02", "0.04", "--no-pictures"]
    main([*given, "--out", str(out), "--quiet"])
    recording = read_recording(out)
    assert recording.complete
    assert [mark.name for mark in recording.marks] == ["air", "compress", "dwell", "release"] * 2
    assert len(recording.measurements) == 4
    again = reestimate(recording, known_of(recording.config))
    assert again.notes == ()
    for action in again.actions:
        assert [m.property for m in action.measurements] == ["elasticity", "width"]
        for new, old in zip(action.measurements, action.recorded, strict=True):
            assert (new.mean, new.sd) == pytest.approx((old.mean, old.sd), rel=1e-9)


def test_noise_widens_the_answer_and_the_seed_repeats_it(tmp_path):
    for name, more in {"a": [], "b": [], "c": ["--seed", "1"], "none": ["--noise", "none"]}.items():
        given = ["--fast", "--speed", "0.02", "--no-pictures", "--noise", "default", *more]
        main([*given, "--out", str(tmp_path / name), "--quiet"])
    results = {name: (tmp_path / name / "result.json").read_bytes() for name in ("a", "b", "c")}
    assert results["a"] == results["b"] != results["c"]
    noisy, clean = (moduli(tmp_path / name)["Young's modulus"] for name in ("a", "none"))
    assert noisy["sd_pa"] > 2 * clean["sd_pa"]
    assert abs(noisy["value_pa"] - 45e3) < 3 * noisy["sd_pa"] + 450


def test_a_given_object_replaces_the_named_one(tmp_path):
    out = tmp_path / "run"
    given = ["--young", "2e5", "--mass", "0.2", "--size", "0.05,0.04,0.06", "--plates", "full", "--fast"]
    given += ["--speed", "0.005", "--no-pictures"]
    main([*given, "--out", str(out), "--quiet"])
    result = json.loads((out / "result.json").read_text())
    assert result["truth"]["properties"]["elasticity"]["value"] == 2e5
    assert result["truth"]["properties"]["density"]["value"] == pytest.approx(0.2 / (0.05 * 0.04 * 0.06))
    assert moduli(out)["tangent"]["value_pa"] == pytest.approx(2e5, rel=0.02)
    known = known_of(read_recording(out).config)
    assert known.declared is not None
    assert known.declared.size == (0.05, 0.04, 0.06)


def test_presets_are_the_four_classes_at_both_ends():
    assert len(PRESETS) == 8
    assert {one.object for one in PRESETS.values()} == set(CLASSES) <= set(objects.names())
    assert {one.end for one in PRESETS.values()} == {-0.01, -0.02}


@pytest.mark.parametrize("name", ["very-soft-2cm", "soft-1cm", "medium-2cm", "hard-1cm", "hard-2cm"])
def test_every_preset_gives_the_modulus_of_its_cube(tmp_path, name):
    out = tmp_path / "run"
    main(["--preset", name, "--fast", "--speed", "0.05", "--no-pictures", "--out", str(out), "--quiet"])
    result = json.loads((out / "result.json").read_text())
    true = result["truth"]["properties"]["elasticity"]["value"]
    squeeze = result["squeezes"][0]
    assert squeeze["moduli"][1]["value_pa"] == pytest.approx(true, rel=0.02)  # the tangent
    # The drive's spring law, F = k (x - end), unless the object met the stop at half its width.
    end = PRESETS[name].end
    if squeeze["smallest_opening_m"] > 0.0285:
        force = 1000.0 * (squeeze["smallest_opening_m"] / 2 - end)
        assert squeeze["largest_force_n"] == pytest.approx(force, rel=0.01)


def test_several_speeds_report_how_the_modulus_depends_on_them(tmp_path, capsys):
    out = tmp_path / "run"
    given = ["--fast", "--speed", "0.005", "0.01", "0.02", "--depth", "0.01", "--no-pictures"]
    assert main([*given, "--out", str(out)]) == 0
    assert "strain rate" in capsys.readouterr().out
    rate = json.loads((out / "result.json").read_text())["rate_dependence"]
    # A Kelvin-Voigt block at constant speed is as stiff as one at rest; what is left is the contact's damping,
    # which takes off the contact's give of 2/300 for a while, and the plates' impact.
    assert abs(rate["exponent"]) < 0.03
    assert rate["modulus_pa"] == pytest.approx(45e3, rel=0.02)


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--object", "no-such-thing"], "--object"),
        (["--preset", "no-such-preset"], "--preset"),
        (["--preset", "hard-1cm", "--depth", "0.01"], "--depth"),
        (["--preset", "hard-1cm", "--object", "soft"], "--object"),
        (["--depth", "0.04"], "--depth"),
        (["--depth", "0"], "--depth"),
        (["--depth", "nan"], "--depth"),
        (["--speed", "-1"], "--speed"),
        (["--speed", "5"], "--speed"),
        (["--end", "0.03"], "--end"),
        (["--end", "-0.01", "--depth", "0.01"], "--depth"),
        (["--drive", "100"], "--drive"),
        (["--plates", "spoons"], "--plates"),
        (["--young", "1e20"], "young_modulus_pa"),
        (["--mass", "50"], "mass_kg"),
        (["--size", "0.05,0.05"], "--size"),
        (["--size", "5"], "size_m"),
        (["--noise", "loud"], "--noise"),
        (["--seed", "-1"], "--seed"),
    ],
)
def test_wrong_input_is_refused_in_one_line_before_anything_is_written(
    tmp_path, monkeypatch, capsys, arguments, told
):
    monkeypatch.chdir(tmp_path)
    try:
        code = main(arguments)
    except SystemExit as end:
        code = end.code
    assert code == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert told in error
    assert not list(tmp_path.iterdir())


def test_a_full_directory_is_refused(tmp_path, capsys):
    (tmp_path / "thing").touch()
    assert main(["--fast", "--out", str(tmp_path)]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_list_names_objects_and_presets(capsys):
    assert main(["--list"]) == 0
    listed = capsys.readouterr().out
    assert all(name in listed for name in (*objects.names(), *PRESETS))


def test_a_rigid_body_gives_a_bound_or_a_modulus_far_above(tmp_path, capsys):
    out = tmp_path / "run"
    main(["--young", "1e9", "--noise", "default", "--fast", "--no-pictures", "--out", str(out)])
    squeeze = json.loads((out / "result.json").read_text())["squeezes"][0]
    assert squeeze["largest_force_n"] < 130  # the drive's limit, and the noise of the current
    assert (squeeze.get("bound_pa") or 0) > 1e6 or squeeze["note"]


def test_help_is_quick_and_imports_no_simulator():
    code = "import sys; from selection.squeeze import main\ntry: main(['--help'])\nexcept SystemExit: pass\n"
    code += "assert not {'mujoco', 'gtsam', 'matplotlib', 'scipy', 'pinocchio'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True, stdout=subprocess.DEVNULL)
