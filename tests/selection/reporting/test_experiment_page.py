"""The page of an experiment."""

import json
import math

import pytest

from dynamics.errors import InvalidInput
from selection.report import main
from selection.reporting import write_experiment_report, write_report
from selection.reporting.curve_figures import intervals, intervals_of, learning_curves, styles
from selection.trials.result_tables import LearningCurve, ResultTable
from tests.selection.reporting.test_run_page import HOSTILE, checked

TABLE = ResultTable(
    "virtual-proper",
    "Proper measurements",
    "Table 4.1 is reproduced but for mode 1.",
    ("policy", "prior", "C/W/D/U", "rate of C", "low", "high", "thesis C/W/D"),
    (
        ("mode 1", "correct", "3/1/0/0", 0.75, 0.3, 0.95, "4/0/1"),
        ("mode 1", "uniform", "0/4/0/0", 0.0, 0.0, 0.49, ""),
        ("mode 2", "correct", "4/0/0/0", 1.0, 0.51, 1.0, "5/0/0"),
    ),
)


def curve(label, figure="accuracy", x=(0.0, 1.0, 2.0), y=(0.1, 0.5, 0.9)):
    low, high = tuple(v - 0.05 for v in y), tuple(v + 0.05 for v in y)
    return LearningCurve(figure, figure.title(), label, "Actions", "Share", x, y, low, high)


def test_tables_and_curves_are_on_the_page_and_beside_it(tmp_path):
    path = write_experiment_report(
        tmp_path / "e",
        [TABLE],
        [curve("exact"), curve("random"), curve("exact", "calibration", (0.1, 0.9), (0.2, 0.8))],
        title="The experiments",
        lead="It works.",
        facts=[("Seed", "3")],
        references=["thesis-3.1-erratum"],
    )
    page = checked(path)
    for words in ("The experiments", "It works.", TABLE.title, TABLE.note, "0.75", "Seed"):
        assert words in page.text
    assert "perfectly calibrated" in page.text
    assert (path.parent / "tables" / "virtual-proper.csv").read_text() == TABLE.csv()
    drawn = {file.stem for file in (path.parent / "figures").iterdir()}
    assert {"accuracy", "calibration", "virtual-proper-rate-of-c"} < drawn
    assert sum(name.startswith("reference-") for name in drawn) == 2


def test_a_page_is_made_again_from_what_is_on_disk(tmp_path):
    first = write_experiment_report(tmp_path / "e", [TABLE], [curve("exact")])
    again = tmp_path / "again" / "page.html"
    assert main([str(tmp_path / "e"), "--out", str(again)]) == 0
    assert again.read_bytes() == first.read_bytes()


def test_numbers_that_are_none_do_not_spoil_the_page(tmp_path):
    table = ResultTable("t", "T", "", ("a", "b"), (("x", math.nan), ("y", math.inf), ("z", None)))
    page = checked(
        write_experiment_report(
            tmp_path, [table], [curve("exact", y=(math.nan, 0.5, 0.9)), curve("lost", x=(), y=())]
        )
    )
    assert "nan" not in page.text.lower().replace("unan", "")


def test_hostile_names_are_only_text(tmp_path):
    table = ResultTable("../" + HOSTILE, HOSTILE, HOSTILE, (HOSTILE,), ((HOSTILE,),))
    hostile = LearningCurve("../" + HOSTILE, *([HOSTILE] * 4), (0.0, 1.0), (0.0, 1.0), (0.0, 1.0), (0.0, 1.0))
    page = checked(write_experiment_report(tmp_path / "e", [table], [hostile], title=HOSTILE, lead=HOSTILE))
    assert "<script>alert(1)</script>" in page.text
    assert {p.name for p in tmp_path.iterdir()} == {"e"}
    assert {p.name for p in (tmp_path / "e").iterdir()} == {"report.html", "report.json", "figures", "tables"}


def test_an_experiment_without_results_has_a_page(tmp_path):
    checked(write_experiment_report(tmp_path, [], []))


@pytest.mark.parametrize("content", ["", "{}", "[]", '{"format": "palpate-experiment/1"}', '{"format": "other"}'])
def test_a_damaged_experiment_is_refused(tmp_path, content, capsys):
    (tmp_path / "report.json").write_text(content)
    assert main([str(tmp_path)]) == 2
    assert str(tmp_path / "report.json") in capsys.readouterr().err


def test_a_row_of_wrong_length_is_refused(tmp_path):
    path = write_experiment_report(tmp_path, [TABLE], [])
    content = json.loads((path.parent / "report.json").read_text())
    content["tables"][0]["rows"][0].pop()
    (path.parent / "report.json").write_text(json.dumps(content))
    with pytest.raises(InvalidInput):
        write_report(tmp_path)


def test_rates_are_read_off_a_table():
    found = intervals_of(TABLE)
    assert found.kind == "rate of C"
    assert found.are_rates
    assert [(row.group, row.label, row.value) for row in found.rows] == [
        ("mode 1", "correct", 0.75),
        ("mode 1", "uniform", 0.0),
        ("mode 2", "correct", 1.0),
    ]
    assert [row.thesis for row in found.rows] == [0.8, None, 1.0]
    assert intervals_of(ResultTable("t", "T", "", ("rate", "low"), ((0.5, 0.4),))) is None


def test_other_figures_with_intervals_are_drawn_on_an_axis_of_their_own():
    rows = (("exact", 3.4, 3.0, 3.8), ("random", 5.1, 4.9, 5.3), ("lost", None, None, None))
    found = intervals_of(ResultTable("t", "T", "", ("policy", "actions to be sure", "low", "high"), rows))
    assert not found.are_rates
    assert [row.label for row in found.rows] == ["exact", "random"]
    figure = intervals("t", found)
    assert "exact 3.40 and random 5.10" in figure.alt
    assert "Actions to be sure" in figure.inline


def test_plots_of_one_world_stand_together(tmp_path):
    def of(world, name):
        return LearningCurve(
            f"{world}-{name}", f"{world}: {name}", "exact", "a", "b", (0.0,), (1.0,), (1.0,), (1.0,)
        )

    curves = [of("easy", "accuracy"), of("hard", "accuracy"), of("easy", "score")]
    page = checked(write_experiment_report(tmp_path, [], curves))
    order = [page.text.index(word) for word in ("Easy", "Accuracy against a", "Score against a", "Hard")]
    assert order == sorted(order)


def test_a_policy_looks_the_same_in_every_plot():
    labels = [f"policy {i}" for i in range(12)]
    style = styles(labels + labels[::-1])
    assert len(set(map(str, style.values()))) == 12
    assert styles(labels[:3])["policy 2"] == style["policy 2"]


def test_a_curve_says_its_end():
    figure = learning_curves([curve("exact")], styles(["exact"]))
    assert "exact ends at 0.900" in figure.alt
