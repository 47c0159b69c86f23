"""A measurement document of the IPALM object database: one object, one set-up, sensor series and what they told.

The fields are those of the database's upload form. A document is kept as it was read, units and unknown keys
included; :func:`measurements_of` converts what it says to SI.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from dynamics.errors import InvalidInput
from estimation.ipalm.lists import to_measurement
from estimation.measurement import Measurement

_MEASUREMENT_KEYS = (
    "object_instance",
    "setup",
    "sensor_outputs",
    "grasp",
    "gripper_pose",
    "object_pose",
    "method",
    "consider_this_ground_truth",
)


@dataclass(frozen=True)
class Value:
    """One number of an entry: a mean with its deviation, or a probability.

    Attributes:
        name: of the property, or of the category.
        mean, std, units: as the document spells them; NaN or None where it does not know.
        probability: of the category, else None.
        other: anything else that stands with it.
    """

    name: str
    mean: float | None = None
    std: float | None = None
    units: str | None = None
    probability: float | None = None
    other: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Entry:
    """What a method told about the object: values of one property, or probabilities of categories.

    Attributes:
        kind: ``continuous``, ``categorical``, ``size`` or ``other``.
        name: of the property or the classification.
        values: its numbers.
        repository: where the method's code is, if known.
        ground_truth: whether it was measured by other, better means.
    """

    kind: str
    name: str
    values: tuple[Value, ...]
    repository: str | None = None
    ground_truth: bool | None = None


@dataclass(frozen=True)
class ObjectInstance:
    """Which object it was; the database takes objects with equal names for the same one."""

    dataset: str | None = None
    dataset_id: str | None = None
    maker: str | None = None
    common_name: str | None = None
    other: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Pose:
    """Where something stood: metres, and angles in the unit the document's owner uses, often degrees."""

    translation: tuple[float, float, float]
    rotation: tuple[float, float, float]
    grasped: bool | None = None


@dataclass(frozen=True)
class Document:
    """One measurement of the database.

    Attributes:
        object_instance: the object.
        setup: name of the device for each kind of device: arm, gripper, camera ...
        sensor_outputs: for devices of the set-up, by name, their series and parameters.
        entries: what was concluded.
        grasp, gripper_pose, object_pose: poses, where known.
        method: how it was measured.
        ground_truth: whether to trust it above others.
        other: keys of the measurement that are unknown here.
    """

    object_instance: ObjectInstance
    setup: Mapping[str, str]
    sensor_outputs: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    entries: tuple[Entry, ...] = ()
    grasp: Pose | None = None
    gripper_pose: Pose | None = None
    object_pose: Pose | None = None
    method: str | None = None
    ground_truth: bool = False
    other: Mapping[str, Any] = field(default_factory=dict)


def to_json(document: Document, allow_nan: bool = True) -> str:
    """Return a document as JSON.

    Raises:
        ValueError: for numbers that are not finite, unless they are allowed.
    """
    measurement: dict[str, Any] = {
        "object_instance": _instance(document.object_instance),
        "setup": dict(document.setup),
        "sensor_outputs": {name: dict(series) for name, series in document.sensor_outputs.items()},
    }
    for key in ("grasp", "gripper_pose", "object_pose"):
        pose: Pose | None = getattr(document, key)
        if pose is not None:
            measurement[key] = _pose(pose)
    if document.method is not None:
        measurement["method"] = document.method
    measurement["consider_this_ground_truth"] = document.ground_truth
    whole = {"measurement": {**measurement, **document.other}, "entries": [_entry(e) for e in document.entries]}
    return json.dumps(whole, allow_nan=allow_nan, ensure_ascii=False)


def from_json(text: str, where: str = "measurement document") -> Document:
    """Read a document; NaN is tolerated, and so are keys that are unknown.

    Raises:
        InvalidInput: if a part is missing or has the wrong form.
    """
    try:
        data = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InvalidInput(where, str(error), "JSON") from None
    measurement = _mapping(_mapping(data, where).get("measurement"), f"{where}: measurement")
    listed = data.get("entries") or []
    if not isinstance(listed, list):
        raise InvalidInput(f"{where}: entries", listed, "a list")
    if data.get("entry") is not None:
        listed = [*listed, data["entry"]]
    instance = _mapping(measurement.get("object_instance"), f"{where}: object_instance")
    names = {
        key: _text(instance.get(key), f"{where}: {key}")
        for key in ("dataset", "dataset_id", "maker", "common_name")
    }
    outputs = _mapping(measurement.get("sensor_outputs") or {}, f"{where}: sensor_outputs")
    setup = _mapping(measurement.get("setup"), f"{where}: setup")
    return Document(
        object_instance=ObjectInstance(
            **names, other=_mapping(instance.get("other") or {}, f"{where}: object_instance: other")
        ),
        setup={str(kind): _named(name, f"{where}: setup {kind}") for kind, name in setup.items()},
        sensor_outputs={
            str(name): dict(_mapping(series, f"{where}: sensor output {name}")) for name, series in outputs.items()
        },
        entries=tuple(_read_entry(item, f"{where}: entry {n}") for n, item in enumerate(listed, 1)),
        grasp=_read_pose(measurement.get("grasp"), f"{where}: grasp"),
        gripper_pose=_read_pose(measurement.get("gripper_pose"), f"{where}: gripper_pose"),
        object_pose=_read_pose(measurement.get("object_pose"), f"{where}: object_pose"),
        method=_text(measurement.get("method"), f"{where}: method"),
        ground_truth=bool(measurement.get("consider_this_ground_truth")),
        other={key: value for key, value in measurement.items() if key not in _MEASUREMENT_KEYS},
    )


