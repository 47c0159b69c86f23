"""Checks of values in JSON files; every refusal names the place and the value."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from dynamics.errors import InvalidInput, UnknownName


def mapping(value: object, where: str) -> Mapping[str, Any]:
    """Return a value that is an object with names as keys.

    Raises:
        InvalidInput: if it is not.
    """
    if not isinstance(value, Mapping):
        raise InvalidInput(where, value, "an object with names as keys")
    return value


def number(value: object, where: str, positive: bool = False) -> float:
    """Return a value that is a finite number, above zero where asked for.

    Raises:
        InvalidInput: if it is not.
    """
    valid = "a finite number > 0" if positive else "a finite number"
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise InvalidInput(where, value, valid)
    if positive and value <= 0:
        raise InvalidInput(where, value, valid)
    return float(value)


def only(spec: Mapping[str, Any], known: tuple[str, ...], where: str) -> None:
    """Refuse keys that mean nothing.

    Raises:
        UnknownName: if a key is not among the known ones.
    """
    for key in spec:
        if key not in known:
            raise UnknownName(where, key, known)


def unit_of(spec: Mapping[str, Any], where: str) -> str:
    """Return the unit that an entry must give.

    Raises:
        InvalidInput: if there is none.
    """
    unit = spec.get("unit")
    if not isinstance(unit, str):
        raise InvalidInput(f"{where}: unit", unit, "a unit, such as kg/m^3, or 1 for none")
    return unit
