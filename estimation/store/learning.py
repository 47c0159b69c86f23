"""Reference files from measurements: mean and standard deviation of every property of every class, with counts."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from dynamics.errors import InvalidInput
from estimation.bounds import bound_of
from estimation.measurement import Measurement

FORMAT = "palpate-reference/1"
DEFAULT_SPREAD = 0.2  # of the mean: how much objects of a class differ, where only one was measured


@dataclass(frozen=True)
class Observation:
    """A measurement of an object of a known class."""

    object_name: str
    material: str
    measurement: Measurement


@dataclass(frozen=True)
class LearnedClass:
    """What the objects of one class say of one property.

    Attributes:
        material, property, unit: which.
        mean, sd: of the class: where a further object of it is expected [unit].
        objects, readings: how many of each it was learned from.
    """

    material: str
    property: str
    unit: str
    mean: float
    sd: float
    objects: int
    readings: int


def learn_classes(observations: Iterable[Observation], spread: float = DEFAULT_SPREAD) -> tuple[LearnedClass, ...]:
    """Learn the classes that observations belong to.

    Readings of one object are averaged by their precision, x_o = sum(x/s^2) / sum(1/s^2), with variance
    v_o = 1 / sum(1/s^2). Objects of a class differ by tau^2 = max(var(x_o) - mean(v_o), 0), and a further one is
    expected at mean(x_o) with variance tau^2 + var(x_o) / n (random effects by the method of moments). One object
    alone shows no difference: then tau = spread x mean.

    Args:
        observations: of all objects; bounds are left out.
        spread: relative difference of objects where only one was measured.

    Raises:
        InvalidInput: if one property comes in several units.
    """
    grouped: dict[tuple[str, str], dict[str, list[Measurement]]] = {}
    units: dict[str, str] = {}
    for one in observations:
        if bound_of(one.measurement) is not None:
            continue
        name, unit = one.measurement.property, one.measurement.unit
        if units.setdefault(name, unit) != unit:
            raise InvalidInput(f"observations of {name}: unit", unit, units[name])
        objects = grouped.setdefault((one.material, name), {})
        objects.setdefault(one.object_name, []).append(one.measurement)
    return tuple(
        _learn(material, name, units[name], list(objects.values()), spread)
        for (material, name), objects in sorted(grouped.items())
    )


def reference_content(name: str, classes: Sequence[LearnedClass], source: str) -> dict[str, Any]:
    """Return a reference file's content; properties that not every class knows are left out.

    Raises:
        InvalidInput: if no property is known of every class.
    """
    materials = sorted({one.material for one in classes})
    known: dict[str, dict[str, LearnedClass]] = {}
    for one in classes:
        known.setdefault(one.property, {})[one.material] = one
    complete = {prop: rows for prop, rows in known.items() if len(rows) == len(materials)}
    if not complete:
        lacking = {prop: sorted(set(materials) - set(rows)) for prop, rows in known.items()}
        raise InvalidInput("reference: properties", lacking, "a property that was measured for every class")
    counts = ", ".join(f"{c.material} {c.property}: {c.objects} objects, {c.readings} readings" for c in classes)
    return {
        "format": FORMAT,
        "name": name,
        "source": f"{source} ({counts})",
        "materials": materials,
        "unknown": {"weight": 0.05, "width": 2},
        "properties": {prop: _property(rows) for prop, rows in complete.items()},
    }


def _property(rows: Mapping[str, LearnedClass]) -> dict[str, Any]:
    positive = all(row.mean > 0 for row in rows.values())
    return {
        "parent": "material",
        "unit": next(iter(rows.values())).unit,
        "scale": "log" if positive else "linear",
        "classes": {material: {"mean": row.mean, "sd": row.sd} for material, row in sorted(rows.items())},
    }


def _learn(material: str, name: str, unit: str, objects: list[list[Measurement]], spread: float) -> LearnedClass:
    fused = [_fuse(readings) for readings in objects]
    values = [value for value, _ in fused]
    count = len(values)
    mean = math.fsum(values) / count
    if count == 1:
        variance = fused[0][1] + (spread * mean) ** 2
    else:
        scatter = math.fsum((value - mean) ** 2 for value in values) / (count - 1)
        between = max(scatter - math.fsum(v for _, v in fused) / count, 0.0)
        variance = between + scatter / count
        if variance == 0.0:  # identical values: the readings' own uncertainty is all there is
            variance = math.fsum(v for _, v in fused) / count**2
    return LearnedClass(material, name, unit, mean, math.sqrt(variance), count, sum(map(len, objects)))


def _fuse(readings: list[Measurement]) -> tuple[float, float]:
    precision = math.fsum(1 / m.sd**2 for m in readings)
    return math.fsum(m.mean / m.sd**2 for m in readings) / precision, 1 / precision
