"""Datasets: the same whoever makes them, however often they are interrupted."""

import hashlib
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from dynamics.errors import InvalidInput
from estimation.recording import read_recording
from selection.dataset.__main__ import main
from selection.dataset.folder import Dataset
from selection.dataset.one import Setup
from selection.dataset.table import QUANTITIES, row_of, schema, write_table
from tests.selection.dataset.tiny import SETUP, fail, nod, nod_or_die

ROOT = Path(__file__).parents[3]
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}
COUNT = 3


def content(root: Path) -> dict[str, str]:
    """Return what is in every file of a folder, by its name."""
    files = (path for path in root.rglob("*") if path.is_file())
    return {str(path.relative_to(root)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


@pytest.fixture(scope="module")
def by_one(tmp_path_factory):
    root = tmp_path_factory.mktemp("dataset") / "by-one"
    with Dataset.open(root, SETUP) as dataset:
        outcomes = list(dataset.explore(COUNT, workers=1, work=nod))
        assert [outcome.index for outcome in outcomes] == list(range(COUNT))
        assert [outcome.error for outcome in outcomes] == [""] * COUNT
    return root


def test_a_process_killed_at_any_moment_loses_and_repeats_nothing(by_one, tmp_path):
    root = tmp_path / "killed"
    command = [sys.executable, "-m", "tests.selection.dataset.tiny", str(root), str(COUNT)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, cwd=ROOT, env=ENVIRONMENT) as process:
        assert process.stdout is not None
        first = int(process.stdout.readline())
        workers = children(process.pid)
        assert workers
        process.kill()
    deadline = time.monotonic() + 20
    while any(Path(f"/proc/{worker}").exists() for worker in workers):  # they end with what began them
        assert time.monotonic() < deadline
        time.sleep(0.05)
    kept = root / "objects" / f"{first:06d}" / "result.json"
    before = kept.stat()
    with Dataset.open(root, SETUP) as dataset:
        assert not [path for path in (root / "objects").iterdir() if path.name.startswith(".")]
        missing = dataset.missing(COUNT)
        assert first not in missing
        # two workers from here on: neither their number nor the interruption is seen in what is kept
        again = sorted(outcome.index for outcome in dataset.explore(COUNT, workers=2, work=nod))
        assert again == missing
    assert kept.stat().st_mtime_ns == before.st_mtime_ns
    assert content(root) == content(by_one)


def children(pid: int) -> list[int]:
    tasks = Path(f"/proc/{pid}/task").iterdir()
    return [int(child) for task in tasks for child in (task / "children").read_text().split()]


def test_the_table_holds_truth_and_estimates(by_one, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    folders = [by_one / "objects" / f"{index:06d}" for index in range(COUNT)]
    write_table(tmp_path / "a.parquet", map(row_of, folders))
    write_table(tmp_path / "b.parquet", map(row_of, folders))
    assert (tmp_path / "a.parquet").read_bytes() == (tmp_path / "b.parquet").read_bytes()
    table = parquet.read_table(tmp_path / "a.parquet")
    assert table.schema.equals(schema())
    for row, folder in zip(table.to_pylist(), folders, strict=True):
        recording = read_recording(folder)
        last = recording.measurements[-1].measurement
        assert (row["measured_mass_kg"], row["measured_mass_sd_kg"]) == (last.mean, last.sd)
        assert row["steps"] == len(row["actions"]) == len(recording.decisions) - 1
        assert row["failed_steps"] == 0
        assert row["true_density_kg_m3"] == pytest.approx(row["true_mass_kg"] / row["true_volume_m3"])
        posterior = dict(row["material_posterior"])
        assert sum(posterior.values()) == pytest.approx(1)
        assert posterior[row["true_material"]] == row["true_material_probability"]
        assert row["error"] is None


def test_every_column_is_documented():
    pytest.importorskip("pyarrow")
    manual = (ROOT / "docs" / "dataset.md").read_text()
    for name in schema().names:
        kind, _, rest = name.partition("_")
        if kind in ("believed", "measured") and rest.split("_")[0] in QUANTITIES:
            assert f"`{kind}_Q`" in manual
            assert rest.split("_")[0] in manual
        else:
            assert f"`{name}`" in manual


def test_a_bug_in_an_exploration_is_kept_and_the_rest_goes_on(tmp_path):
    with Dataset.open(tmp_path / "d", SETUP) as dataset:
        (outcome,) = dataset.explore(1, workers=1, work=fail)
        assert outcome.error == "ZeroDivisionError: a bug"
        assert dataset.missing(1) == []
        row = row_of(dataset.job(0).folder)
    assert row["error"] == "ZeroDivisionError: a bug"
    assert row["true_mass_kg"] > 0


def test_an_object_on_which_processes_die_is_kept_as_a_failure(tmp_path):
    with Dataset.open(tmp_path / "d", SETUP) as dataset:
        outcomes = {outcome.index: outcome for outcome in dataset.explore(2, workers=2, work=nod_or_die)}
        assert outcomes[0].error == ""
        assert "ended" in outcomes[1].error
        assert "ProcessDied" in row_of(dataset.job(1).folder)["error"]


@pytest.mark.parametrize("other", [Setup(seed=4, noise="none"), Setup(seed=3), Setup(3, "thesis-3.2", "none")])
def test_a_dataset_made_with_something_else_is_left_alone(by_one, other):
    before = content(by_one)
    with pytest.raises(InvalidInput, match="another --out"):
        Dataset.open(by_one, other)
    assert content(by_one) == before


def test_one_process_at_a_time(by_one):
    with Dataset.open(by_one, SETUP), pytest.raises(InvalidInput, match="another process"):
        Dataset.open(by_one, SETUP)


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["--objects", "0"], "--objects"),
        (["--objects", "two"], "--objects"),
        (["--objects", "2", "--seed", "-1"], "--seed"),
        (["--objects", "2", "--workers", "x"], "--workers"),
        (["--objects", "2", "--reference", "nonesuch"], "soft-cubes"),
        (["--objects", "2", "--noise", "loud"], "default"),
        (["--objects", "2", "--poisson", "0.5"], "0.45"),
        (["--objects", "2", "--poisson", "nan"], "0.45"),
        (["--out", "somewhere"], "--objects"),
    ],
)
def test_wrong_arguments_are_refused_in_one_line(capsys, tmp_path, arguments, named):
    out = tmp_path / "out"
    try:
        code = main(["--out", str(out), *arguments])
    except SystemExit as stopped:
        code = stopped.code
    error = capsys.readouterr().err
    assert code == 2
    assert error.count("\n") == 1
    assert named in error
    assert not out.exists()


