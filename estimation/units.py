"""Units at the edge: every unit a file or a reading may carry, with its SI factor and its dimension."""

from __future__ import annotations

from dynamics.errors import InvalidInput, UnknownName

Dimension = tuple[int, int, int]
"""Exponents of kilogram, metre and second."""

_NONE, _MASS, _VOLUME = (0, 0, 0), (1, 0, 0), (0, 3, 0)
_DENSITY, _PRESSURE, _LENGTH = (1, -3, 0), (1, -1, -2), (0, 1, 0)

UNITS: dict[str, tuple[float, Dimension]] = {
    "1": (1.0, _NONE),
    "kg": (1.0, _MASS),
    "g": (1e-3, _MASS),
    "m": (1.0, _LENGTH),
    "mm": (1e-3, _LENGTH),
    "cm": (1e-2, _LENGTH),
    "m^3": (1.0, _VOLUME),
    "cm^3": (1e-6, _VOLUME),
    "mm^3": (1e-9, _VOLUME),
    "l": (1e-3, _VOLUME),
    "kg/m^3": (1.0, _DENSITY),
    "g/cm^3": (1e3, _DENSITY),
    "Pa": (1.0, _PRESSURE),
    "kPa": (1e3, _PRESSURE),
    "MPa": (1e6, _PRESSURE),
    "GPa": (1e9, _PRESSURE),
    "N": (1.0, (1, 1, -2)),
    "N/m": (1.0, (1, 0, -2)),
    "J": (1.0, (1, 2, -2)),
    "s": (1.0, (0, 0, 1)),
}

_SPELLINGS = {
    "": "1",
    "-": "1",
    "kg.m^{-3}": "kg/m^3",
    "kg.m^-3": "kg/m^3",
    "kg m^-3": "kg/m^3",
    "kg*m^-3": "kg/m^3",
    "kg/m3": "kg/m^3",
    "g/cm3": "g/cm^3",
    "m3": "m^3",
    "cm3": "cm^3",
    "mm3": "mm^3",
}


def si_factor(unit: str, where: str) -> float:
    """Return the number that turns a value in this unit into SI.

    Raises:
        UnknownName: if the unit is not in the table.
    """
    return UNITS[spelled(unit, where)][0]


def dimension(unit: str, where: str) -> Dimension:
    """Return the exponents of kilogram, metre and second of a unit.

    Raises:
        UnknownName: if the unit is not in the table.
    """
    return UNITS[spelled(unit, where)][1]


def spelled(unit: str, where: str) -> str:
    """Return the table's spelling of a unit.

    Raises:
        UnknownName: if the unit is not in the table.
    """
    name = _SPELLINGS.get(unit, unit)
    if name not in UNITS:
        raise UnknownName(f"{where}: unit", unit, sorted(UNITS))
    return name


def si_unit(unit: str, where: str) -> str:
    """Return the SI unit of the same dimension.

    Raises:
        UnknownName: if the unit is not in the table.
    """
    own = dimension(unit, where)
    return next(name for name, (factor, exponents) in UNITS.items() if exponents == own and factor == 1.0)


def conversion(unit: str, expected: str, where: str) -> float:
    """Return the factor from a unit to the expected one.

    Raises:
        UnknownName: if the unit is not in the table.
        InvalidInput: if its dimension is another one.
    """
    if unit == expected:
        return 1.0
    if dimension(unit, where) != dimension(expected, where):
        fitting = [name for name, (_, own) in UNITS.items() if own == dimension(expected, where)]
        raise InvalidInput(f"{where}: unit", unit, "a unit that fits: " + ", ".join(fitting))
    return si_factor(unit, where) / si_factor(expected, where)
