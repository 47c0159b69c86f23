"""Units as files spell them, against factors known by definition."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dynamics.errors import InvalidInput
from estimation.units import SI_UNITS, conversion, parse_unit


@pytest.mark.parametrize(
    ("text", "si", "factor"),
    [
        ("kg", "kg", 1.0),
        ("g", "kg", 1e-3),
        ("lb", "kg", 0.45359237),
        ("cm^3", "m^3", 1e-6),
        ("mm^3", "m^3", 1e-9),
        ("dm^3", "m^3", 1e-3),
        ("g/cm^3", "kg/m^3", 1000.0),
        ("g cm^-3", "kg/m^3", 1000.0),
        ("kg m^{-3}", "kg/m^3", 1.0),
        ("kg.m^{-3}", "kg/m^3", 1.0),
        ("kg.m⁻³", "kg/m^3", 1.0),
        ("kg/m^3", "kg/m^3", 1.0),
        ("kg*m**-3", "kg/m^3", 1.0),
        ("kPa", "Pa", 1e3),
        ("GPa", "Pa", 1e9),
        ("N/mm^2", "Pa", 1e6),
        ("kg/(m s^2)", "Pa", 1.0),
        ("N/mm", "N/m", 1e3),
        ("deg", "rad", math.pi / 180),
        ("°", "rad", math.pi / 180),
        ("deg/s", "rad/s", math.pi / 180),
        ("%", "1", 0.01),
        ("", "1", 1.0),
        ("-", "1", 1.0),
        (" None ", "1", 1.0),
        ("mA", "A", 1e-3),
        ("1/s", "s^-1", 1.0),
        ("W/(m K)", "K^-1 kg m s^-3", 1.0),
    ],
)
def test_units_become_si(text: str, si: str, factor: float) -> None:
    unit = parse_unit(text)
    assert unit.si == si
    assert unit.factor == pytest.approx(factor, rel=1e-15)
    assert not unit.note


def test_the_table_agrees_with_pint() -> None:
    from estimation import units

    for text in set(units._TABLE) - {"", "-", "none", "m3", "cm3", "mm3", "g/cm3", "kg/m3"}:
        assert units._by_pint(text, "here") == parse_unit(text)
    for text in SI_UNITS:
        if text != "1":
            assert units._by_pint(text, "here").dimension == parse_unit(text).dimension


def test_the_thesis_spelling_of_density_is_repaired_where_asked_for_and_told() -> None:
    unit = parse_unit("kg.^{-3}", "list.json", repair=True)
    assert (unit.si, unit.factor) == ("kg/m^3", 1.0)
    assert "list.json" in unit.note
    assert "kg.^{-3}" in unit.note
    with pytest.raises(InvalidInput, match="a unit such as"):
        parse_unit("kg.^{-3}")


@pytest.mark.parametrize(
    "text",
    ["SI", "degC", "lump", "9**9", "m^^2", "kg m^12", "m/s/s/s", "/m", "()", "x" * 99, "__import__('os')"],
)
def test_what_is_no_unit_is_refused(text: str) -> None:
    with pytest.raises(InvalidInput, match="a unit such as"):
        parse_unit(text, "here")


@pytest.mark.parametrize(("text", "meant"), [("pa", "Pa"), ("Kpa", "kPa"), ("mpa", "MPa"), ("n/m", "N")])
def test_wrong_case_is_no_other_unit(text: str, meant: str) -> None:
    with pytest.raises(InvalidInput, match=f"{meant} instead of"):
        parse_unit(text)


def test_units_of_one_kind_are_converted_and_others_refused() -> None:
    assert conversion("kPa", "Pa", "here") == 1e3
    assert conversion("kPa", "MPa", "here") == pytest.approx(1e-3)
    assert conversion("N mm", "N m", "tau") == pytest.approx(1e-3)
    with pytest.raises(InvalidInput, match="converted to rad"):
        conversion("kg", "rad", "q")
    with pytest.raises(InvalidInput, match="converted to rad"):
        conversion("%", "rad", "q")
    with pytest.raises(InvalidInput, match=r"here: unit: found 'kg'; .*Pa, kPa"):
        conversion("kg", "Pa", "here")


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
