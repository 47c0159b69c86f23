"""Measurement lists: what is written is read back, and what others write is read as far as it can be."""

import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dynamics.errors import InvalidInput
from estimation.ipalm import MeasuredObject, from_list, to_list
from estimation.measurement import Measurement
from estimation.units import SI_UNITS

LISTING_2 = """[{"object_name": "item", "object_id": "1", "measurements": [
  {"name": "density", "value": {"sigma": 1000, "mean": 7337.799079987667, "units": "kg.^{-3}"}},
  {"name": "elasticity", "value": {"sigma": 1000, "mean": 4969.761122576146, "units": "Pa"}}]}]"""

_NUMBERS = st.floats(allow_nan=False, allow_infinity=False)
_MEASUREMENTS = st.builds(
    Measurement, st.text(), _NUMBERS, st.floats(5e-324, 1.7e308, allow_subnormal=True), st.sampled_from(SI_UNITS)
)
_OBJECTS = st.builds(
    MeasuredObject, st.text(), st.none() | st.text(), st.lists(_MEASUREMENTS, max_size=3).map(tuple)
)


@given(st.lists(_OBJECTS, max_size=3))
def test_round_trip(objects: list[MeasuredObject]) -> None:
    read = from_list(to_list(objects))
    assert list(read.objects) == objects
    assert not read.notes


def test_the_thesis_listing_is_read_and_written_clean() -> None:
    read = from_list(LISTING_2, "listing.json")
    (item,) = read.objects
    assert (item.name, item.object_id) == ("item", "1")
    assert item.measurements == (
        Measurement("density", 7337.799079987667, 1000.0, "kg/m^3"),
        Measurement("elasticity", 4969.761122576146, 1000.0, "Pa"),
    )
    assert len(read.notes) == 1
    assert "kg.^{-3}" in read.notes[0]
    clean = json.loads(to_list(read.objects))
    assert [m["value"]["units"] for m in clean[0]["measurements"]] == ["kg/m^3", "Pa"]
    assert from_list(to_list(read.objects)).objects == read.objects


def test_other_units_are_converted() -> None:
    value = {"mean": 0.5, "sigma": 0.1, "units": "g cm^-3"}
    text = json.dumps([{"object_name": "a", "measurements": [{"name": "density", "value": value}]}])
    assert from_list(text).objects[0].measurements == (Measurement("density", 500.0, 100.0, "kg/m^3"),)


@pytest.mark.parametrize(
    "value",
    [
        {"mean": math.nan, "sigma": 1.0, "units": "Pa"},
        {"mean": 1.0, "sigma": 0.0, "units": "Pa"},
        {"mean": 1.0, "sigma": None, "units": "Pa"},
        {"mean": True, "sigma": 1.0, "units": "Pa"},
        {"mean": "1", "sigma": 1.0, "units": "Pa"},
        {"mean": 10**400, "sigma": 1.0, "units": "Pa"},
        {"mean": 1.0, "sigma": 1.0, "units": None},
        {"mean": 1.0, "sigma": 1.0, "units": "smoots"},
        {"mean": 1e308, "sigma": 1.0, "units": "GPa"},
        {},
    ],
)
def test_a_value_that_says_nothing_is_left_out_and_told(value: dict[str, object]) -> None:
    good = {"mean": 1.0, "sigma": 1.0, "units": "kg"}
    listed = [{"name": "elasticity", "value": value}, {"name": "mass", "value": good}]
    read = from_list(json.dumps([{"object_name": "a", "measurements": listed}]), "a.json")
    assert [m.property for m in read.objects[0].measurements] == ["mass"]
    assert len(read.notes) == 1
    assert "left out" in read.notes[0]
    assert "a.json" in read.notes[0]


@pytest.mark.parametrize(
    "text",
    [
        "",
        "{}",
        "[1]",
        '[{"object_name": "a"}]',
        '[{"object_name": 3, "measurements": []}]',
        '[{"object_name": "a", "measurements": [{"name": "mass"}]}]',
        '[{"object_name": "a", "measurements": [{"name": 1, "value": {}}]}]',
        "[" * 100_000,
    ],
)
def test_what_is_no_list_is_refused(text: str) -> None:
    with pytest.raises(InvalidInput, match=r"x\.json"):
        from_list(text, "x.json")
