"""A run as a document of the object database: what was explored, by what, its series, and what was concluded."""

from __future__ import annotations

from typing import Any

from estimation.ipalm.documents import Document, ObjectInstance, entry_of, entry_of_classes
from estimation.recording import Recording

METHOD = "palpate"


def document_of(recording: Recording, instance: ObjectInstance | None = None, series: bool = True) -> Document:
    """Return a run as one document.

    Args:
        recording: of the run.
        instance: which object it was; by default its name within the data set ``palpate``.
        series: whether to include what the sensors read, in SI units.
    """
    arm = str(recording.config.get("arm", "arm"))
    gripper = recording.config.get("gripper")
    name = str(gripper.get("name", "gripper")) if isinstance(gripper, dict) else "gripper"
    entries = [entry_of(one.measurement) for one in recording.measurements]
    last = recording.beliefs[-1].data.get("belief", {}) if recording.beliefs else {}
    for variable, probabilities in last.items():
        total = sum(probabilities.values())
        entries.append(entry_of_classes(variable, {key: p / total for key, p in probabilities.items()}))
    known = instance or ObjectInstance("palpate", recording.object_name, None, recording.object_name)
    return Document(
        object_instance=known,
        setup={"arm": arm, "gripper": name},
        sensor_outputs=_series(recording, arm, name) if series else {arm: {"parameters": _parameters(recording)}},
        entries=tuple(entries),
        method=METHOD,
    )


def _series(recording: Recording, arm: str, gripper: str) -> dict[str, dict[str, Any]]:
    s = recording.samples
    time = s.time.tolist()
    joints: dict[str, Any] = {"time": time}
    for n in range(s.q.shape[1]):
        joints[f"joint{n + 1}_position"] = s.q[:, n].tolist()
        joints[f"joint{n + 1}_torque"] = s.tau[:, n].tolist()
    hand = {"time": time, "position": s.opening.tolist(), "current": s.effort.tolist()}
    return {arm: {**joints, "parameters": _parameters(recording)}, gripper: hand}


def _parameters(recording: Recording) -> dict[str, Any]:
    return {"run": recording.source.name, "started": recording.started, "units": "SI"}
