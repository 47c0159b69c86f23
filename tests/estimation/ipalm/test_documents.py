"""Documents of the database: read, written, checked, and turned into measurements."""

import json
import math
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dynamics.errors import InvalidInput
from estimation.ipalm import Document, Entry, ObjectInstance, Pose, Value, from_json, to_json
from estimation.ipalm.checks import problems
from estimation.ipalm.documents import entry_of, entry_of_classes, measurements_of
from estimation.measurement import Measurement

GOOD = Document(
    ObjectInstance("ycb", "011_banana", None, "banana", {"origin": "shop"}),
    {"arm": "kinova_gen3", "gripper": "robotiq_2f85"},
    {"robotiq_2f85": {"time": [0.0, 0.1], "position": [0.1, 0.2], "parameters": {"speed": 1}}},
    (
        entry_of(Measurement("density", 560.0, 20.0, "kg/m^3")),
        entry_of_classes("material", {"wood": 0.25, "foam": 0.75}),
    ),
    grasp=Pose((0.1, 0.2, 0.3), (173.3, 0.0, -180.0), True),
    method="weigh",
)

_NUMBERS = st.floats(allow_nan=False, allow_infinity=False)
_JSON = st.recursive(
    st.none() | st.booleans() | _NUMBERS | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=5,
)
_MAYBE = st.none() | st.text()
_FREE = st.dictionaries(st.text(min_size=1).map(lambda name: f"x_{name}"), _JSON, max_size=2)
_VALUES = st.one_of(
    st.builds(Value, st.text(), st.none() | _NUMBERS, st.none() | _NUMBERS, _MAYBE, st.none(), _FREE),
    st.builds(Value, st.text(), probability=_NUMBERS, other=_FREE),
)
_ENTRIES = st.builds(
    Entry, st.text(), st.text(), st.lists(_VALUES, max_size=3).map(tuple), _MAYBE, st.none() | st.booleans()
)
_POSES = st.none() | st.builds(
    Pose,
    st.tuples(_NUMBERS, _NUMBERS, _NUMBERS),
    st.tuples(_NUMBERS, _NUMBERS, _NUMBERS),
    st.none() | st.booleans(),
)
_DOCUMENTS = st.builds(
    Document,
    st.builds(ObjectInstance, _MAYBE, _MAYBE, _MAYBE, _MAYBE, _FREE),
    st.dictionaries(st.text(), st.text(), max_size=3),
    st.dictionaries(st.text(), st.dictionaries(st.text(), _JSON, max_size=3), max_size=2),
    st.lists(_ENTRIES, max_size=3).map(tuple),
    _POSES,
    _POSES,
    _POSES,
    _MAYBE,
    st.booleans(),
    _FREE,
)


@given(_DOCUMENTS)
def test_round_trip(document: Document) -> None:
    assert from_json(to_json(document)) == document


def test_nan_is_kept_on_reading_and_refused_on_strict_writing() -> None:
    odd = replace(GOOD, entries=(Entry("continuous", "elasticity", (Value("elasticity", math.nan, 1.0, "Pa"),)),))
    read = from_json(to_json(odd))
    assert math.isnan(read.entries[0].values[0].mean or 0.0)
    with pytest.raises(ValueError, match="JSON compliant"):
        to_json(odd, allow_nan=False)


def test_a_single_entry_and_the_older_name_of_a_mean_are_read() -> None:
    whole = json.loads(to_json(GOOD))
    entry = {
        "type": "size",
        "name": "size",
        "repository": None,
        "values": [{"name": "x", "value": 3, "std": 1, "units": "cm"}],
    }
    read = from_json(json.dumps({"measurement": whole["measurement"], "entry": entry}))
    assert read.entries[0].values == (Value("x", 3.0, 1.0, "cm"),)
    found, notes = measurements_of(read)
    assert found == (Measurement("x", 0.03, 0.01, "m"),)
    assert not notes


def test_unknown_units_are_never_guessed() -> None:
    document = replace(GOOD, entries=(Entry("continuous", "density", (Value("density", 253.98, 800.0, None),)),))
    found, notes = measurements_of(document)
    assert not found
    assert "unit is unknown" in notes[0]


def test_measurements_go_in_and_come_out() -> None:
    assert problems(GOOD) == ()
    assert measurements_of(from_json(to_json(GOOD))) == ((Measurement("density", 560.0, 20.0, "kg/m^3"),), ())


def _with_value(value: Value, kind: str = "continuous") -> Document:
    return replace(GOOD, entries=(Entry(kind, "e", (value,)),))


@pytest.mark.parametrize(
    ("document", "message"),
    [
        (_with_value(Value("mass", math.nan, 1.0, "kg")), "mean nan"),
        (_with_value(Value("mass", 1.0, None, "kg")), "std None"),
        (_with_value(Value("mass", 1.0, 1.0, "kilogramme")), "valid: a unit"),
        (_with_value(Value("mass", 1.0, 1.0, None)), "unit is unknown"),
        (_with_value(Value("wood", probability=0.9), "categorical"), "sum to 0.9"),
        (_with_value(Value("mass", 1.0, 1.0, "kg"), "number"), "type 'number'"),
        (replace(GOOD, setup={"arm": "kinova gen3"}), "without a space"),
        (replace(GOOD, setup={"arm": "kinova_gen3"}), "would be dropped"),
        (replace(GOOD, sensor_outputs={"kinova_gen3": {"torque": [1.0, math.inf]}}), "not finite"),
        (replace(GOOD, object_instance=ObjectInstance(dataset_id="3")), "without dataset"),
        (replace(GOOD, grasp=Pose((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))), "grasped"),
        (replace(GOOD, setup={}), "no devices"),
        (replace(GOOD, entries=(Entry("size", "", ()),)), "at least one"),
    ],
)
def test_what_the_database_would_spoil_is_found(document: Document, message: str) -> None:
    assert any(message in problem for problem in problems(document)), problems(document)


def _broken(path: list[Any], value: Any) -> str:
    whole = json.loads(to_json(GOOD))
    place = whole
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value
    return json.dumps(whole)


@pytest.mark.parametrize(
    "text",
    [
        "nothing",
        "[]",
        "{}",
        _broken(["measurement"], None),
        _broken(["measurement", "setup"], ["arm"]),
        _broken(["measurement", "setup", "arm"], 3),
        _broken(["measurement", "object_instance"], "banana"),
        _broken(["measurement", "sensor_outputs", "robotiq_2f85"], [1, 2]),
        _broken(["measurement", "grasp", "translation"], [1, 2]),
        _broken(["measurement", "grasp", "rotation"], [1, 2, "x"]),
        _broken(["entries"], {"a": 1}),
        _broken(["entries", 0], 3),
        _broken(["entries", 0, "values"], None),
        _broken(["entries", 0, "name"], None),
        _broken(["entries", 0, "values", 0, "mean"], "560"),
        _broken(["entries", 0, "values", 0, "std"], 10**400),
    ],
)
def test_what_is_no_document_is_refused(text: str) -> None:
    with pytest.raises(InvalidInput, match=r"d\.json"):
        from_json(text, "d.json")
