"""The page of a run: complete, well-formed, of its own, and true to the run, whatever the run was like."""

import csv
import json
import re
import shutil
import tomllib
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from dynamics.signals import Sample
from estimation.measurement import Measurement
from estimation.observation import Observation
from estimation.recording import RunWriter, read_recording
from selection.report import main
from selection.reporting import write_run_report
from selection.run import main as explore

HOSTILE = "<script>alert(1)</script>\"'&amp;</style> $x_{1}$ \u202eevil\x07 https://evil.example/a.png"
ADDRESSES = re.compile(r"https?://|//[a-z]|@import|javascript:|url\((?!#)", re.I)


class Page(HTMLParser):
    """Gathers what a page consists of, as browsers take it apart."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.attributes, self.words, self.open = [], [], [], []
        self.feed(text)
        self.close()
        assert self.open == []
        self.text = " ".join(" ".join(self.words).replace("\u00a0", " ").split())

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        self.attributes.append((tag, dict(attributes)))
        self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.tags.append(tag)
        self.attributes.append((tag, dict(attributes)))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if "style" not in self.open:
            self.words.append(data)


def checked(path):
    """Read a page, and check what holds for every page."""
    text = path.read_text(encoding="utf-8")
    page = Page(text)
    ElementTree.fromstring(text)
    assert not {"script", "iframe", "object", "embed", "link", "base", "form", "animate", "set"} & set(page.tags)
    identifiers = [a["id"] for _, a in page.attributes if "id" in a]
    assert len(identifiers) == len(set(identifiers))
    for tag, attributes in page.attributes:
        assert not any(key.startswith("on") for key in attributes), attributes
        if "src" in attributes:
            assert attributes["src"].startswith("data:image/jpeg;base64,")
        if "href" in attributes:
            assert attributes["href"][0] == "#"
            assert attributes["href"][1:] in identifiers
        if tag == "svg":
            assert attributes["role"] == "img"
            assert len(attributes["aria-label"]) > 20
        if tag == "th":
            assert attributes["scope"] in ("row", "col")
        style = attributes.get("style", "") + attributes.get("fill", "") + attributes.get("stroke", "")
        assert not ADDRESSES.search(style)
        assert not re.search(r"#[0-9a-f]{6}\b", style), "a colour that does not follow the theme"
    styles = "".join(re.findall(r"<style>.*?</style>", text, re.S))
    assert not ADDRESSES.search(styles)
    assert page.tags.count("h1") == 1
    for folder, kind in (("figures", "*.svg"), ("tables", "*.csv")):
        for file in (path.parent / folder).glob(kind):
            assert file.stat().st_size > 0
            if kind == "*.svg":
                ElementTree.parse(file)
    assert len(text) < 3_000_000
    return page


def files_of(directory):
    return {p.relative_to(directory): p.read_bytes() for p in sorted(directory.rglob("*")) if p.is_file()}


def copied(run, place, without=("report.html", "figures", "tables")):
    shutil.copytree(run, place, ignore=shutil.ignore_patterns(*without))
    return place


def test_a_run_leaves_its_page(default_run, default_result):
    page = checked(default_run / "report.html")
    material = default_result["belief"]["material"]
    best = max(material, key=material.get)
    assert f"{best} (P = {100 * material[best]:.1f} %)" in page.text
    mass = default_result["actions"][0]["measurements"][0]
    assert mass["property"] == "mass"
    assert f"{1e3 * mass['mean']:.1f} ± {1e3 * mass['sd']:.1f} g" in page.text
    for score in default_result["actions"][0]["scores"].values():
        assert f"{score:.3f}" in page.text
    assert "nothing more was worth its time" in page.text
    assert "The simulated object is indeed made of it." in page.text


def test_every_figure_of_the_story_is_there_as_a_file_too(default_run):
    page = checked(default_run / "report.html")
    drawn = {file.stem for file in (default_run / "figures").iterdir()}
    assert drawn >= {
        "course-of-material", "how-well-known", "step-1-gains", "step-1-material", "step-1-mass", "step-1-torques",
        "step-2-gains", "step-2-stress-strain", "step-2-gripper", "step-2-elasticity", "step-3-gains",
    }  # fmt: skip
    assert page.tags.count("svg") == len(drawn)


def test_tables_hold_the_values_in_full(default_run, default_result):
    with open(default_run / "tables" / "measurements.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    taken = [m for action in default_result["actions"] for m in action["measurements"]]
    assert [(r["quantity"], float(r["mean"]), float(r["sd"])) for r in rows] == [
        (m["property"], m["mean"], m["sd"]) for m in taken
    ]
    with open(default_run / "tables" / "beliefs-of-material.csv", newline="") as file:
        beliefs = list(csv.reader(file))
    assert {row[0]: float(row[-1]) for row in beliefs[1:]} == default_result["belief"]["material"]


def test_the_same_run_gives_the_same_bytes_anywhere(default_run, tmp_path):
    again = copied(default_run, tmp_path / "elsewhere" / "again")
    assert write_run_report(again) == again / "report.html"
    assert files_of(again) == files_of(default_run)


@pytest.mark.parametrize("share", [0.02, 0.15, 0.4, 0.7, 0.85, 0.99])
def test_a_run_cut_off_anywhere_has_a_page(default_run, tmp_path, share):
    cut = copied(default_run, tmp_path / "cut", ("report.html", "figures", "tables", "result.json"))
    stream = cut / "run.mcap"
    whole = stream.read_bytes()
    stream.write_bytes(whole[: int(share * len(whole))])
    page = checked(write_run_report(cut))
    if share < 0.95:  # beyond, even the reason to stop was recorded
        assert "broken off" in page.text or "no conclusion" in page.text
    assert "There is no result" in page.text


def test_a_run_that_had_just_begun_has_a_page(tmp_path):
    RunWriter.create(tmp_path / "run", {"seed": 1}, "thing").close()
    page = checked(write_run_report(tmp_path / "run"))
    assert "there is no conclusion" in page.text


def sample(time):
    return Sample(time, np.zeros(7), np.zeros(7), np.zeros(7), 0.05, 0.1)


def told(best, rest):
    return {
        "belief": {"material": {best: 0.7, rest: 0.3}},
        "properties": {best: {"mean": 2.0, "sd": 1.0, "unit": rest}},
    }


def hostile_run(directory, result=True):
    """Write a run all of whose names are meant to break a page."""
    config = {"object": HOSTILE, "object_file": HOSTILE, "reference": HOSTILE, HOSTILE: {HOSTILE: HOSTILE}}
    with RunWriter.create(directory, config, HOSTILE, [f"joint_{i}" for i in range(7)]) as run:
        run.belief(0.0, told(HOSTILE, "b"))
        score = {"bits": 1.0, "seconds": 2.0, "value": 0.5, "feasible": True, "reason": ""}
        refused = score | {"feasible": False, "reason": HOSTILE}
        run.decision(
            0.0,
            {"target": "material", "price": 0.1, "choice": HOSTILE, "actions": {HOSTILE: score, "b": refused}},
        )
        for i in range(20):
            run.sample(sample(0.1 * i))
        run.measurement(2.0, HOSTILE, Measurement(HOSTILE, 1.0, 0.1, HOSTILE))
        run.belief(2.0, told("b", HOSTILE))
        run.decision(2.0, {"target": HOSTILE, "price": 0.1, "choice": None, "stop": HOSTILE, "actions": {}})
        if result:
            actions = [{"action": HOSTILE, "notes": [HOSTILE], "seconds": 2.0, "ok": True}]
            truth = {"material": HOSTILE, "properties": {HOSTILE: {"value": 1.5, "unit": HOSTILE}}}
            run.finish(told("b", HOSTILE) | {"actions": actions, "truth": truth, "versions": {HOSTILE: HOSTILE}})
    return directory


@pytest.mark.parametrize("result", [True, False])
def test_hostile_names_are_only_text(tmp_path, result):
    page = checked(write_run_report(hostile_run(tmp_path / "run", result)))
    assert "<script>alert(1)</script>" in page.text
    assert "\u202e" not in page.text
    inside = {p.resolve() for p in tmp_path.rglob("*")}
    assert all(tmp_path.resolve() in p.parents for p in inside)


def test_an_action_that_failed_is_told_with_its_reason(default_run, tmp_path):
    failed = copied(default_run, tmp_path / "failed")
    result = json.loads((failed / "result.json").read_text())
    result["actions"][1] |= {"ok": False, "notes": ["dropped: the object fell"], "measurements": []}
    (failed / "result.json").write_text(json.dumps(result))
    page = checked(write_run_report(failed))
    took = round(result["actions"][1]["seconds"])
    assert f"It failed after {took} s: dropped: the object fell." in page.text


@pytest.mark.parametrize(
    "content",
    ["", "[1]", "{}", '{"belief": 3, "actions": {}, "truth": [], "seconds": "x", "versions": 1}', "[" * 100_000],
)
def test_a_damaged_result_is_passed_over(tmp_path, content):
    damaged = hostile_run(tmp_path / "damaged")
    (damaged / "result.json").write_text(content)
    checked(write_run_report(damaged))


def test_what_an_old_run_did_not_record_is_left_out(tmp_path):
    with RunWriter.create(tmp_path / "old", {}, "thing") as run:
        run.belief(0.0, {"belief": {"material": {"a": 0.5, "b": 0.5}}})
        run.decision(0.0, {"choice": "poke"})
        run.belief(1.0, {"belief": {"material": {"a": 0.9, "b": "x", "c": None}}, "properties": {"mass": 3}})
        run.decision(1.0, {})
    page = checked(write_run_report(tmp_path / "old"))
    assert "Poke" in page.text
    assert "without a recorded reason" in page.text


@pytest.mark.parametrize(
    ("concluded", "truth", "said"),
    [
        ("foam", "foam", "is indeed made of it"),
        ("foam", "wood", "is of wood: the conclusion is wrong"),
        ("foam", "clay", "is of clay, which the reference does not list."),
        ("foam", "unknown", "is of no listed material: the conclusion is wrong"),
        ("unknown", "clay", "which the reference does not list: that is right"),
        ("unknown", "unknown", "Indeed it is none of them"),
        ("unknown", "foam", "is of foam: the conclusion is wrong"),
    ],
)
def test_the_conclusion_is_compared_with_the_truth(tmp_path, concluded, truth, said):
    belief = dict.fromkeys(("foam", "wood", "unknown"), 0.1) | {concluded: 0.8}
    with RunWriter.create(tmp_path / "run", {}, "thing") as run:
        run.belief(0.0, {"belief": {"material": belief}})
        run.finish({"belief": {"material": belief}, "truth": {"material": truth}, "stopped_because": "confident"})
    assert said in checked(write_run_report(tmp_path / "run")).text


def test_what_was_perceived_is_told_and_drawn(tmp_path):
    with RunWriter.create(tmp_path / "run", {}, "thing") as run:
        run.belief(0.0, {"belief": {"material": {"foam": 0.5, "wood": 0.5}}})
        run.decision(0.0, {"target": "material", "choice": "observe", "actions": {}})
        run.sample(sample(0.5))
        run.observation(1.0, "observe", Observation.of("material", {"foam": 0.6, "wood": 0.2, "<b>": 0.0}))
        run.belief(1.0, {"belief": {"material": {"foam": 0.75, "wood": 0.25}}})
    page = checked(write_run_report(tmp_path / "run"))
    assert "It seemed most like the material foam after 1.0 s. That told 0.19 bit" in page.text
    labels = [a["aria-label"] for tag, a in page.attributes if tag == "svg"]
    assert any("foam 1.0, wood 0.33 and <b> 0." in label for label in labels)


def test_a_belief_that_cannot_be_made_again_is_not_drawn(default_run, tmp_path):
    config = tomllib.loads((default_run / "config.toml").read_text())
    names = read_recording(default_run).beliefs[0].data["belief"]["material"]
    for place, shift in (("same", 0.0), ("other", 0.001)):
        changed = dict(names) | {"sponge": names["sponge"] + shift, "gel": names["gel"] - shift}
        with RunWriter.create(tmp_path / place, config, "thing") as run:
            run.belief(0.0, {"belief": {"material": changed}})
            run.decision(0.0, {"choice": "weigh", "actions": {}})
            run.measurement(1.0, "weigh", Measurement("mass", 0.09, 0.002, "kg"))
        page = checked(write_run_report(tmp_path / place))
        drawn = (tmp_path / place / "figures" / "step-1-mass.svg").exists()
        assert drawn == (shift == 0)
        assert ("The densities are left out" in page.text) == (shift != 0)


def test_many_measurements_are_bounded_on_the_page_and_whole_in_the_table(monkeypatch, tmp_path):
    monkeypatch.setattr("selection.reporting.html.MOST_ROWS", 10)
    count = 12
    with RunWriter.create(tmp_path / "long", {}, "thing") as run:
        run.belief(0.0, told("a", "b"))
        run.decision(0.0, {"choice": "poke", "actions": {}})
        for i in range(count):
            run.measurement(1.0, "poke", Measurement("mass", 1.0 + i, 0.1, "kg"))
        run.belief(2.0, told("a", "b"))
    page = checked(write_run_report(tmp_path / "long"))
    assert "2 more rows are in measurements.csv." in page.text
    assert len((tmp_path / "long" / "tables" / "measurements.csv").read_text().splitlines()) == count + 1


def test_pictures_stand_with_their_steps_and_what_is_none_is_passed_over(tmp_path):
    from PIL import Image

    from selection.reporting.pictures import BEFORE, pictures_of

    directory = tmp_path / "run"
    RunWriter.create(directory, {}, "thing").close()
    pictures = directory / "pictures"
    pictures.mkdir()
    names = (
        "begin-overview", "weigh-held-wrist", "weigh-done-overview", "weigh-done-close", "squeeze-failed-close",
        "weigh-held-wrist", "weigh-done-close",
    )  # fmt: skip
    for i, name in enumerate(names):
        Image.new("RGBA" if i else "L", (3000, 200)).save(pictures / f"{i:02d}-{name}.png")
    (pictures / "07-broken.png").write_bytes(b"\x89PNG\r\n\x1a\n" + b"\0" * 50)
    (pictures / "08-text.png").write_text("no picture")
    acts = [(1, "weigh"), (2, "squeeze"), (3, "weigh"), (4, "rub")]
    found = {place: [p.name for p in kept] for place, kept in pictures_of(directory, acts).items() if kept}
    assert found == {
        BEFORE: ["00-begin-overview"],
        1: ["01-weigh-held-wrist", "02-weigh-done-overview", "03-weigh-done-close"],
        2: ["04-squeeze-failed-close"],
        3: ["05-weigh-held-wrist", "06-weigh-done-close"],
    }
    page = checked(write_run_report(directory))
    shown = [attributes["alt"] for tag, attributes in page.attributes if tag == "img"]
    assert shown[0] == "Before the start, from afar"
    assert len(page.text) < 5000


def test_command_line(default_run, tmp_path, capsys):
    out = tmp_path / "place" / "page.html"
    assert main([str(default_run), "--out", str(out)]) == 0
    assert capsys.readouterr().out.strip() == str(out)
    assert out.read_bytes() == (default_run / "report.html").read_bytes()
    for wrong in (tmp_path / "missing", tmp_path):
        assert main([str(wrong)]) == 2
        printed, error = capsys.readouterr()
        assert printed == ""
        assert error.count("\n") == 1
        assert error.startswith("python -m selection.report: ")


def test_a_page_that_cannot_be_written_does_not_fail_the_run(monkeypatch, tmp_path, capsys):
    def broken(directory: Path) -> None:
        raise RuntimeError("no page today")

    monkeypatch.setattr("selection.reporting.write_run_report", broken)
    assert explore(["--out", str(tmp_path / "run"), "--quiet", "--budget", "1"]) == 0
    assert "no page today" in capsys.readouterr().err
    assert (tmp_path / "run" / "result.json").exists()


def test_no_page_if_none_is_wanted(tmp_path):
    assert explore(["--out", str(tmp_path / "run"), "--quiet", "--budget", "1", "--no-report"]) == 0
    assert not {"report.html", "figures", "tables"} & {p.name for p in (tmp_path / "run").iterdir()}