def test_a_folder_with_something_else_is_left_alone(capsys, tmp_path):
    (tmp_path / "diary.txt").write_text("private")
    assert main(["--objects", "1", "--out", str(tmp_path)]) == 2
    assert "something else" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["diary.txt"]
    assert main(["--objects", "1", "--out", str(tmp_path / "diary.txt")]) == 2


def test_without_pyarrow_it_says_what_to_install(capsys, monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "pyarrow.parquet", None)
    assert main(["--objects", "1", "--out", str(tmp_path / "d")]) == 2
    assert "pip install palpate[parquet]" in capsys.readouterr().err
    assert not (tmp_path / "d").exists()


def test_the_command_explores_and_can_be_interrupted(tmp_path):
    root = tmp_path / "d"
    command = [sys.executable, "-m", "selection.dataset", "--objects", "1", "--out", str(root), "--noise", "none"]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, cwd=ROOT, env=ENVIRONMENT)
    deadline = time.monotonic() + 60
    while not list(root.glob("objects/.0*/run.mcap")):
        assert process.poll() is None
        assert time.monotonic() < deadline
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    error = process.communicate(timeout=20)[1]
    assert process.returncode == 130, error
    assert error.count("\n") == 1
    assert f"--out {root}" in error
    assert list((root / "objects").iterdir()) == []
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, env=ENVIRONMENT, check=True)
    assert "1 of 1 objects" in done.stderr
    assert "1 materials found, 0 of" in done.stdout
    row = row_of(root / "objects" / "000000")
    assert abs(row["measured_mass_kg"] - row["true_mass_kg"]) < 4 * row["measured_mass_sd_kg"]
    assert (root / "dataset.parquet").stat().st_size > 0
