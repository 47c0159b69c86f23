"""The command line of the experiments."""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from pathlib import Path

import pytest

from selection import experiments
from selection.trials import studies
from selection.trials.output import write
from selection.trials.result_tables import LearningCurve, ResultTable


@pytest.fixture(scope="module")
def outcome(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("experiments")
    patch = pytest.MonkeyPatch()
    patch.setattr("selection.trials.harder.MOST_AHEAD", 1)
    with patch.context():
        arguments = ["virtual", "--repetitions", "4", "--objects", "8", "--workers", "1", "--quiet", "--no-page"]
        assert experiments.main([*arguments, "--out", str(folder), "--json", str(folder / "all.json")]) == 0
        first = (folder / "all.json").read_text()
        assert experiments.main([*arguments, "--out", str(folder), "--json", str(folder / "all.json")]) == 0
    assert (folder / "all.json").read_text() == first  # from the chunks on disk
    patch.undo()
    return folder


def test_every_cell_with_counts(outcome: Path) -> None:
    content = json.loads((outcome / "all.json").read_text())
    cells = content["cells"]
    assert len(cells) == 6 * 10
    for cell in cells:
        assert sum(cell[key] for key in ("correct", "weak", "diverged", "undecided")) == cell["trials"] == 4
        assert 0 <= cell["low"] <= cell["rate"] <= cell["high"] <= 1
        assert bool(cell["thesis"]) == cell["policy"].startswith("thesis mode")


def test_tables_and_curves_as_csv(outcome: Path) -> None:
    names = {path.stem for path in outcome.glob("*.csv")}
    assert {"virtual-mode-1", "virtual-others", "harder-costs", "first-actions-4-10", "accuracy-4-11"} <= names
    with (outcome / "virtual-mode-2.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["thesis C/W/D"] for row in rows] == ["5/0/0", "5/0/0", "5/0/0", "5/0/0", "4/0/1", "5/0/0"]


def test_another_seed_does_not_go_on_there(outcome: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert experiments.main(["virtual", "--seed", "1", "--out", str(outcome), "--quiet"]) == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 1


@pytest.mark.parametrize(
    "arguments",
    [["real"], [], ["virtual", "--repetitions", "0"], ["virtual", "--seed", "-1"], ["all", "--jobs", "2"]],
)
def test_wrong_input_is_said_on_one_line(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        experiments.main(arguments)
    assert ended.value.code == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 1


def test_help_loads_nothing_heavy() -> None:
    code = "import sys; from selection.experiments import main\ntry: main(['--help'])\nexcept SystemExit: pass\n"
    code += "assert not {'numpy', 'mujoco', 'gtsam', 'rich'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)


def test_default_repetitions() -> None:
    request = studies.Request(Path("x"))
    assert request.trials("virtual") == 400
    assert request.trials("simulation") == 20


def test_the_page_and_the_json_of_an_outcome(tmp_path: Path) -> None:
    table = ResultTable("t", "A table", "A note.", ("policy", "rate", "low", "high"), (("random", 0.5, 0.4, 0.6),))
    curve = LearningCurve(
        "f", "A plot", "random", "actions", "accuracy", (0.0, 1.0), (0.2, 0.5), (0.1, 0.4), (0.3, 0.6)
    )
    outcome = studies.Outcome((), (table,), (curve,), ("It was found.",), (("seed", "0"),))
    write(outcome, tmp_path, tmp_path / "all.json")
    assert "It was found." in (tmp_path / "report.html").read_text()
    assert (tmp_path / "f.csv").read_text().splitlines()[1] == "random,0.0,0.2,0.1,0.3"
    assert json.loads((tmp_path / "all.json").read_text())["curves"][0]["y"] == [0.2, 0.5]


def test_outcomes_add_up() -> None:
    one, other = studies.Outcome(found=("a",)), studies.Outcome(found=("b",), settings=(("seed", "1"),))
    assert (one + other).found == ("a", "b")
    assert (one + other).settings == (("seed", "1"),)
