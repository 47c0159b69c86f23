"""Tables of files from outside: what is good comes through, whatever else there is ends in one plain line."""

import math
from datetime import date

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from dynamics.errors import InvalidInput, PalpateError
from dynamics.tables import MAX_BYTES, Table, read_toml

FUZZ = settings(
    deadline=None,
    derandomize=True,
    max_examples=150,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)


def refused(call, *parts):
    """Check that a call is refused in one line that holds some parts."""
    with pytest.raises(InvalidInput) as refusal:
        call()
    text = str(refusal.value)
    assert len(text.splitlines()) == 1
    assert "valid: " in text
    for part in parts:
        assert part in text, text
    return refusal.value


def outcome(call):
    """Return what a call returns, and what it complains of; anything but our own errors passes through."""
    try:
        return call(), ""
    except PalpateError as error:
        return None, str(error)


def written(folder, content):
    path = folder / "thing.toml"
    path.write_bytes(content)
    return path


def test_reads_toml(tmp_path):
    text = "about = 'a \u00e9'\r\n[a]\r\nb = 1.5\r\nc = [1, 2]\r\n".encode()
    assert read_toml(written(tmp_path, text)) == {"about": "a \u00e9", "a": {"b": 1.5, "c": [1, 2]}}
    assert read_toml(written(tmp_path, b"")) == {}


@pytest.mark.parametrize(
    "content",
    [
        b"a = ",
        b"a = 1\na = 2",
        b"[a",
        b"a = nan0",
        b"\xff\xfe\x00\x01" * 20,
        bytes(range(256)),
        b"a = '\x00'",
        b'{"a": 1}',
        b"a = " + b"[" * 20_000,
        b"a = " + b"9" * 100_000,
        b"a = 2026-13-45",
    ],
    ids=lambda content: repr(content[:12]),
)
def test_file_that_is_no_toml(tmp_path, content):
    path = written(tmp_path, content)
    refused(lambda: read_toml(path), str(path), "a TOML file")


def test_file_that_cannot_be_read(tmp_path):
    for path in (tmp_path / "missing.toml", tmp_path, tmp_path / "missing" / "thing.toml"):
        refused(lambda path=path: read_toml(path), str(path), "a readable TOML file")
    refused(lambda: read_toml(tmp_path / "nul\0.toml"))
    refused(lambda: read_toml(tmp_path / ("x" * 5000)))