def measurements_of(
    document: Document, where: str = "document"
) -> tuple[tuple[Measurement, ...], tuple[str, ...]]:
    """Return what a document says of the object in SI units, and notes on what could not be used."""
    notes: list[str] = []
    found = []
    for entry in document.entries:
        if entry.kind == "categorical":
            continue
        for value in entry.values:
            place = f"{where}: {entry.name} {value.name}"
            one = to_measurement(value.name, value.mean, value.std, value.units, place, notes)
            if one is not None:
                found.append(one)
    return tuple(found), tuple(notes)


def entry_of(measurement: Measurement, repository: str | None = None) -> Entry:
    """Return a measurement as an entry."""
    value = Value(measurement.property, measurement.mean, measurement.sd, measurement.unit)
    return Entry("continuous", measurement.property, (value,), repository)


def entry_of_classes(name: str, probabilities: Mapping[str, float], repository: str | None = None) -> Entry:
    """Return the probabilities of classes, such as materials, as an entry."""
    values = tuple(Value(category, probability=p) for category, p in probabilities.items())
    return Entry("categorical", name, values, repository)


def _instance(instance: ObjectInstance) -> dict[str, Any]:
    names = {key: getattr(instance, key) for key in ("dataset", "dataset_id", "maker", "common_name")}
    return {**{key: name for key, name in names.items() if name is not None}, "other": dict(instance.other)}


def _pose(pose: Pose) -> dict[str, Any]:
    listed: dict[str, Any] = {"translation": list(pose.translation), "rotation": list(pose.rotation)}
    return listed if pose.grasped is None else {**listed, "grasped": pose.grasped}


def _entry(entry: Entry) -> dict[str, Any]:
    listed: dict[str, Any] = {"type": entry.kind, "name": entry.name, "repository": entry.repository}
    listed["values"] = [_value(value) for value in entry.values]
    return listed if entry.ground_truth is None else {**listed, "ground_truth": entry.ground_truth}


def _value(value: Value) -> dict[str, Any]:
    if value.probability is not None:
        numbers: dict[str, Any] = {"probability": value.probability}
        numbers |= {
            key: getattr(value, key) for key in ("mean", "std", "units") if getattr(value, key) is not None
        }
    else:
        numbers = {"mean": value.mean, "std": value.std, "units": value.units}
    return {"name": value.name, **numbers, **value.other}


def _read_entry(item: Any, where: str) -> Entry:
    data = _mapping(item, where)
    listed = data.get("values")
    if not isinstance(listed, list):
        raise InvalidInput(f"{where}: values", listed, "a list of values")
    truth = data.get("ground_truth")
    return Entry(
        kind=_named(data.get("type"), f"{where}: type"),
        name=_named(data.get("name"), f"{where}: name"),
        values=tuple(_read_value(one, f"{where}: value {n}") for n, one in enumerate(listed, 1)),
        repository=_text(data.get("repository"), f"{where}: repository"),
        ground_truth=None if truth is None else bool(truth),
    )


def _read_value(item: Any, where: str) -> Value:
    data = _mapping(item, where)
    mean = data["mean"] if "mean" in data else data.get("value")
    known = ("name", "mean", "value", "std", "units", "probability")
    return Value(
        name=_named(data.get("name"), f"{where}: name"),
        mean=_number(mean, f"{where}: mean"),
        std=_number(data.get("std"), f"{where}: std"),
        units=_text(data.get("units"), f"{where}: units"),
        probability=_number(data.get("probability"), f"{where}: probability"),
        other={key: one for key, one in data.items() if key not in known},
    )


def _read_pose(item: Any, where: str) -> Pose | None:
    if item is None or item == {}:
        return None
    data = _mapping(item, where)
    parts = [_triple(data.get(key), f"{where}: {key}") for key in ("translation", "rotation")]
    grasped = data.get("grasped")
    return Pose(parts[0], parts[1], None if grasped is None else bool(grasped))


def _triple(item: Any, where: str) -> tuple[float, float, float]:
    numbers = [_number(one, where) for one in item] if isinstance(item, list) and len(item) == 3 else []
    if len(numbers) != 3 or any(number is None for number in numbers):
        raise InvalidInput(where, item, "three numbers")
    x, y, z = (float(number) for number in numbers if number is not None)
    return x, y, z


def _mapping(item: Any, where: str) -> Mapping[str, Any]:
    if not isinstance(item, Mapping):
        raise InvalidInput(where, item, "a JSON object")
    return item


def _text(item: Any, where: str) -> str | None:
    if item is not None and not isinstance(item, str):
        raise InvalidInput(where, item, "text")
    return item


def _named(item: Any, where: str) -> str:
    if not isinstance(item, str):
        raise InvalidInput(where, item, "text")
    return item


def _number(item: Any, where: str) -> float | None:
    if item is None:
        return None
    if isinstance(item, bool) or not isinstance(item, int | float):
        raise InvalidInput(where, item, "a number")
    try:
        return float(item)
    except OverflowError:
        raise InvalidInput(where, item, "a number that fits") from None
