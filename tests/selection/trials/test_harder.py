"""The harder world against published figures of a prototype, within both samples' error."""

from __future__ import annotations

import numpy as np
import pytest

from selection.trials.cells import SURE, actions_to
from selection.trials.explore import Trace
from selection.trials.harder import WORLDS, HarderJob, HarderResult, entries, run_job
from selection.trials.harder_tables import CAP, harder_curves, harder_tables, verdict
from selection.trials.statistics import calibration_error

COUNT = 400


def ran(world: int, name: str, count: int = COUNT) -> HarderResult:
    found = entries(WORLDS[world])
    place = next(i for i, entry in enumerate(found) if entry.name == name)
    arrays = run_job(HarderJob(world, place, 0, count, 0))
    material, category = Trace.of([arrays], "material."), Trace.of([arrays], "category.")
    return HarderResult(WORLDS[world], name, found[place].messages, material, category)


@pytest.fixture(scope="module")
def known() -> dict[str, HarderResult]:
    names = ("exact, material", "exact, both", "mode 2", "random")
    return {name: ran(0, name) for name in names}


def test_actions_to_certainty(known: dict[str, HarderResult]) -> None:
    """Prototype, 400 objects: 3.10 +- 0.25 actions with the target material, 4.68 at random, 4.38 with Mode 2."""
    counts = {name: actions_to(result.material, SURE, CAP) for name, result in known.items()}
    assert counts["exact, material"].mean() == pytest.approx(3.10, abs=0.25)
    assert counts["random"].mean() >= 4.4
    assert counts["mode 2"].mean() == pytest.approx(4.38, abs=0.45)
    assert (counts["random"] - counts["exact, material"]).mean() >= 1.0


def test_accuracies(known: dict[str, HarderResult]) -> None:
    """Prototype: 74 86 92 94 95 % of materials after 1 to 5 actions, 27 % of categories after one."""
    found = 100 * known["exact, material"].material.right[:, 1:6].mean(axis=0)
    assert np.all(np.abs(found - [74, 86, 92, 94, 95]) < 3 * np.sqrt(2) * 100 * np.sqrt(0.75 * 0.25 / COUNT))
    assert found[2] >= 88
    both = 100 * known["exact, both"].category.right[:, 3].mean()
    assert both == pytest.approx(77, abs=9)


def test_probabilities_are_true(known: dict[str, HarderResult]) -> None:
    """Objects drawn from the model: what is believed with P is right with P, novel objects included."""
    for result in (*known.values(), ran(1, "exact, material", 1500)):
        trace = result.material
        error, low, _ = calibration_error(trace.top[:, 3], trace.right[:, 3])
        assert error < 0.06
        assert low < 0.05


def test_novel_objects_are_found() -> None:
    trace = ran(1, "exact, material", 1000).material
    assert 0.07 < trace.novel.mean() < 0.13
    assert trace.unknown[trace.novel, -1].mean() > 0.75
    assert trace.unknown[~trace.novel, -1].mean() < 0.02


def test_tables_and_curves_say_what_was_found(known: dict[str, HarderResult]) -> None:
    results = list(known.values())
    said = verdict(results)
    own, other = (actions_to(known[name].material, SURE, CAP) for name in ("exact, material", "random"))
    assert f"{(other - own).mean():.2f}" in said
    curves = harder_curves(results)
    accuracy = next(c for c in curves if c.label == "random" and c.figure.endswith("accuracy-material-by-actions"))
    assert accuracy.y == pytest.approx(known["random"].material.right.mean(axis=0).tolist())
    assert all(low <= y <= high for low, y, high in zip(accuracy.low, accuracy.y, accuracy.high, strict=True))
    at_once = next(c for c in curves if c.label == "random" and c.figure.endswith("accuracy-material-by-seconds"))
    assert at_once.y[0] == accuracy.y[0]
    assert len(harder_tables([*results, *(ran(w, n, 20) for w in (1, 2) for n in known)])) == 3
