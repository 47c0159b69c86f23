"""The index of runs: what is in the folder is found, and what is learned from it is what statistics says."""

import csv
import io
import json
import shutil
import sqlite3
from pathlib import Path

import numpy as np
import pytest

from dynamics.errors import InvalidInput, UnknownName
from dynamics.signals import Sample
from estimation.ipalm import from_list
from estimation.measurement import Measurement
from estimation.recording import RunWriter
from estimation.store import Observation, Store, learn_classes, reference_content
from estimation.store.__main__ import main


def make_run(directory: Path, name: str, mass: float, finish: bool = True) -> None:
    with RunWriter.create(directory, {"seed": 3, "robot": "sim"}, name) as run:
        for k in range(5):
            run.sample(Sample(k / 10, np.zeros(7), np.zeros(7), np.zeros(7), 0.05, 0.1))
        run.measurement(0.4, "weigh", Measurement("mass", mass, 0.001, "kg"))
        run.measurement(0.4, "squeeze", Measurement("elasticity", 1e5 * mass, 10.0, "Pa"))
        run.belief(0.4, {"material": {"foam": 0.9, "wood": 0.1}})
        if finish:
            run.finish({"belief": {"material": {"foam": 0.9, "wood": 0.1}}, "seconds": 12.5})


@pytest.fixture
def runs(tmp_path: Path) -> Path:
    folder = tmp_path / "runs"
    folder.mkdir()
    make_run(folder / "a-cube", "cube", 0.1)
    make_run(folder / "b-ball", "ball", 0.2, finish=False)
    make_run(folder / "c-cube", "cube", 0.11)
    return folder


def test_runs_are_found_and_searched(runs: Path) -> None:
    with Store(runs) as store:
        assert store.refresh() == 3
        assert store.refresh() == 0
        assert [run.name for run in store.runs()] == ["a-cube", "b-ball", "c-cube"]
        assert [run.name for run in store.runs(object_name="cube")] == ["a-cube", "c-cube"]
        assert [run.name for run in store.runs("BALL")] == ["b-ball"]
        assert not store.runs(since="2999")
        cube, ball = store.run("a-cube"), store.run("b-ball")
        assert (cube.state, cube.material, cube.probability, cube.seconds) == ("finished", "foam", 0.9, 12.5)
        assert (ball.state, ball.material, ball.seconds) == ("interrupted", None, pytest.approx(0.4))
        assert cube.config == {"seed": 3, "robot": "sim"}
        assert cube.started[:2] == "20"
        masses = [found.measurement for found in store.measurements(property_name="mass")]
        assert masses == [Measurement("mass", m, 0.001, "kg") for m in (0.1, 0.2, 0.11)]
        with pytest.raises(UnknownName, match="b-ball"):
            store.run("nothing")


def test_the_index_follows_the_folder(runs: Path) -> None:
    with Store(runs) as store:
        store.refresh()
        shutil.rmtree(runs / "a-cube")
        (runs / "c-cube" / "run.mcap").write_bytes(b"damaged beyond reading")
        with RunWriter.resume(runs / "b-ball") as run:
            run.measurement(0.0, "weigh", Measurement("mass", 0.21, 0.001, "kg"))
            run.finish({"seconds": 20.0})
        assert store.refresh() == 3
        states = {run.name: run.state for run in store.runs()}
        assert states == {"b-ball": "finished", "c-cube": "unreadable"}
        assert "MCAP" in store.run("c-cube").problem
        assert len(store.measurements(["b-ball"], "mass")) == 2
        assert not store.measurements(["c-cube"])


def test_a_file_that_is_no_index_is_left_alone(runs: Path) -> None:
    (runs / "store.sqlite").write_bytes(b"a letter to a friend, much longer than a header of a database" * 20)
    with pytest.raises(InvalidInput, match=r"store\.sqlite"):
        Store(runs)
    assert (runs / "store.sqlite").read_bytes().startswith(b"a letter")


def test_an_index_of_another_version_is_refused(runs: Path) -> None:
    with sqlite3.connect(runs / "store.sqlite") as database:
        database.execute("PRAGMA user_version=77")
    database.close()
    with pytest.raises(InvalidInput, match="77"):
        Store(runs)


