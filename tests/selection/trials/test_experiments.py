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


@pytest.fixture(scope="module")
def outcome(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("experiments")
    patch = pytest.MonkeyPatch()
    patch.setattr("selection.trials.harder.MOST_AHEAD", 1)
    with patch.context():
        arguments = ["virtual", "--repetitions", "4", "--objects", "8", "--workers", "1", "--quiet"]
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
