"""Units at the edge: a unit in text becomes SI, spelled in one way. Pint knows the units; inside all is SI.

Files of the field spell units freely ("g cm^-3", "kg.m⁻³"), and the thesis' own measurement file writes density as
"kg.^{-3}": the spelling is cleaned first, and a repair of that kind is told to the caller.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Any

from dynamics.errors import InvalidInput

# What is written; of several units of one dimension, the first.
SI_UNITS = ("kg", "m", "m^2", "m^3", "s", "Pa", "N", "N/m", "kg/m^3", "J", "W", "V", "A", "m/s", "1", "rad", "N m")

_REPAIRS = {"kg.^{-3}": "kg/m^3", "kg.^-3": "kg/m^3"}
_NAMES = {"°": "degree", "%": "percent", "Ω": "ohm"}
_ANGLE = re.compile(r"^(deg|degree|rad|radian|mrad)\b")
_COMMON = {"rad s^-1": "rad/s"}
_ALIKE = {"N m": "J"}  # torque and energy have one dimension
_NO_UNIT = ("", "1", "-", "none")
_SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
_TOKEN = re.compile(r"([A-Za-zµμΩ°%]+)\s*\^?\s*([+-]?\d)?(?!\d)")
_LONGEST = 40
_HIGHEST = 9  # power of a unit


@dataclass(frozen=True)
class Unit:
    """A unit that was understood.

    Attributes:
        si: the SI unit of its kind, such as ``Pa``.
        factor: SI units in one of it.
        note: what had to be repaired in its spelling, if anything.
    """

    si: str
    factor: float
    note: str = ""

    def to_si(self, value: float) -> float:
        """Return a value of this unit in SI."""
        return value * self.factor


@cache
def parse_unit(text: str, where: str = "unit") -> Unit:
    """Understand a unit.

    Args:
        text: such as ``kPa``, ``g cm^-3`` or ``kg.^{-3}``.
        where: named in the error.

    Raises:
        InvalidInput: if it is no unit of a physical quantity, or one with an offset, as degC.
    """
    if text in SI_UNITS:
        return Unit(text, 1.0)
    repaired = _REPAIRS.get(text.replace(" ", ""))
    if repaired is not None:
        return Unit(repaired, 1.0, f"{where}: {text!r} was read as {repaired}")
    if text.strip().lower() in _NO_UNIT:
        return Unit("1", 1.0)
    expression = _expression(text, where)
    import pint

    try:
        quantity = _registry().Quantity(Fraction(1), expression).to_base_units()
        (_registry().Quantity(Fraction(1), expression) * 2).to_base_units()  # an offset unit can not be multiplied
    except (pint.PintError, ValueError, TypeError, ArithmeticError, AttributeError) as error:
        raise InvalidInput(where, text, f"a unit such as kg, g/cm^3, kPa or mm ({error})") from None
    if any(power != int(power) or abs(power) > _HIGHEST for power in quantity._units.values()):
        raise InvalidInput(where, text, f"a unit whose powers are whole and at most {_HIGHEST}")
    si = _by_dimension().get(frozenset(quantity.dimensionality.items()), "")
    if si == "1" and _ANGLE.search(expression):
        si = "rad"
    return Unit(_COMMON.get(si := si or _spell(quantity), si), float(quantity.magnitude))


def factor_to(si: str, text: str, where: str) -> float:
    """Return how many of an SI unit one of another unit is.

    Raises:
        InvalidInput: if the text is no unit, or one of another kind of quantity.
    """
    unit = parse_unit(text, where)
    if _ALIKE.get(unit.si, unit.si) != _ALIKE.get(si, si):
        raise InvalidInput(where, text, f"a unit that can be converted to {si}")
    return unit.factor


def _expression(text: str, where: str) -> str:
    """Return a unit's text in the form Pint reads, from a closed grammar: a product of named units and powers."""
    clean = text.strip().translate(_SUPERSCRIPTS)
    for old, new in (("**", "^"), ("{", ""), ("}", ""), ("·", " "), ("*", " "), (".", " "), ("−", "-")):
        clean = clean.replace(old, new)
    if len(clean) > _LONGEST or clean.count("/") > 2 or clean.count("(") > 1:
        raise InvalidInput(where, text, "a unit such as kg, g/cm^3, kPa or mm")
    parts = clean.replace("(", " ").replace(")", " ").split("/")
    factors = []
    for place, part in enumerate(parts):
        at = 0
        body = part.strip()
        if place == 0 and body == "1":
            continue
        while at < len(body):
            match = _TOKEN.match(body, at)
            if match is None:
                raise InvalidInput(where, text, "a unit such as kg, g/cm^3, kPa or mm")
            name, power = match.group(1), int(match.group(2) or 1)
            if power == 0:
                raise InvalidInput(where, text, "a unit such as kg, g/cm^3, kPa or mm")
            factors.append(f"{_NAMES.get(name, name)}**{power if place == 0 else -power}")
            at = match.end()
            at += len(body[at:]) - len(body[at:].lstrip())
        if not body:
            raise InvalidInput(where, text, "a unit such as kg, g/cm^3, kPa or mm")
    return " * ".join(factors)


@cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry(non_int_type=Fraction, cache_folder=None)


@cache
def _by_dimension() -> dict[frozenset[tuple[str, Any]], str]:
    """Return the unit to write for every dimension that has a name here."""
    known: dict[frozenset[tuple[str, Any]], str] = {}
    for unit in SI_UNITS:
        expression = "dimensionless" if unit == "1" else _expression(unit, "unit")
        known.setdefault(frozenset(_registry().Quantity(Fraction(1), expression).dimensionality.items()), unit)
    return known


def _spell(quantity: Any) -> str:
    """Spell a unit that has no name here, by the units it is made of."""
    parts = []
    for name, power in sorted(quantity._units.items()):
        symbol = f"{_registry().get_symbol(name)}"
        parts.append(symbol if power == 1 else f"{symbol}^{power}")
    return " ".join(parts) or "1"
