"""The result of an exploration as other programs read it: ``result.json``."""

from __future__ import annotations

import platform
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from selection.exploration import Exploration, Step, belief_record
from selection.robots import Truth

PACKAGES = ("palpate", "gtsam", "pin", "mujoco", "numpy", "scipy", "filterpy")


def versions() -> dict[str, str]:
    """Return the versions of Python, of Palpate and of what its numbers depend on."""
    found = {"python": platform.python_version()}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "not installed"
    return found


def result_of(exploration: Exploration, name: str, truth: Truth | None) -> dict[str, Any]:
    """Return what an exploration came to.

    Its times are the robot's, so that the same seed gives the same result on one machine.

    Args:
        exploration: a finished one.
        name: of the object.
        truth: what the object really is, for the comparison, if it was simulated.
    """
    result: dict[str, Any] = {"object": name}
    if truth is not None:
        result["truth"] = {
            "material": truth.material,
            "properties": {
                key: {"value": value, "unit": truth.units[key]} for key, value in truth.properties.items()
            },
        }
    result |= belief_record(exploration.belief)
    result["actions"] = [_action(step) for step in exploration.steps]
    result["stopped_because"] = exploration.stopped_because
    result["seconds"] = round(exploration.seconds, 6)
    result["versions"] = versions()
    return result


def _action(step: Step) -> dict[str, Any]:
    return {
        "action": step.action,
        "scores": {score.name: score.bits for score in step.decision.scores},
        "measurements": [
            {"property": m.property, "mean": m.mean, "sd": m.sd, "unit": m.unit} for m in step.measurements
        ],
        "observations": [{"variable": o.variable, "likelihoods": o.by_class} for o in step.observations],
        "notes": list(step.notes),
        "seconds": round(step.seconds, 6),
        "ok": step.ok,
    }