def test_huge_file(tmp_path):
    path = written(tmp_path, b"# comment\n" * (MAX_BYTES // 10))
    assert read_toml(path) == {}
    path.write_bytes(b"# comment\n" * (MAX_BYTES // 10) + b"\n")
    refused(lambda: read_toml(path), str(path), str(MAX_BYTES))


def test_numbers():
    table = Table("cube.toml", {"mass_kg": 1, "size_m": [1, 2.5], "sd": 0.0})
    mass = table.number("mass_kg", above=0.0)
    assert mass == 1.0
    assert isinstance(mass, float)
    assert table.numbers("size_m", 2) == (1.0, 2.5)
    assert table.number("sd", at_least=0.0) == 0.0
    assert table.number("missing", 3.0) == 3.0
    assert table.numbers("gone", 2, (3.0, 4.0)) == (3.0, 4.0)
    table.done()


NO_NUMBERS = (
    True,
    False,
    "1.0",
    None,
    [],
    [1.0],
    {},
    math.nan,
    math.inf,
    -math.inf,
    10**400,
    -(10**400),
    date.min,
)


@pytest.mark.parametrize("value", NO_NUMBERS, ids=lambda value: repr(value)[:12])
def test_value_that_is_no_number(value):
    table = Table("cube.toml", {"mass_kg": value, "size_m": [1.0, value]})
    refused(lambda: table.number("mass_kg", above=0.0, unit="kg"), "cube.toml: mass_kg", "> 0", "[kg]")
    refused(lambda: table.numbers("size_m", 2, unit="m"), "cube.toml: size_m", "a number", "[m]")


@pytest.mark.parametrize("value", [-1, -1e-9, 0, 2.0000001, 3])
def test_number_out_of_bounds(value):
    table = Table("cube.toml", {"mass_kg": value})
    error = refused(lambda: table.number("mass_kg", above=0.0, at_most=2.0), "mass_kg", "> 0 and <= 2")
    assert error.found == value


def test_bounds_themselves():
    table = Table("x", {"a": 1.0})
    assert table.number("a", at_least=1.0, at_most=1.0) == 1.0
    refused(lambda: table.number("a", above=1.0), "> 1")


@pytest.mark.parametrize("value", [1.0, "ab", {}, [], [1.0], [1.0, 2.0, 3.0], {"a": 1, "b": 2}, None, True])
def test_list_of_the_wrong_length(value):
    table = Table("cube.toml", {"size_m": value})
    refused(lambda: table.numbers("size_m", 2, unit="m"), "cube.toml: size_m", "a list of 2 numbers [m]")


def test_missing_key():
    table = Table("cube.toml", {})
    refused(lambda: table.number("mass_kg"), "cube.toml", "no mass_kg")
    refused(lambda: table.numbers("size_m", 3), "no size_m")
    refused(lambda: table.text("shape"), "no shape")
    refused(lambda: table.table("declared"), "no table [declared]")


def test_text():
    table = Table("cube.toml", {"shape": "box", "other": 3})
    assert table.text("shape", choices=("box", "ball")) == "box"
    assert table.text("name", "default") == "default"
    refused(lambda: table.text("shape", choices=("ball", "rod")), "cube.toml: shape", "'box'", "ball, rod")
    refused(lambda: table.text("other"), "cube.toml: other", "3", "a text")


def test_unknown_keys_are_named_with_the_known_ones():
    table = Table("cube.toml", {"mass_kg": 1.0, "masss": 2.0})
    table.number("mass_kg")
    table.has("about")
    refused(table.done, "cube.toml", "unknown key masss", "about, mass_kg")


def test_tables_within():
    table = Table("cube.toml", {"declared": {"a": 1.0}, "truth": 5})
    inner = table.table("declared")
    assert inner.number("a") == 1.0
    inner.done()
    refused(lambda: table.table("truth"), "cube.toml [truth]", "5", "a table")
    for content in (None, 3, "text", [1], True):
        refused(lambda content=content: Table("cube.toml", content), "a table")


# Anything that a TOML file may hold, and numbers beyond what it should.
LEAVES = st.one_of(
    st.booleans(), st.integers(), st.integers(10**300, 10**320), st.floats(), st.text(max_size=20), st.dates()
)
VALUES = st.recursive(
    LEAVES, lambda x: st.one_of(st.lists(x, max_size=4), st.dictionaries(st.text(max_size=5), x, max_size=3))
)


@FUZZ
@given(st.dictionaries(st.sampled_from(["a", "b", "c", "d", "zz"]), VALUES))
def test_whatever_a_table_holds_only_our_errors_come_out(content):
    table = Table("x.toml", content)
    number, complaint = outcome(lambda: table.number("a", above=0.0, at_most=1e6))
    assert complaint or (type(number) is float and 0 < number <= 1e6)
    numbers, more = outcome(lambda: table.numbers("b", 3, at_least=-1.0))
    assert more or (len(numbers) == 3 and all(math.isfinite(x) and x >= -1 for x in numbers))
    text, still = outcome(lambda: table.text("c"))
    assert still or isinstance(text, str)
    told = [complaint, more, still, outcome(lambda: table.table("d"))[1], outcome(table.done)[1]]
    assert all(len(line.splitlines()) <= 1 for line in told)


@FUZZ
@given(
    content=st.one_of(
        st.binary(max_size=200), st.text(alphabet="ab=[]{}\"'.,0123456789eE+-_\n #tf").map(str.encode)
    )
)
def test_whatever_bytes_a_file_holds_only_our_errors_come_out(tmp_path, content):
    path = written(tmp_path, content)
    found, complaint = outcome(lambda: read_toml(path))
    assert isinstance(found, dict) or (str(path) in complaint and len(complaint.splitlines()) == 1)
