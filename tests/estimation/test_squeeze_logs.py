import json
import math
import os
from pathlib import Path

import numpy as np
import pytest

from estimation.squeeze_logs import estimate_files, main, series_stiffness_of

DATA = os.environ.get("PALPATE_DATA")


def write(path, stiffness, contact=0.056, seed=0, noise=0.1):
    """Squeeze a block between two plates."""
    rng = np.random.default_rng(seed)
    opening = np.linspace(contact + 0.006, contact - 0.012, 80)
    force = stiffness * np.maximum(contact - opening, 0.0) + noise * rng.standard_normal(80)
    rows = "\n".join(f"{f:.6g},{x:.7g}" for f, x in zip(force, opening, strict=True))
    path.write_text(f"force_N,opening_m\n{rows}\n")
    return path


def test_repeats_are_one_object(tmp_path, capsys):
    for k in (1, 2):
        write(tmp_path / f"soft_{k}.csv", 500.0, seed=k)
        write(tmp_path / f"hard_{k}.csv", 2000.0, seed=10 + k)
    assert main([str(tmp_path), "--shape", "box", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["objects"]
    assert sorted(found) == ["hard", "soft"]
    assert found["hard"]["young_modulus"] / found["soft"]["young_modulus"] == pytest.approx(4.0, rel=0.03)
    assert len(found["soft"]["repeats"]) == 2
    assert main([str(tmp_path)]) == 0
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()] == ["soft", "hard"]


def test_a_rigid_block_calibrates_and_is_a_bound_itself(tmp_path, capsys):
    rigid = [str(write(tmp_path / f"steel_{k}.csv", 3000.0, seed=k)) for k in (1, 2)]
    # 1000 N/m in series with the gripper's 3000 N/m
    soft = str(write(tmp_path / "foam_1.csv", 750.0, seed=5))
    assert main([*rigid, soft, "--shape", "box", "--json", "--rigid", *rigid]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["series_stiffness"] == pytest.approx(3000.0, rel=0.02)
    assert found["objects"]["steel"]["bound"] is not None
    assert found["objects"]["steel"]["young_modulus"] is None
    alone = estimate_files("foam", [Path(soft)], "box", 0.056, 0.45, (math.inf, 0.0)).fused.young_modulus
    assert found["objects"]["foam"]["young_modulus"] == pytest.approx(alone * 4 / 3, rel=0.06)


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("a,b\n1,2\n", "force_N"),
        ("force_N,opening_m\n1,x\n", "numbers"),
        ("force_N,opening_m\n1,50\n2,49\n", "metres"),
    ],
)
def test_what_cannot_be_read_is_said_in_one_line(tmp_path, capsys, text, word):
    path = tmp_path / "log.csv"
    path.write_text(text)
    assert main([str(path)]) == 2
    error = capsys.readouterr().err
    assert word in error
    assert error.count("\n") == 1


def test_no_files_is_an_error(tmp_path, capsys):
    assert main([str(tmp_path)]) == 2
    assert main([str(tmp_path / "gone.csv")]) == 2
    assert capsys.readouterr().err.count("\n") == 2


@pytest.mark.skipif(not DATA, reason="PALPATE_DATA does not name a folder with squeeze/*.csv")
def test_real_squeezes_come_out_in_the_known_order():
    folder = Path(DATA or "") / "squeeze"

    def repeats(name, series):
        shape = "box" if "brick" in name else "sphere"
        return estimate_files(name, sorted(folder.glob(f"{name}_*.csv")), shape, None, 0.45, series)

    rigid = (math.inf, 0.0)
    names = ("foam_brick", "orange_ball_softest", "green_ball_softer", "purple_ball_hardest")
    found = [repeats(name, rigid) for name in names]
    moduli = [f.fused.young_modulus for f in found]
    assert moduli == sorted(moduli)
    for f in found:
        for one in f.estimates:
            for other in f.estimates:
                assert one.interval[0] < other.interval[1], f.name
    golf = repeats("golf_ball", series_stiffness_of(sorted(folder.glob("golf_ball_*.csv"))))
    assert all(e.bound is not None for e in golf.estimates)
    assert golf.fused.bound is not None
    assert golf.fused.bound > moduli[-1]
