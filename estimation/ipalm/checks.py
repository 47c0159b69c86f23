"""What the database would accept, or drop, without a word, and should not: found before anything is sent."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from estimation.ipalm.documents import Document, Entry, Pose
from estimation.ipalm.lists import to_measurement

ENTRY_TYPES = ("continuous", "categorical", "size", "other")
LONGEST_NAME = 100  # characters that the database keeps


def problems(document: Document) -> tuple[str, ...]:
    """Return what the database would take, or drop, without a word, and should not; empty if all is well."""
    found = []
    instance = document.object_instance
    if instance.dataset_id is not None and instance.dataset is None:
        found.append("object_instance: dataset_id without dataset")
    if all(getattr(instance, key) is None for key in ("dataset", "maker", "common_name")):
        found.append("object_instance: no name at all")
    if not document.setup:
        found.append("setup: no devices")
    for name in document.setup.values():
        if not name or len(name) > LONGEST_NAME or " " in name:
            found.append(f"setup: device {name!r}; valid: 1 to 100 characters without a space")
    for name, series in document.sensor_outputs.items():
        if name not in document.setup.values():
            found.append(f"sensor_outputs: {name!r} is no device of the setup and would be dropped")
        if not _all_finite(series):
            found.append(f"sensor_outputs of {name}: a number is not finite")
    for key in ("grasp", "gripper_pose"):
        pose: Pose | None = getattr(document, key)
        if pose is not None and pose.grasped is None:
            found.append(f"{key}: without grasped it would be dropped")
    for entry in document.entries:
        found += _entry_problems(entry)
    return tuple(found)


def _entry_problems(entry: Entry) -> list[str]:
    found = []
    where = f"entry {entry.name!r}"
    if entry.kind not in ENTRY_TYPES:
        found.append(f"{where}: type {entry.kind!r}; valid: {', '.join(ENTRY_TYPES)}")
    if not entry.name or not entry.values:
        found.append(f"{where}: a name and at least one value are needed")
    if entry.kind == "categorical":
        total = math.fsum(value.probability or 0.0 for value in entry.values)
        if (
            any(v.probability is None or not 0 <= v.probability <= 1 for v in entry.values)
            or abs(total - 1) > 1e-6
        ):
            found.append(f"{where}: probabilities that sum to {total:g}; valid: each in [0, 1], sum 1")
        return found
    for value in entry.values:
        place = f"{where}, value {value.name!r}"
        if value.mean is None or not math.isfinite(value.mean):
            found.append(f"{place}: mean {value.mean}; valid: a finite number")
        if value.std is None or not (math.isfinite(value.std) and value.std > 0):
            found.append(f"{place}: std {value.std}; valid: a finite number > 0")
        notes: list[str] = []
        if to_measurement(value.name, 1.0, 1.0, value.units, place, notes) is None:
            found += notes
    return found


def _all_finite(value: Any) -> bool:
    if isinstance(value, Mapping):
        return all(_all_finite(item) for item in value.values())
    if isinstance(value, list | tuple):
        return all(_all_finite(item) for item in value)
    return not isinstance(value, float) or math.isfinite(value)
