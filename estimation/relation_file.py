"""The relations of a reference file, such as mass = density volume: checked and expanded."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from dynamics.errors import InvalidInput, UnknownName
from estimation import units
from estimation.json_checks import mapping, number, only, unit_of
from estimation.network import LINEAR, LOG, RESERVED, Property, Relation


def parse_relations(
    specs: Mapping[str, Any], properties: tuple[Property, ...], where: str
) -> tuple[Relation, ...]:
    """Check the relations of a reference file and return them in terms of properties alone, in SI units.

    Raises:
        UnknownName: if a key, property or unit is not known.
        InvalidInput: if a relation is ill-formed, goes in a circle, or its unit does not fit.
    """
    known = {prop.name: prop for prop in properties}
    kinds: dict[str, tuple[str, Mapping[str, Any]]] = {}
    for name, value in specs.items():
        spec = mapping(value, f"{where}: {name}")
        only(spec, ("unit", "product", "sum"), f"{where}: {name}")
        forms = [key for key in ("product", "sum") if key in spec]
        if len(forms) != 1 or name in known or name in RESERVED:
            raise InvalidInput(f"{where}: {name}", dict(spec), "a new name with one of: product, sum")
        kinds[name] = (forms[0], mapping(spec[forms[0]], f"{where}: {name}: {forms[0]}"))

    def expand(name: str, seen: tuple[str, ...]) -> dict[str, float]:
        """Return a relation in terms of properties alone."""
        place = f"{where}: {name}"
        if name in seen:
            raise InvalidInput(place, " -> ".join((*seen, name)), "relations without a cycle")
        kind, terms = kinds[name]
        total: dict[str, float] = {}
        for term, value in terms.items():
            power = number(value, f"{place}: {term}")
            if power == 0:
                raise InvalidInput(f"{place}: {term}", value, "a number other than 0")
            if term in known:
                inner = {term: 1.0}
            elif term in kinds and kinds[term][0] == kind:
                inner = expand(term, (*seen, name))
            else:
                others = [other for other in kinds if kinds[other][0] == kind]
                raise UnknownName(f"{place}: {kind}", term, (*known, *others))
            for prop, own in inner.items():
                total[prop] = total.get(prop, 0.0) + power * own
        if not total:
            raise InvalidInput(place, dict(terms), "at least one property")
        return total

    found = []
    for name, (kind, _) in kinds.items():
        terms = tuple(expand(name, ()).items())
        place = f"{where}: {name}"
        unit = unit_of(specs[name], place)
        _check_relation(kind, terms, known, unit, place)
        found.append(Relation(name, kind, units.parse_unit(unit, f"{place}: unit").si, terms))
    return tuple(found)


def _check_relation(
    kind: str, terms: tuple[tuple[str, float], ...], known: Mapping[str, Property], unit: str, where: str
) -> None:
    """Refuse a relation whose unit does not fit or whose form the update cannot treat."""
    own = units.parse_unit(unit, f"{where}: unit").dimension
    exponents = [units.parse_unit(known[name].unit).dimension for name, _ in terms]
    if kind == "sum":
        fits = all(other == own for other in exponents)
        if any(known[name].scale == LOG for name, _ in terms):
            raise InvalidInput(where, [name for name, _ in terms], "a sum of properties on the linear scale")
    else:
        total = [
            sum(power * other[i] for (_, power), other in zip(terms, exponents, strict=True))
            for i in range(len(own))
        ]
        fits = all(abs(a - b) < 1e-12 for a, b in zip(total, own, strict=True))
        linear = [name for name, _ in terms if known[name].scale == LINEAR]
        if linear and (len(terms) != 2 or any(power != 1 for _, power in terms)):
            raise InvalidInput(
                where, dict(terms), "log-scale properties, or a product of two properties where one is linear"
            )
    if not fits:
        raise InvalidInput(f"{where}: unit", unit, f"the unit of the {kind} of its properties")
