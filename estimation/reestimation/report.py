"""What re-estimating a log came to, as plain data and as lines for people."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from dynamics.arm import Arm
from estimation.measurement import Measurement
from estimation.readers import LogMap, read_log
from estimation.reestimation.again import Reestimate, change_in_sds, matched, reestimate
from estimation.reestimation.batch import Request
from estimation.reestimation.description import arm_named, known_of
from estimation.reestimation.motion import is_motion, weigh_motion

SAME = 1e-9  # relative difference up to which a number is the recorded one


def report_of(log: Path, request: Request) -> Mapping[str, Any]:
    """Read and estimate a log; return the report.

    Raises:
        PalpateError: if it can not be read or estimated.
    """
    mapping = LogMap.from_file(request.mapping) if request.mapping else LogMap()
    arm = arm_named(request.robot, request.tool_frame) if request.robot else None
    if arm is None and not (log / "run.mcap").exists() and log.suffix != ".mcap":
        arm = Arm.gen3()
    recording = read_log(log, mapping, arm)
    if arm is None and not recording.config:  # a foreign log: to be checked against the arm that it is taken for
        arm = Arm.gen3()
        recording = read_log(log, mapping, arm)
    known = known_of(recording.config, arm, request.reference, request.object_file)
    tares = [read_log(Path(path), mapping, known.arm) for path in request.tares]
    if is_motion(recording) or (request.drives and not recording.marks):
        moved = weigh_motion(known.arm, recording, tares, request.drives)
        return report(log, Reestimate(recording, (moved,), None, {}, recording.notes))
    return report(log, reestimate(recording, known, tares))


def report(log: Path, again: Reestimate) -> Mapping[str, Any]:
    """Return a re-estimate as plain data."""
    actions = [
        {
            "action": action.action,
            "measurements": [_pair(new, old) for new, old in matched(action)],
            "notes": list(action.notes),
        }
        for action in again.actions
    ]
    belief = again.belief
    now = {} if belief is None else {name: belief.probabilities(name) for name in belief.network.variables}
    recorded = again.recorded_belief.get("belief", {})
    rejections = again.recording.rejections
    return {
        "log": str(log),
        "object": again.recording.object_name,
        "samples": len(again.recording.samples),
        "rejected": {"count": rejections.count, "reasons": list(rejections.reasons)},
        "actions": actions,
        "belief": now,
        "recorded_belief": recorded if isinstance(recorded, Mapping) else {},
        "notes": list(again.notes),
    }


def changes(report: Mapping[str, Any]) -> int:
    """Return how many numbers of a report differ from the recorded ones, missing and new ones included."""
    count = 0
    for action in report.get("actions", ()):
        for one in action["measurements"]:
            old, new = one["recorded"], one["now"]
            if new is None or (old is not None and not all(_same(new[key], old[key]) for key in ("mean", "sd"))):
                count += 1
    for variable, old in report.get("recorded_belief", {}).items():
        new = report["belief"].get(variable, {})
        count += sum(1 for name, p in old.items() if abs(new.get(name, 0.0) - p) > SAME)
    return count


def lines(report: Mapping[str, Any], compare: bool) -> Iterator[str]:
    """Yield a report as people read it."""
    if "error" in report:
        yield f"{report['log']}: {report['error']}"
        return
    name = f" ({report['object']})" if report["object"] else ""
    yield f"{report['log']}{name}: {report['samples']} samples"
    if report["rejected"]["count"]:
        first = "; ".join(report["rejected"]["reasons"])
        yield f"  {report['rejected']['count']} rows rejected: {first}"
    for note in report["notes"]:
        yield f"  note: {note}"
    for action in report["actions"]:
        for one in action["measurements"]:
            yield f"  {action['action']:9} {_line(one, compare)}"
        for note in action["notes"]:
            yield f"  {action['action']:9} {note}"
    for variable, probabilities in report["belief"].items():
        yield f"  {variable:9} {_best(probabilities)}"
        old = report["recorded_belief"].get(variable)
        if compare and old:
            yield f"  {'':9} was {_best(old)}"
    known = [one["recorded"] for action in report["actions"] for one in action["measurements"]]
    if compare and not any(known) and not report["recorded_belief"]:
        yield "  nothing was recorded at the time to compare with"
    elif compare:
        count = changes(report)
        yield "  nothing changed" if count == 0 else f"  {count} numbers changed"


def _pair(new: Measurement | None, old: Measurement | None) -> dict[str, Any]:
    known = new or old
    assert known is not None
    return {
        "property": known.property,
        "unit": known.unit,
        "now": None if new is None else {"mean": new.mean, "sd": new.sd},
        "recorded": None if old is None else {"mean": old.mean, "sd": old.sd},
        "change_in_sds": change_in_sds(new, old) if new is not None and old is not None else None,
    }


def _line(one: Mapping[str, Any], compare: bool) -> str:
    def spoken(value: Mapping[str, float] | None) -> str:
        return "nothing" if value is None else f"{value['mean']:.6g} +- {value['sd']:.2g} {one['unit']}"

    text = f"{one['property']:12} {spoken(one['now'])}"
    if not compare:
        return text
    if one["recorded"] is None:
        return f"{text}   (nothing was recorded)"
    if one["now"] is not None and all(_same(one["now"][key], one["recorded"][key]) for key in ("mean", "sd")):
        return f"{text}   (as recorded)"
    moved = "" if one["change_in_sds"] is None else f", {one['change_in_sds']:.2g} sd away"
    return f"{text}   (was {spoken(one['recorded'])}{moved})"


def _same(new: float, old: float) -> bool:
    return abs(new - old) <= SAME * max(abs(new), abs(old))


def _best(probabilities: Mapping[str, float]) -> str:
    best = sorted(probabilities.items(), key=lambda item: -item[1])[:3]
    return ", ".join(f"{name} {p:.4f}" for name, p in best)
