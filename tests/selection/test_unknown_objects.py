"""An object of no listed material is reported as such, kept as a new one on request, and recognised afterwards."""

import json

import pytest

from dynamics.objects import read_declared
from estimation.measurement import Measurement
from estimation.network import Network
from estimation.recording import RunWriter
from selection.arguments import parser
from selection.configuration import configuration
from selection.run import main
from sim.robot import MujocoRobot
from sim.truth import read_truth

PUTTY = """
[declared]
shape = "box"
size_m = [0.056, 0.056, 0.056]
size_sd_m = 0.0005
position_m = [0.5, 0.0]

[truth]
mass_kg = 0.3
young_modulus_pa = 12e3
friction = 0.8
"""


@pytest.fixture
def putty(tmp_path):
    path = tmp_path / "putty.toml"
    path.write_text(PUTTY)
    return path


def interrupted(directory, putty, reference, mass, elasticity):
    """Make a run that was interrupted after weighing and squeezing."""
    given = parser().parse_args(["--object", str(putty), "--reference", str(reference)])
    robot = MujocoRobot(read_truth(putty))
    config = configuration(given, putty, robot)
    with RunWriter.create(directory, config, read_declared(putty).name, robot.arm.joint_names) as run:
        run.decision(0.0, {"choice": "weigh"})
        run.measurement(70.0, "weigh", Measurement("mass", mass, 0.003, "kg"))
        run.measurement(95.0, "squeeze", Measurement("elasticity", elasticity, 600.0, "Pa"))
    return directory


def test_an_unknown_object_is_saved_and_recognised_next_time(tmp_path, putty, capsys):
    first = interrupted(tmp_path / "first", putty, "soft-cubes", 0.298, 11.2e3)
    assert main(["--resume", str(first), "--save-as", "putty"]) == 0
    said = capsys.readouterr().out
    assert "of no listed material" in said
    assert str(first / "reference.json") in said
    assert json.loads((first / "result.json").read_text())["belief"]["material"]["unknown"] > 0.99
    extended = Network.from_file(first / "reference.json")
    assert extended.materials == (*Network.from_file("soft-cubes").materials, "putty")

    second = interrupted(tmp_path / "second", putty, first / "reference.json", 0.302, 12.5e3)
    assert main(["--resume", str(second), "--save-as", "more putty"]) == 0
    assert "most likely putty" in (said := capsys.readouterr().out)
    assert "Nothing was saved" in said
    assert not (second / "reference.json").exists()
    # Of other objects the new material takes little: a known one is still known.
    third = interrupted(tmp_path / "third", putty, first / "reference.json", 0.088, 45e3)
    assert main(["--resume", str(third)]) == 0
    assert "most likely silicone-foam" in capsys.readouterr().out


@pytest.mark.parametrize("name", ["silicone-foam", "unknown", "", " "])
def test_names_that_are_taken_are_refused_before_anything_moves(tmp_path, capsys, name):
    assert main(["--save-as", name, "--out", str(tmp_path / "run")]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert not (tmp_path / "run").exists()


@pytest.mark.slow
def test_the_same_with_a_robot(tmp_path, putty):
    common = ["--object", str(putty), "--quiet", "--out"]
    assert main([*common, str(tmp_path / "first"), "--save-as", "putty"]) == 0
    reference = str(tmp_path / "first" / "reference.json")
    assert main([*common, str(tmp_path / "second"), "--seed", "5", "--reference", reference]) == 0
    found = json.loads((tmp_path / "second" / "result.json").read_text())["belief"]["material"]
    assert max(found, key=found.get) == "putty"
