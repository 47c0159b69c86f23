"""Measurements in the form the IPALM project exchanges them: a JSON list of objects with named values.

Form: thesis, section 3.3.10, Listing 2. Every value has ``mean``, ``sigma`` and ``units``; what Palpate writes is
in SI units, spelled as units are; on reading, other units are converted and the thesis' own spelling is repaired.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from dynamics.errors import InvalidInput
from estimation.measurement import Measurement
from estimation.observation import Observation
from estimation.units import parse_unit


@dataclass(frozen=True)
class MeasuredObject:
    """An object and what was measured of it.

    Attributes:
        name: what the object is called.
        object_id: its number in the list's owner's world, if it has one.
        measurements: in SI units, in the order they were taken.
        observations: of classes; their values are likelihoods by class. Written, and left out when read.
    """

    name: str
    object_id: str | None = None
    measurements: tuple[Measurement, ...] = ()
    observations: tuple[Observation, ...] = ()


@dataclass(frozen=True)
class MeasurementList:
    """What a list holds.

    Attributes:
        objects: in the order of the list.
        notes: what was repaired, and which values were left out and why.
    """

    objects: tuple[MeasuredObject, ...]
    notes: tuple[str, ...] = ()


def to_list(objects: Sequence[MeasuredObject]) -> str:
    """Return objects as an IPALM measurement list."""
    return json.dumps([_object(item) for item in objects], indent=2, allow_nan=False, ensure_ascii=False) + "\n"


def from_list(text: str, where: str = "measurement list") -> MeasurementList:
    """Read an IPALM measurement list.

    A value without a usable mean, sigma or unit is left out and noted: nothing is guessed.

    Args:
        text: JSON; NaN is tolerated.
        where: named in errors and notes, such as the file.

    Raises:
        InvalidInput: if it is no list of objects with measurements.
    """
    try:
        data = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InvalidInput(where, str(error), "JSON") from None
    if not isinstance(data, list):
        raise InvalidInput(where, type(data).__name__, "a list of objects")
    notes: list[str] = []
    objects = tuple(_read_object(item, f"{where}: object {n}", notes) for n, item in enumerate(data, 1))
    return MeasurementList(objects, tuple(notes))


def finite(value: object) -> float | None:
    """Return a JSON value as a finite number, or None if it is none."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    try:
        number = float(value)
    except OverflowError:
        return None
    return number if abs(number) < float("inf") else None


def to_measurement(
    name: str, mean: object, sd: object, units: object, where: str, notes: list[str]
) -> Measurement | None:
    """Return a value of a file in SI units, or None, with a note why not."""
    number, deviation = finite(mean), finite(sd)
    if number is None or deviation is None or deviation <= 0:
        notes.append(f"{where}: left out: mean {mean!r}, sigma {sd!r}"[:200])
        return None
    if not isinstance(units, str):
        notes.append(f"{where}: left out: its unit is unknown ({units!r})"[:200])
        return None
    try:
        unit = parse_unit(units, where, repair=True)
        measurement = Measurement(name, unit.to_si(number), unit.to_si(deviation), unit.si)
    except InvalidInput as error:
        notes.append(f"{where}: left out: {error}"[:300])
        return None
    if unit.note:
        notes.append(unit.note)
    return measurement


def _object(item: MeasuredObject) -> dict[str, object]:
    listed: dict[str, Any] = {"object_name": item.name}
    listed["measurements"] = [
        {"name": m.property, "value": {"sigma": m.sd, "mean": m.mean, "units": m.unit}} for m in item.measurements
    ]
    seen = [{"name": o.variable, "value": {"likelihoods": o.by_class}} for o in item.observations]
    if seen:
        listed["measurements"] = [*listed["measurements"], *seen]
    if item.object_id is not None:
        listed["object_id"] = item.object_id
    return listed


def _read_object(item: Any, where: str, notes: list[str]) -> MeasuredObject:
    if not isinstance(item, Mapping) or not isinstance(item.get("measurements"), list):
        raise InvalidInput(where, item, "an object with object_name and a list of measurements")
    name = item.get("object_name")
    if not isinstance(name, str):
        raise InvalidInput(f"{where}: object_name", name, "text")
    known_as = item.get("object_id")
    measurements = []
    for number, listed in enumerate(item["measurements"], 1):
        place = f"{where}, measurement {number}"
        if not isinstance(listed, Mapping) or not isinstance(listed.get("value"), Mapping):
            raise InvalidInput(place, listed, "a name, and a value with mean, sigma and units")
        if not isinstance(listed.get("name"), str):
            raise InvalidInput(f"{place}: name", listed.get("name"), "text")
        value = listed["value"]
        one = to_measurement(
            listed["name"],
            value.get("mean"),
            value.get("sigma"),
            value.get("units"),
            f"{place} ({listed['name']})",
            notes,
        )
        if one is not None:
            measurements.append(one)
    return MeasuredObject(name, None if known_as is None else str(known_as), tuple(measurements))
