"""The table of units: factors, dimensions, and what does not fit."""

from __future__ import annotations

import pytest

from dynamics.errors import InvalidInput, UnknownName
from estimation import units


@pytest.mark.parametrize(
    ("unit", "expected", "factor"),
    [
        ("kPa", "Pa", 1e3),
        ("GPa", "Pa", 1e9),
        ("g", "kg", 1e-3),
        ("cm^3", "m^3", 1e-6),
        ("g/cm^3", "kg/m^3", 1e3),
        ("kg.m^{-3}", "kg/m^3", 1.0),
        ("-", "1", 1.0),
        ("mm", "m", 1e-3),
    ],
)
def test_factors(unit: str, expected: str, factor: float) -> None:
    assert units.conversion(unit, expected, "here") == pytest.approx(factor, rel=1e-15)
    assert units.si_unit(unit, "here") == expected


def test_refusals() -> None:
    with pytest.raises(UnknownName, match="stone"):
        units.si_factor("stone", "here")
    with pytest.raises(InvalidInput, match="a unit that fits: Pa, kPa"):
        units.conversion("kg", "Pa", "here")
