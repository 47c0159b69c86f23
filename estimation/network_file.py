"""Reference files: JSON to a checked `Network` and back; every refusal names file, key and value."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from dynamics.errors import InvalidInput, UnknownName
from estimation import units
from estimation.network import (
    CATEGORY,
    LINEAR,
    LOG,
    MATERIAL,
    UNKNOWN,
    Network,
    Property,
    Relation,
    Unknown,
    checked_probabilities,
    uniform,
)
from estimation.sensor import ClassSensor, Sensor
from models import references

FORMAT = "palpate-reference/1"
_KEYS = ("format", "name", "source", "materials", "categories", "unknown", "properties", "relations", "sensors")


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
    except ValueError as error:
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
        for name, spec in _mapping(content.get("properties"), f"{where}: properties").items()
    )
    if not properties:
        raise InvalidInput(f"{where}: properties", {}, "at least one property")
    relations = _relations(
        _mapping(content.get("relations", {}), f"{where}: relations"), properties, f"{where}: relations"
    )
    measurable = {q.name: q.unit for q in (*properties, *relations)}
    sensors = tuple(
        (name, _sensor(spec, measurable, parents, f"{where}: sensors: {name}"))
        for name, spec in _mapping(content.get("sensors", {}), f"{where}: sensors").items()
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


def _mapping(value: object, where: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise InvalidInput(where, value, "an object with names as keys")
    return value


def _number(value: object, where: str, positive: bool = False) -> float:
    valid = "a finite number > 0" if positive else "a finite number"
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise InvalidInput(where, value, valid)
    if positive and value <= 0:
        raise InvalidInput(where, value, valid)
    return float(value)


def _only(spec: Mapping[str, Any], known: tuple[str, ...], where: str) -> None:
    for key in spec:
        if key not in known:
            raise UnknownName(where, key, known)


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
    specs = {name: _mapping(spec, f"{where}: {name}") for name, spec in _mapping(value, where).items()}
    if not specs:
        return (), (), ()
    names, _ = _classes(list(specs), where)
    given = {name: spec["probability"] for name, spec in specs.items() if "probability" in spec}
    if given and len(given) != len(names):
        raise InvalidInput(f"{where}: probability", sorted(given), "a probability for every category or none")
    prior = tuple(checked_probabilities(given, where).values()) if given else uniform(len(names))
    rows = []
    for name, spec in specs.items():
        _only(spec, ("probability", "materials"), f"{where}: {name}")
        shares = _mapping(spec.get("materials"), f"{where}: {name}: materials")
        for material in shares:
            if material not in materials:
                raise UnknownName(f"{where}: {name}: materials", material, materials)
        checked = checked_probabilities(shares, f"{where}: {name}: materials")
        rows.append(tuple(checked.get(material, 0.0) for material in materials))
    return names, prior, tuple(rows)


def _unknown(value: object, where: str) -> Unknown | None:
    if value is None:
        return None
    spec = _mapping(value, where)
    _only(spec, ("weight", "width"), where)
    weight = _number(spec.get("weight", Unknown.weight), f"{where}: weight")
    if not 0 <= weight < 1:
        raise InvalidInput(f"{where}: weight", weight, "a number in [0, 1)")
    return Unknown(weight, _number(spec.get("width", Unknown.width), f"{where}: width", positive=True))


def _property(name: str, value: object, parents: Mapping[str, tuple[str, ...]], where: str) -> Property:
    spec = _mapping(value, where)
    _only(spec, ("parent", "unit", "scale", "classes", "mean", "sd"), where)
    if name in (MATERIAL, CATEGORY, "both", "everything"):
        raise InvalidInput(where, name, "a name that is not a variable or a target")
    unit = str(spec.get("unit", ""))
    factor = units.si_factor(unit, where)
    scale = spec.get("scale", LINEAR)
    if scale not in (LINEAR, LOG):
        raise UnknownName(f"{where}: scale", scale, (LINEAR, LOG))
    parent = spec.get("parent")
    if parent is not None and parent not in parents:
        raise UnknownName(f"{where}: parent", parent, parents)
    if parent is None:
        rows = [(where, {"mean": spec.get("mean"), "sd": spec.get("sd")})]
    else:
        classes = _mapping(spec.get("classes"), f"{where}: classes")
        for key in classes:
            if key not in parents[parent]:
                raise UnknownName(f"{where}: classes", key, parents[parent])
        for key in parents[parent]:
            if key not in classes:
                raise InvalidInput(f"{where}: classes", list(classes), f"an entry for {key}")
        rows = [
            (f"{where}: {key}", dict(_mapping(classes[key], f"{where}: {key}"))) for key in parents[parent]
        ]
    means, sds = [], []
    for place, row in rows:
        _only(row, ("mean", "sd"), place)
        means.append(factor * _number(row.get("mean"), f"{place}: mean", positive=scale == LOG))
        sds.append(factor * _number(row.get("sd"), f"{place}: sd", positive=True))
    return Property(name, parent, units.si_unit(unit, where), scale, tuple(means), tuple(sds))


def _relations(
    specs: Mapping[str, Any], properties: tuple[Property, ...], where: str
) -> tuple[Relation, ...]:
    known = {prop.name: prop for prop in properties}
    kinds: dict[str, tuple[str, Mapping[str, Any]]] = {}
    for name, value in specs.items():
        spec = _mapping(value, f"{where}: {name}")
        _only(spec, ("unit", "product", "sum"), f"{where}: {name}")
        kind = [key for key in ("product", "sum") if key in spec]
        if len(kind) != 1 or name in known or name in (MATERIAL, CATEGORY, "both", "everything"):
            raise InvalidInput(f"{where}: {name}", dict(spec), "a new name with one of: product, sum")
        kinds[name] = (kind[0], _mapping(spec[kind[0]], f"{where}: {name}: {kind[0]}"))

    def expand(name: str, seen: tuple[str, ...]) -> dict[str, float]:
        """Return a relation in terms of properties alone."""
        place = f"{where}: {name}"
        if name in seen:
            raise InvalidInput(place, " -> ".join((*seen, name)), "relations without a cycle")
        kind, terms = kinds[name]
        total: dict[str, float] = {}
        for term, value in terms.items():
            number = _number(value, f"{place}: {term}")
            if number == 0:
                raise InvalidInput(f"{place}: {term}", value, "a number other than 0")
            if term in known:
                inner = {term: 1.0}
            elif term in kinds and kinds[term][0] == kind:
                inner = expand(term, (*seen, name))
            else:
                others = [other for other in kinds if kinds[other][0] == kind]
                raise UnknownName(f"{place}: {kind}", term, (*known, *others))
            for prop, power in inner.items():
                total[prop] = total.get(prop, 0.0) + number * power
        if not total:
            raise InvalidInput(place, dict(terms), "at least one property")
        return total

    found = []
    for name, (kind, _) in kinds.items():
        terms = tuple(expand(name, ()).items())
        place = f"{where}: {name}"
        unit = str(specs[name].get("unit", ""))
        _check_relation(kind, terms, known, unit, place)
        found.append(Relation(name, kind, units.si_unit(unit, place), terms))
    return tuple(found)


def _check_relation(
    kind: str, terms: tuple[tuple[str, float], ...], known: Mapping[str, Property], unit: str, where: str
) -> None:
    """Refuse a relation whose unit does not fit or whose form the update cannot treat."""
    own = units.dimension(unit, where)
    exponents = [units.dimension(known[name].unit, where) for name, _ in terms]
    if kind == "sum":
        fits = all(other == own for other in exponents)
        if any(known[name].scale == LOG for name, _ in terms):
            raise InvalidInput(where, [name for name, _ in terms], "a sum of properties on the linear scale")
    else:
        total = [
            sum(power * other[i] for (_, power), other in zip(terms, exponents, strict=True))
            for i in range(3)
        ]
        fits = all(abs(a - b) < 1e-12 for a, b in zip(total, own, strict=True))
        linear = [name for name, _ in terms if known[name].scale == LINEAR]
        if linear and (len(terms) != 2 or any(power != 1 for _, power in terms)):
            raise InvalidInput(
                where, dict(terms), "log-scale properties, or a product of two properties where one is linear"
            )
    if not fits:
        raise InvalidInput(f"{where}: unit", unit, f"the unit of the {kind} of its properties")


def _sensor(
    value: object, measurable: Mapping[str, str], parents: Mapping[str, tuple[str, ...]], where: str
) -> Sensor | ClassSensor:
    spec = _mapping(value, where)
    try:
        if "variable" in spec:
            _only(spec, ("variable", "outcomes", "confusion"), where)
            variable = spec["variable"]
            if variable not in parents:
                raise UnknownName("variable", variable, parents)
            rows = spec.get("confusion")
            if not isinstance(rows, list) or not all(isinstance(row, list) for row in rows):
                raise InvalidInput("confusion", rows, "rows of numbers")
            table = tuple(tuple(_number(cell, "confusion") for cell in row) for row in rows)
            outcomes = tuple(spec.get("outcomes", parents[variable]))
            return ClassSensor(variable, parents[variable], outcomes, table)
        _only(spec, ("property", "unit", "sd", "relative_sd"), where)
        if spec.get("property") not in measurable:
            raise UnknownName("property", spec.get("property"), measurable)
        expected = measurable[spec["property"]]
        factor = units.conversion(str(spec.get("unit", expected)), expected, "unit")
        sd = factor * _number(spec.get("sd", 0.0), "sd")
        return Sensor(spec["property"], sd, _number(spec.get("relative_sd", 0.0), "relative_sd"))
    except UnknownName as error:
        raise UnknownName(f"{where}: {error.where}", error.found, error.known) from None
    except InvalidInput as error:
        raise InvalidInput(f"{where}: {error.where}", error.found, error.valid) from None
