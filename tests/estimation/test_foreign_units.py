"""Units as files spell them, against factors known by definition."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dynamics.errors import InvalidInput
from estimation.foreign_units import SI_UNITS, factor_to, parse_unit


@pytest.mark.parametrize(
    ("text", "si", "factor"),
    [
        ("kg", "kg", 1.0),
        ("g", "kg", 1e-3),
        ("lb", "kg", 0.45359237),
        ("mm^3", "m^3", 1e-9),
        ("dm^3", "m^3", 1e-3),
        ("g cm^-3", "kg/m^3", 1000.0),
        ("kg m^{-3}", "kg/m^3", 1.0),
        ("kg.m⁻³", "kg/m^3", 1.0),
        ("kg/m^3", "kg/m^3", 1.0),
        ("kg*m**-3", "kg/m^3", 1.0),
        ("kPa", "Pa", 1e3),
        ("N/mm^2", "Pa", 1e6),
        ("kg/(m s^2)", "Pa", 1.0),
        ("N/mm", "N/m", 1e3),
        ("deg", "rad", math.pi / 180),
        ("°", "rad", math.pi / 180),
        ("deg/s", "rad/s", math.pi / 180),
        ("%", "1", 0.01),
        ("", "1", 1.0),
        ("mA", "A", 1e-3),
        ("1/s", "s^-1", 1.0),
    ],
)
def test_units_become_si(text: str, si: str, factor: float) -> None:
    unit = parse_unit(text)
    assert unit.si == si
    assert unit.factor == pytest.approx(factor, rel=1e-15)
    assert not unit.note


def test_the_thesis_spelling_of_density_is_repaired_and_told() -> None:
    unit = parse_unit("kg.^{-3}", "list.json")
    assert (unit.si, unit.factor) == ("kg/m^3", 1.0)
    assert "list.json" in unit.note
    assert "kg.^{-3}" in unit.note


@pytest.mark.parametrize(
    "text",
    ["SI", "degC", "stone throw", "9**9", "m^^2", "kg m^12", "m/s/s/s", "/m", "()", "x" * 99, "__import__('os')"],
)
def test_what_is_no_unit_is_refused(text: str) -> None:
    with pytest.raises(InvalidInput, match="a unit such as"):
        parse_unit(text, "here")


def test_a_unit_of_another_kind_is_refused() -> None:
    assert factor_to("N m", "N mm", "tau") == pytest.approx(1e-3)
    with pytest.raises(InvalidInput, match="converted to rad"):
        factor_to("rad", "kg", "q")


@pytest.mark.parametrize("unit", SI_UNITS)
def test_si_units_are_written_as_they_are_read(unit: str) -> None:
    assert parse_unit(unit).si == unit
    assert parse_unit(unit).factor == 1


@given(st.text(max_size=30))
def test_any_text_is_a_unit_or_refused(text: str) -> None:
    try:
        unit = parse_unit(text)
    except InvalidInput:
        return
    assert parse_unit(unit.si).si == unit.si
    assert math.isfinite(unit.factor)
    assert unit.factor > 0
