"""Reference files: JSON to a checked `Network` and back; every refusal names file, key and value."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from dynamics.errors import InvalidInput, UnknownName
from estimation import units
from estimation.json_checks import mapping, number, only, unit_of
from estimation.network import (
    CATEGORY,
    LINEAR,
    LOG,
    MATERIAL,
    RESERVED,
    UNKNOWN,
    Network,
    Property,
    Unknown,
    checked_probabilities,
    uniform,
)
from estimation.relation_file import parse_relations
from estimation.sensor import ClassSensor, Sensor
from models import references

FORMAT = "palpate-reference/1"
_KEYS = (
    "format",
    "name",
    "source",
    "materials",
    "categories",
    "unknown",
    "properties",
    "relations",
    "sensors",
)


def read_network(path_or_name: str | Path) -> Network:
    """Read and check a reference file (format: docs/references.md).

    Raises:
        UnknownName: if there is no such file, or a name in it is not known.
        InvalidInput: if a value in it is unusable.
    """
    try:
        source = references.locate(path_or_name)
        content = references.raw(source)
    except KeyError:
        raise UnknownName("reference", str(path_or_name), references.names()) from None
    except FileNotFoundError:
        raise InvalidInput("reference", str(path_or_name), "an existing file or a shipped name") from None
    except OSError as error:
        raise InvalidInput(str(path_or_name), error.strerror or str(error), "a readable JSON file") from None
    except (ValueError, RecursionError) as error:
        raise InvalidInput(str(path_or_name), str(error), "a JSON object") from None
    return parse_network(content, source.name)


def parse_network(content: Mapping[str, Any], where: str) -> Network:
    """Check the content of a reference file and return the network in SI units.

    Args:
        content: the parsed JSON object.
        where: name of the file, for messages.

    Raises:
        UnknownName: if a key, class, unit or parent is not known.
        InvalidInput: if a value is unusable.
    """
    for key in content:
        if key not in _KEYS:
            raise UnknownName(where, key, _KEYS)
    if content.get("format") != FORMAT:
        raise InvalidInput(f"{where}: format", content.get("format"), FORMAT)
    materials, prior = _classes(content.get("materials"), f"{where}: materials")
    categories, category_prior, conditional = _categories(
        content.get("categories", {}), materials, f"{where}: categories"
    )
    parents = {MATERIAL: materials, **({CATEGORY: categories} if categories else {})}
    properties = tuple(
        _property(name, spec, parents, f"{where}: properties: {name}")
        for name, spec in mapping(content.get("properties"), f"{where}: properties").items()
    )
    if not properties:
        raise InvalidInput(f"{where}: properties", {}, "at least one property")
    relations = parse_relations(
        mapping(content.get("relations", {}), f"{where}: relations"), properties, f"{where}: relations"
    )
    measurable = {prop.name: prop.unit for prop in properties} | {r.name: r.unit for r in relations}
    sensors = tuple(
        (name, _sensor(spec, measurable, parents, f"{where}: sensors: {name}"))
        for name, spec in mapping(content.get("sensors", {}), f"{where}: sensors").items()
    )
    return Network(
        name=str(content.get("name", where)),
        materials=materials,
        properties=properties,
        prior=category_prior if categories else prior,
        categories=categories,
        conditional=conditional,
        relations=relations,
        unknown=_unknown(content.get("unknown"), f"{where}: unknown"),
        sensors=sensors,
        source=str(content.get("source", "")),
    )


def network_content(network: Network) -> dict[str, Any]:
    """Return a network as the JSON object of a reference file, in SI units, without loss."""
    classes = {MATERIAL: network.materials, CATEGORY: network.categories}
    content: dict[str, Any] = {"format": FORMAT, "name": network.name, "source": network.source}
    if network.categories:
        content["materials"] = list(network.materials)
        content["categories"] = {
            name: {"probability": p, "materials": dict(zip(network.materials, row, strict=True))}
            for name, p, row in zip(network.categories, network.prior, network.conditional, strict=True)
        }
    else:
        content["materials"] = dict(zip(network.materials, network.prior, strict=True))
    if network.unknown is not None:
        content["unknown"] = {"weight": network.unknown.weight, "width": network.unknown.width}
    content["properties"] = {}
    for prop in network.properties:
        spec: dict[str, Any] = {"unit": prop.unit, "scale": prop.scale}
        if prop.parent is None:
            spec |= {"mean": prop.means[0], "sd": prop.sds[0]}
        else:
            rows = zip(classes[prop.parent], prop.means, prop.sds, strict=True)
            spec |= {"parent": prop.parent, "classes": {c: {"mean": m, "sd": s} for c, m, s in rows}}
        content["properties"][prop.name] = spec
    content["relations"] = {r.name: {"unit": r.unit, r.kind: dict(r.terms)} for r in network.relations}
    content["sensors"] = {name: _sensor_content(sensor, network) for name, sensor in network.sensors}
    return content


def write_network(network: Network, path: str | Path) -> None:
    """Write a network as a reference file; the file is complete or absent, never half written."""
    target = Path(path)
    draft = target.with_name(target.name + ".tmp")
    with draft.open("w", encoding="utf-8") as stream:
        json.dump(network_content(network), stream, indent=1, ensure_ascii=False, allow_nan=False)
        stream.write("\n")
        stream.flush()
        os.fsync(stream.fileno())
    draft.replace(target)


def _sensor_content(sensor: Sensor | ClassSensor, network: Network) -> dict[str, Any]:
    if isinstance(sensor, Sensor):
        unit = network.unit(sensor.property)
        return {"property": sensor.property, "unit": unit, "sd": sensor.sd, "relative_sd": sensor.relative_sd}
    rows = [list(row) for row in sensor.confusion]
    return {"variable": sensor.variable, "outcomes": list(sensor.outcomes), "confusion": rows}


def _classes(value: object, where: str) -> tuple[tuple[str, ...], tuple[float, ...]]:
    """Return names and probabilities of a list of names or of an object name: probability."""
    names = tuple(value) if isinstance(value, (list, Mapping)) else ()
    if not names or not all(isinstance(name, str) and name for name in names):
        raise InvalidInput(where, value, "a list of names, or an object of names and probabilities")
    if len(set(names)) != len(names) or UNKNOWN in names:
        raise InvalidInput(where, list(names), f"different names, none of them {UNKNOWN!r}")
    if isinstance(value, Mapping):
        return names, tuple(checked_probabilities(value, where).values())
    return names, uniform(len(names))


def _categories(
    value: object, materials: tuple[str, ...], where: str
) -> tuple[tuple[str, ...], tuple[float, ...], tuple[tuple[float, ...], ...]]:
    specs = {name: mapping(spec, f"{where}: {name}") for name, spec in mapping(value, where).items()}
    if not specs:
        return (), (), ()
    names, _ = _classes(list(specs), where)
    given = {name: spec["probability"] for name, spec in specs.items() if "probability" in spec}
    if given and len(given) != len(names):
        raise InvalidInput(f"{where}: probability", sorted(given), "a probability for every category or none")
    prior = tuple(checked_probabilities(given, where).values()) if given else uniform(len(names))
    rows = []
    for name, spec in specs.items():
        only(spec, ("probability", "materials"), f"{where}: {name}")
        shares = mapping(spec.get("materials"), f"{where}: {name}: materials")
        for material in shares:
            if material not in materials:
                raise UnknownName(f"{where}: {name}: materials", material, materials)
        checked = checked_probabilities(shares, f"{where}: {name}: materials")
        rows.append(tuple(checked.get(material, 0.0) for material in materials))
    return names, prior, tuple(rows)


def _unknown(value: object, where: str) -> Unknown | None:
    if value is None:
        return None
    spec = mapping(value, where)
    only(spec, ("weight", "width"), where)
    weight = number(spec.get("weight", Unknown.weight), f"{where}: weight")
    if not 0 <= weight < 1:
        raise InvalidInput(f"{where}: weight", weight, "a number in [0, 1)")
    return Unknown(weight, number(spec.get("width", Unknown.width), f"{where}: width", positive=True))


def _property(name: str, value: object, parents: Mapping[str, tuple[str, ...]], where: str) -> Property:
    spec = mapping(value, where)
    only(spec, ("parent", "unit", "scale", "classes", "mean", "sd"), where)
    if name in RESERVED:
        raise InvalidInput(where, name, "a name that is not a variable or a target")
    unit = unit_of(spec, where)
    known = units.parse_unit(unit, f"{where}: unit")
    scale = spec.get("scale", LINEAR)
    if scale not in (LINEAR, LOG):
        raise UnknownName(f"{where}: scale", scale, (LINEAR, LOG))
    parent = spec.get("parent")
    if parent is not None and parent not in parents:
        raise UnknownName(f"{where}: parent", parent, parents)
    if parent is None:
        rows = [(where, {"mean": spec.get("mean"), "sd": spec.get("sd")})]
    else:
        classes = mapping(spec.get("classes"), f"{where}: classes")
        for key in classes:
            if key not in parents[parent]:
                raise UnknownName(f"{where}: classes", key, parents[parent])
        for key in parents[parent]:
            if key not in classes:
                raise InvalidInput(f"{where}: classes", list(classes), f"an entry for {key}")
        rows = [(f"{where}: {key}", dict(mapping(classes[key], f"{where}: {key}"))) for key in parents[parent]]
    means, sds = [], []
    for place, row in rows:
        only(row, ("mean", "sd"), place)
        means.append(known.factor * number(row.get("mean"), f"{place}: mean", positive=scale == LOG))
        sds.append(known.factor * number(row.get("sd"), f"{place}: sd", positive=True))
    return Property(name, parent, known.si, scale, tuple(means), tuple(sds))


def _sensor(
    value: object, measurable: Mapping[str, str], parents: Mapping[str, tuple[str, ...]], where: str
) -> Sensor | ClassSensor:
    spec = mapping(value, where)
    try:
        if "variable" in spec:
            only(spec, ("variable", "outcomes", "confusion"), where)
            variable = spec["variable"]
            if variable not in parents:
                raise UnknownName("variable", variable, parents)
            rows = spec.get("confusion")
            if not isinstance(rows, list) or not all(isinstance(row, list) for row in rows):
                raise InvalidInput("confusion", rows, "rows of numbers")
            table = tuple(tuple(number(cell, "confusion") for cell in row) for row in rows)
            outcomes = tuple(spec.get("outcomes", parents[variable]))
            return ClassSensor(variable, parents[variable], outcomes, table)
        only(spec, ("property", "unit", "sd", "relative_sd"), where)
        if spec.get("property") not in measurable:
            raise UnknownName("property", spec.get("property"), measurable)
        expected = measurable[spec["property"]]
        factor = units.conversion(str(spec.get("unit", expected)), expected, "unit")
        sd = factor * number(spec.get("sd", 0.0), "sd")
        return Sensor(spec["property"], sd, number(spec.get("relative_sd", 0.0), "relative_sd"))
    except UnknownName as error:
        raise UnknownName(f"{where}: {error.where}", error.found, error.known) from None
    except InvalidInput as error:
        raise InvalidInput(f"{where}: {error.where}", error.found, error.valid) from None
