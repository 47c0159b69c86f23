"""Units at the edge: a unit in text becomes SI, spelled in one way; inside all is SI.

The units that files of this field bear are in a table. Any other spelling ("g cm^-3", "kg.m⁻³") and unit is read
by Pint. The thesis' own measurement file writes density as "kg.^{-3}": repaired where that is asked for, and told.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, lru_cache
from typing import Any

from dynamics.errors import InvalidInput

Dimension = tuple[int, ...]
"""Exponents of kilogram, metre, second, ampere, kelvin, mole and candela."""

_SI: dict[str, Dimension] = {
    "kg": (1, 0, 0),
    "m": (0, 1, 0),
    "m^2": (0, 2, 0),
    "m^3": (0, 3, 0),
    "s": (0, 0, 1),
    "Pa": (1, -1, -2),
    "N": (1, 1, -2),
    "N/m": (1, 0, -2),
    "kg/m^3": (1, -3, 0),
    "J": (1, 2, -2),
    "W": (1, 2, -3),
    "V": (1, 2, -3, -1),
    "A": (0, 0, 0, 1),
    "m/s": (0, 1, -1),
    "1": (),
    "rad": (),
    "rad/s": (0, 0, -1),
    "N m": (1, 2, -2),
}
SI_UNITS = tuple(_SI)
"""What is written; of several units of one dimension, the first."""

_TABLE: dict[str, tuple[float, str]] = {
    "": (1.0, "1"),
    "-": (1.0, "1"),
    "none": (1.0, "1"),
    "g": (1e-3, "kg"),
    "mm": (1e-3, "m"),
    "cm": (1e-2, "m"),
    "cm^3": (1e-6, "m^3"),
    "mm^3": (1e-9, "m^3"),
    "m3": (1.0, "m^3"),
    "cm3": (1e-6, "m^3"),
    "mm3": (1e-9, "m^3"),
    "l": (1e-3, "m^3"),
    "g/cm^3": (1e3, "kg/m^3"),
    "g/cm3": (1e3, "kg/m^3"),
    "kg/m3": (1.0, "kg/m^3"),
    "kPa": (1e3, "Pa"),
    "MPa": (1e6, "Pa"),
    "GPa": (1e9, "Pa"),
    "ms": (1e-3, "s"),
    "kN": (1e3, "N"),
    "mA": (1e-3, "A"),
}
_REPAIRS = {"kg.^{-3}": "kg/m^3", "kg.^-3": "kg/m^3"}
_NAMES = {"°": "degree", "%": "percent", "Ω": "ohm"}
_ANGLE = re.compile(r"^(deg|degree|rad|radian|mrad)\b")
_COMMON = {"rad s^-1": "rad/s"}
_SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
_TOKEN = re.compile(r"([A-Za-zµμΩ°%]+)\s*\^?\s*([+-]?\d)?(?!\d)")
_SYMBOLS = {name for name in (*_SI, *_TABLE) if name.isalpha() and name != "none"}
_LOWER_CASE = {name.lower() for name in _SYMBOLS if name != name.lower()}
_BASE = ("[mass]", "[length]", "[time]", "[current]", "[temperature]", "[substance]", "[luminosity]")
_LONGEST = 40
_HIGHEST = 9  # power of a unit
_VALID = "a unit such as kg, g/cm^3, kPa or mm"


@dataclass(frozen=True)
class Unit:
    """A unit that was understood.

    Attributes:
        si: the SI unit of its kind, such as ``Pa``.
        factor: SI units in one of it.
        dimension: its exponents of the base units.
        note: what had to be repaired in its spelling, if anything.
    """

    si: str
    factor: float
    dimension: Dimension
    note: str = ""

    def to_si(self, value: float) -> float:
        """Return a value of this unit in SI."""
        return value * self.factor

    def fits(self, other: Unit) -> bool:
        """Tell whether both are units of one kind; an angle is no mere number."""
        return self.dimension == other.dimension and self.si.startswith("rad") == other.si.startswith("rad")


@lru_cache(1024)
def parse_unit(text: str, where: str = "unit", repair: bool = False) -> Unit:
    """Understand a unit.

    Args:
        text: such as ``kPa``, ``g cm^-3`` or ``°/s``.
        where: named in the error.
        repair: whether to read ``kg.^{-3}`` as ``kg/m^3``, with a note.

    Raises:
        InvalidInput: if it is no unit of a physical quantity, or one with an offset, as degC.
    """
    if text in _SI:
        return Unit(text, 1.0, _padded(_SI[text]))
    if text in _TABLE:
        factor, si = _TABLE[text]
        return Unit(si, factor, _padded(_SI[si]))
    repaired = _REPAIRS.get(text.replace(" ", "")) if repair else None
    if repaired is not None:
        return Unit(repaired, 1.0, _padded(_SI[repaired]), f"{where}: {text!r} was read as {repaired}")
    if text.strip().lower() in ("", "-", "none"):
        return parse_unit("")
    return _by_pint(text, where)


def conversion(unit: str, expected: str, where: str) -> float:
    """Return the factor from a unit to the expected one.

    Raises:
        InvalidInput: if the text is no unit, or one of another kind of quantity.
    """
    if unit == expected:
        return 1.0
    found, wanted = parse_unit(unit, f"{where}: unit"), parse_unit(expected, f"{where}: unit")
    if not found.fits(wanted):
        fitting = [name for name in (*_SI, *_TABLE) if name and name != "-" and parse_unit(name).fits(wanted)]
        others = f" ({', '.join(fitting)})" if fitting else ""
        raise InvalidInput(f"{where}: unit", unit, f"a unit that can be converted to {expected}{others}")
    return found.factor / wanted.factor


def _by_pint(text: str, where: str) -> Unit:
    expression = " * ".join(_factors(text, where))
    import pint

    registry = _registry()
    try:
        quantity = registry.Quantity(Fraction(1), expression).to_base_units()
        (registry.Quantity(Fraction(1), expression) * 2).to_base_units()  # an offset unit can not be multiplied
    except (pint.PintError, ValueError, TypeError, ArithmeticError, AttributeError) as error:
        raise InvalidInput(where, text, f"{_VALID} ({error})") from None
    powers = dict(quantity.dimensionality)
    if any(
        power != int(power) or abs(power) > _HIGHEST for power in (*quantity._units.values(), *powers.values())
    ):
        raise InvalidInput(where, text, f"a unit whose powers are whole and at most {_HIGHEST}")
    if not powers.keys() <= set(_BASE):
        raise InvalidInput(where, text, _VALID)
    dimension = tuple(int(powers.get(base, 0)) for base in _BASE)
    si = next((name for name, own in _SI.items() if _padded(own) == dimension and name != "rad/s"), "")
    if si == "1" and _ANGLE.search(expression):
        si = "rad"
    si = si or _spell(quantity)
    return Unit(_COMMON.get(si, si), float(quantity.magnitude), dimension)


def _factors(text: str, where: str) -> Iterator[str]:
    """Yield a unit's text in the form Pint reads, from a closed grammar: a product of named units and powers."""
    clean = text.strip().translate(_SUPERSCRIPTS)
    for old, new in (("**", "^"), ("{", ""), ("}", ""), ("·", "*"), (".", "*"), ("−", "-")):
        clean = clean.replace(old, new)
    if len(clean) > _LONGEST or clean.count("/") > 2 or clean.count("(") > 1:
        raise InvalidInput(where, text, _VALID)
    for place, part in enumerate(clean.replace("(", " ").replace(")", " ").split("/")):
        at, body = 0, part.strip()
        if place == 0 and body == "1":
            continue
        if not body:
            raise InvalidInput(where, text, _VALID)
        while at < len(body):
            match = _TOKEN.match(body, at)
            power = int(match.group(2) or 1) if match else 0
            if match is None or power == 0:
                raise InvalidInput(where, text, _VALID)
            name = match.group(1)
            if name not in _SYMBOLS and name.lower() in _LOWER_CASE:  # "pa" would be years, by Pint
                meant = next(symbol for symbol in _SYMBOLS if symbol.lower() == name.lower())
                raise InvalidInput(where, text, f"{_VALID}; {meant} instead of {name}")
            yield f"{_NAMES.get(name, name)}**{power if place == 0 else -power}"
            at = match.end()
            rest = body[at:].lstrip()
            at = len(body) - len(rest.removeprefix("*").lstrip())


@cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry(non_int_type=Fraction, cache_folder=None)


def _padded(dimension: Dimension) -> Dimension:
    return dimension + (0,) * (len(_BASE) - len(dimension))


def _spell(quantity: Any) -> str:
    """Spell a unit that has no name here, by the units it is made of."""
    parts = []
    for name, power in sorted(quantity._units.items()):
        symbol = f"{_registry().get_symbol(name)}"
        parts.append(symbol if power == 1 else f"{symbol}^{power}")
    return " ".join(parts) or "1"
