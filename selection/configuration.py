"""The configuration that a run keeps, enough to repeat it or to go on with it."""

from __future__ import annotations

import argparse
import hashlib
import math
from pathlib import Path
from typing import Any

from dynamics.robot import Robot
from dynamics.tables import Table, read_toml
from estimation.reestimation import describe, mesh_of
from models.robot import REVISIONS, gen3_mjcf
from selection.result import versions

NO_BUDGET = "none"


def configuration(given: argparse.Namespace, object_file: Path, robot: Robot) -> dict[str, Any]:
    """Return what a run was asked for, with the robot it ran on and the versions of what computed it."""
    description = gen3_mjcf(given.revision, not given.no_vision)
    return {
        "object": given.object,
        "object_file": object_file.read_text(encoding="utf-8"),
        **mesh_of(object_file),
        "reference": given.reference,
        "prior": given.prior or "",
        "seed": given.seed,
        "noise": given.noise,
        "target": given.target,
        "fidelity": given.fidelity,
        "confidence": given.confidence,
        "budget_s": given.budget if math.isfinite(given.budget) else NO_BUDGET,
        "price_bits_per_s": given.price,
        "robot": given.robot,
        "revision": given.revision,
        "vision": "none" if given.no_vision else "module",
        "eyes": given.vision,
        "lookahead": given.lookahead,
        "model_sha256": hashlib.sha256(description.encode()).hexdigest(),
        **describe(robot.arm, robot.gripper),
        "versions": versions(),
    }


def take_up(given: argparse.Namespace) -> None:
    """Replace arguments by those of the run that is resumed; where a real arm listens is asked for anew.

    Raises:
        InvalidInput: if its configuration is missing or malformed.
    """
    path = given.resume / "config.toml"
    kept = Table(str(path), read_toml(path))
    for key in ("object", "reference", "noise", "robot"):
        setattr(given, key, kept.text(key))
    given.fidelity = kept.text("fidelity", "uniform", ("uniform", "indentation"))
    given.revision = kept.text("revision", choices=REVISIONS)
    given.no_vision = kept.text("vision", choices=("none", "module")) == "none"
    given.prior = kept.text("prior") or None
    given.vision = kept.text("eyes", "default")
    given.lookahead = kept.text("lookahead", "auto", choices=("auto", "never"))
    given.seed = int(kept.number("seed", at_least=0))
    given.target = kept.text("target", "material")
    given.confidence = kept.number("confidence", above=0, at_most=1)
    given.price = kept.number("price_bits_per_s", at_least=0)
    if kept.content("budget_s") != NO_BUDGET:
        given.budget = kept.number("budget_s", at_least=0)