def test_the_command_line(runs: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(["--runs", str(runs), "list", "cube"]) == 0
    assert "a-cube" in (shown := capsys.readouterr().out)
    assert "b-ball" not in shown
    assert main(["--runs", str(runs), "list", "--json"]) == 0
    assert [run["name"] for run in json.loads(capsys.readouterr().out)] == ["a-cube", "b-ball", "c-cube"]
    assert main(["--runs", str(runs), "show", "a-cube"]) == 0
    assert "foam 0.900" in capsys.readouterr().out
    assert main(["--runs", str(runs), "show", "a-cube", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["measurements"][0]["mean"] == 0.1
    assert main(["--runs", str(runs), "export", "a-cube", "c-cube"]) == 0
    (cube,) = from_list(capsys.readouterr().out).objects
    assert [m.mean for m in cube.measurements if m.property == "mass"] == [0.1, 0.11]
    out = tmp_path / "all.csv"
    assert main(["--runs", str(runs), "export", "--format", "csv", "--property", "mass", "--out", str(out)]) == 0
    rows = list(csv.DictReader(io.StringIO(out.read_text())))
    assert [float(row["mean"]) for row in rows] == [0.1, 0.2, 0.11]


@pytest.mark.parametrize("arguments", [["show", "nothing"], ["learn", "--class", "cube", "--out", "x.json"]])
def test_wrong_arguments_are_one_line(
    runs: Path, arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["--runs", str(runs), *arguments]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert main(["--runs", str(runs / "nowhere"), "list"]) == 2


def test_a_reference_is_learned_from_runs_and_lists(
    runs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    extra = tmp_path / "more.json"
    value = {"mean": 120.0, "sigma": 1.0, "units": "g"}
    extra.write_text(json.dumps([{"object_name": "block", "measurements": [{"name": "mass", "value": value}]}]))
    out = tmp_path / "reference.json"
    arguments = ["learn", "--class", "cube=foam", "--class", "block=foam", "--class", "ball=rubber"]
    assert main(["--runs", str(runs), *arguments, "--also", str(extra), "--out", str(out)]) == 0
    content = json.loads(out.read_text())
    assert content["materials"] == ["foam", "rubber"]
    foam = content["properties"]["mass"]["classes"]["foam"]
    assert foam["mean"] == pytest.approx((0.105 + 0.12) / 2)
    assert "foam mass: 2 objects, 3 readings" in content["source"]
    assert "2 objects, 3 readings" in capsys.readouterr().out


def test_a_class_is_learned_without_bias_and_with_its_spread() -> None:
    """Objects N(10, 2^2), each read three times with sd 1: mean and sd of the class come back."""
    random = np.random.default_rng(5)
    rows = []
    for number in range(4000):
        truth = random.normal(10, 2)
        readings = [Measurement("mass", random.normal(truth, 1), 1.0, "kg") for _ in range(3)]
        rows += [Observation(str(number), "foam", reading) for reading in readings]
    (learned,) = learn_classes(rows)
    assert (learned.objects, learned.readings) == (4000, 12000)
    assert learned.mean == pytest.approx(10, abs=4 * 2.1 / np.sqrt(4000))
    assert learned.sd == pytest.approx(2, abs=4 * 2.1 / np.sqrt(2 * 4000))


def test_one_object_does_not_pretend_to_know_its_class() -> None:
    (learned,) = learn_classes([Observation("a", "foam", Measurement("mass", 1.0, 0.01, "kg"))], spread=0.2)
    assert learned.sd == pytest.approx(np.hypot(0.2, 0.01))


def test_what_can_not_be_learned_is_refused() -> None:
    grams = [Observation("a", "x", Measurement("mass", 1.0, 0.1, unit)) for unit in ("kg", "g")]
    with pytest.raises(InvalidInput, match="unit"):
        learn_classes(grams)
    rows = [
        Observation("a", "x", Measurement("mass", 1, 0.1, "kg")),
        Observation("b", "y", Measurement("width", 1, 0.1, "m")),
    ]
    with pytest.raises(InvalidInput, match="every class"):
        reference_content("r", learn_classes(rows), "")
