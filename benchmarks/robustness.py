"""Full explorations of random objects: what crashes, warns, drops unnoticed or fails, and why.

``python -m benchmarks.robustness --objects 200 --out DIR [--seed N] [--noise default|none] [--workers N]
[--json]`` explores random objects at random places until every action is used up, and looks into the simulator
meanwhile: where the object is really is compared with what was reported. What is complete in DIR is not done
again, so a long study can be made piece by piece with a growing ``--objects``.

Counted: explorations that crashed (any error that is not the project's own), those that physics warned of, objects
that were dropped by an action that said all was well, and actions that failed, by reason. An object counts as
dropped if it leaves the hand by more than 20 mm while it is lifted, comes down before the hand does, or is off the
table in the end. Told besides: displaced, what rolled or slid by more than 15 mm when it was let go; declined,
actions that were not done because the object is not one for them (such as rubbing what has no upright sides); and
how what was measured compares with the truth.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from pathlib import Path

import numpy as np

from dynamics.command_line import ended
from dynamics.errors import PalpateError
from dynamics.tables import read_toml
from selection.dataset.folder import Dataset
from selection.dataset.one import FAILURE, OBJECT, RESULT, Ignoring, Job, Outcome, Setup, explore_object
from selection.dataset.progress import show_progress
from sim.bodies import object_pose

LIFTED, LEFT_HAND, ASIDE, OFF_TABLE = 0.008, 0.020, 0.015, 0.05  # m
# m over where it stood, and what it may hang lower in the hand, for pads swing down as they close, when put back
DOWN, SLID = 0.003, 0.008
UNSUITABLE = ("unsuitable", "too heavy", "unreachable")  # reasons not to begin with an action
LOOK_EVERY = 5  # samples
INSPECTION = "inspection.json"
SHARE = 0.99  # of the actions that must succeed
TWO_SIDED = 1.96


class Inspector(Ignoring):
    """Follows the object through the simulator, beside what the exploration sees.

    Args:
        opened: the simulated robot.
        folder: where to write what was seen.
    """

    def __init__(self, opened, folder: Path) -> None:
        self._robot, self._folder = opened.robot, folder
        self._seen: list[dict[str, object]] = []
        self._home = self._where()
        self._restart()
        self._robot.listen(self._follow)

    def learns(self, step) -> None:
        here = self._where()
        moved = here - self._home
        self._seen.append(
            {
                "action": step.action,
                "ok": step.ok,
                "notes": list(step.notes),
                "aside_m": float(np.hypot(moved[0], moved[1])),
                "up_m": float(moved[2]),
                "lifted_m": self._highest - float(self._home[2]),
                "lost": self._lost,
            }
        )
        (self._folder / INSPECTION).write_text(json.dumps(self._seen, indent=1), encoding="utf-8")
        self._home = here
        self._restart()

    def _restart(self) -> None:
        self._highest, self._lowest = float(self._home[2]), np.inf
        self._held_at, self._lost, self._count = None, False, 0

    def _follow(self, sample) -> None:
        self._count += 1
        if self._count % LOOK_EVERY:
            return
        here = self._where()
        self._highest = max(self._highest, float(here[2]))
        pose = self._robot.arm.tool_pose(sample.q)
        self._lowest = min(self._lowest, float(pose[2, 3]))
        in_hand = pose[:3, :3].T @ (here - pose[:3, 3])
        height = float(here[2] - self._home[2])
        if self._held_at is None:
            self._held_at = in_hand if height > LIFTED else None
            return
        self._lost |= bool(np.linalg.norm(in_hand - self._held_at) > LEFT_HAND)
        if height < DOWN:  # put back, unless the hand is still above
            self._lost |= bool(pose[2, 3] - self._lowest > DOWN + SLID)
            self._held_at = None

    def _where(self) -> np.ndarray:
        """Return where the middle of the object really is [m]."""
        return object_pose(self._robot._model, self._robot._data)


def work(job: Job) -> Outcome:
    return explore_object(job, Inspector)


def summary(dataset: Dataset, count: int) -> dict[str, object]:
    """Return the counts over what is complete of the first objects."""
    known = {error.__name__ for error in _errors(PalpateError)}
    crashes, warnings, refused, silent, displaced, declined, reasons = [], [], [], [], [], [], Counter()
    actions: Counter[str] = Counter()
    failed: Counter[str] = Counter()
    found: dict[str, dict[str, list[tuple[float, float]]]] = {}
    failures, complete = [], 0
    for index in range(count):
        folder = dataset.job(index).folder
        if not folder.exists():
            continue
        complete += 1
        if (folder / FAILURE).exists():
            failure = json.loads((folder / FAILURE).read_text())
            told = f"{index}: {failure['kind']}: {failure['message']}"
            if failure["kind"] == "SimulationError":
                warnings.append(told)
            else:
                (refused if failure["kind"] in known else crashes).append(told)
            continue
        result = json.loads((folder / RESULT).read_text())
        seen = json.loads((folder / INSPECTION).read_text())
        shape, truth = read_toml(folder / OBJECT)["declared"]["shape"], result["truth"]["properties"]
        for measured in (m for action in result["actions"] for m in action["measurements"]):
            name = measured["property"]
            if name in truth:
                true = truth[name]["value"]
                told = measured["mean"] / true, (measured["mean"] - true) / measured["sd"]
                found.setdefault(name, {}).setdefault(shape, []).append(told)
        for action, looked in zip(result["actions"], seen, strict=True):
            name, note = action["action"], "; ".join(action["notes"])
            if not action["ok"] and note.startswith(UNSUITABLE) and looked["lifted_m"] < LIFTED:
                declined.append(f"{index}: {name}: {note}")
                continue
            actions[name] += 1
            if not action["ok"]:
                failed[name] += 1
                reasons[f"{name}: {note.split(':')[0]}"] += 1
                failures.append(f"{index}: {name}: {note}")
                continue
            aside, up = looked["aside_m"], looked["up_m"]
            told = f"{index}: {name}: {aside * 1e3:.0f} mm aside and {up * 1e3:.0f} mm higher at its end"
            if looked["lost"] or up < -OFF_TABLE:
                silent.append(told)
            elif max(aside, abs(up)) > ASIDE:
                displaced.append(told)
    total, bad = sum(actions.values()), sum(failed.values())
    return {
        "explorations": complete,
        "crashes": len(crashes),
        "physics_warnings": len(warnings),
        "refused": len(refused),
        "unreported_drops": len(silent),
        "displaced": len(displaced),
        "declined": len(declined),
        "actions": total,
        "succeeded_share": (total - bad) / total if total else None,
        "by_action": {name: {"done": actions[name], "failed": failed[name]} for name in sorted(actions)},
        "reasons": dict(reasons.most_common()),
        "accuracy": {name: {shape: _accuracy(told) for shape, told in of.items()} for name, of in found.items()},
        "passed": complete == count
        and not (crashes or warnings or refused or silent)
        and total - bad >= SHARE * total,
        "details": {
            "crashes": crashes,
            "warnings": warnings,
            "refused": refused,
            "unreported": silent,
            "displaced": displaced,
            "declined": declined,
            "failures": failures,
        },
    }


def _accuracy(told: list[tuple[float, float]]) -> dict[str, float]:
    """Return how measurements compare with the truth, from ratios to it and errors in standard deviations."""
    ratio, error = np.array(told).T
    return {
        "measurements": len(told),
        "median_ratio": float(np.median(ratio)),
        "median_error": float(np.median(np.abs(ratio - 1))),
        "coverage": float(np.mean(np.abs(error) <= TWO_SIDED)),
    }


def _errors(base: type) -> list[type]:
    return [base, *(found for kind in base.__subclasses__() for found in _errors(kind))]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--objects", type=int, default=200)
    parser.add_argument("--out", type=Path, default=Path("runs/robustness"))
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--reference", default="soft-cubes")
    parser.add_argument("--noise", choices=("default", "none"), default="default")
    parser.add_argument("--poisson", type=float, default=0.45)
    parser.add_argument("--workers", type=int, default=0)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--only-report", action="store_true", help="of what is complete, without exploring")
    given = parser.parse_args()
    again = f"what is complete is kept, go on with: --out {given.out}"
    return ended("python -m benchmarks.robustness", lambda: _explore(given), again)


def _explore(given: argparse.Namespace) -> int:
    setup = Setup(given.seed, given.reference, given.noise, price=0.0, confidence=1.0, poisson=given.poisson)
    with Dataset.open(given.out.resolve(), setup) as dataset:
        if not given.only_report:
            outcomes = dataset.explore(given.objects, given.workers, work=work)
            show_progress(outcomes, given.objects, len(dataset.missing(given.objects)))
        found = summary(dataset, given.objects)
    if given.json:
        json.dump(found, sys.stdout, indent=2)
        print()
    else:
        details = found.pop("details")
        for key, value in found.items():
            print(f"{key:18} {value}")
        for kind, lines in details.items():
            for line in lines:
                print(f"{kind}: {line}")
    return 0 if found["passed"] else 1


if __name__ == "__main__":
    sys.exit(main())
