"""Object files: what a user declares is read as it stands, and every mistake is told in one line."""

import math

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from dynamics.errors import InvalidInput, PalpateError
from dynamics.objects import LONGEST_NAME, read_declared
from models import objects

GOOD = {"size_m": "[0.05, 0.06, 0.07]", "size_sd_m": "0.001", "position_m": "[0.4, -0.1]", "yaw_deg": "30"}


def write(folder, changes=(), extra=""):
    """Write an object file: the good one with some keys changed, or left out where the value is None."""
    keys = {**GOOD, **dict(changes)}
    lines = [f"{key} = {value}" for key, value in keys.items() if value is not None]
    path = folder / "thing.toml"
    path.write_text("\n".join(["[declared]", *lines, extra]) + "\n", encoding="utf-8")
    return path


def test_good_file(tmp_path):
    declared = read_declared(write(tmp_path, {"name": "'a thing'"}, "[truth]\nmass_kg = 'not read here'"))
    assert declared.name == "a thing"
    assert declared.shape == "box"
    assert declared.size == (0.05, 0.06, 0.07)
    assert declared.size_sd == 0.001
    assert declared.position == (0.4, -0.1)
    assert declared.yaw == pytest.approx(math.pi / 6)


def test_name_is_the_files_by_default(tmp_path):
    assert read_declared(write(tmp_path)).name == "thing"


def test_volume_and_its_spread(tmp_path):
    declared = read_declared(write(tmp_path))
    assert declared.volume == pytest.approx(0.05 * 0.06 * 0.07)
    # Monte Carlo: the sd of n samples is known to 1/sqrt(2 n) = 0.3 %; second order is (sd/edge)^2 = 4e-4.
    rng = np.random.default_rng(0)
    edges = np.array(declared.size) + declared.size_sd * rng.standard_normal((50_000, 3))
    assert declared.volume_sd == pytest.approx(edges.prod(axis=1).std(), rel=4 * 0.0032 + 4e-4)


def test_pose_stands_on_the_table_and_is_turned(tmp_path):
    declared = read_declared(write(tmp_path))
    box = declared.box()
    corners = np.array(np.meshgrid(*[[-0.5, 0.5]] * 3)).reshape(3, -1).T * declared.size
    placed = corners @ box.pose[:3, :3].T + box.pose[:3, 3]
    assert placed[:, 2].min() == pytest.approx(0.0, abs=1e-15)
    assert placed[:, 2].max() == pytest.approx(0.07)
    np.testing.assert_allclose(placed.mean(axis=0), [0.4, -0.1, 0.035])
    along = box.pose[:3, :3] @ [1, 0, 0]
    assert math.atan2(along[1], along[0]) == pytest.approx(math.pi / 6)
    assert box.size == declared.size


@pytest.mark.parametrize("name", objects.names())
def test_every_shipped_object_can_be_read(name):
    declared = read_declared(objects.locate(name))
    assert declared.name
    assert objects.about(name)


MISTAKES = [
    ("size_m", None, "no size_m"),
    ("size_m", "[0.05, 0.06]", "3 numbers"),
    ("size_m", "[0.05, 0.06, 0.07, 0.08]", "3 numbers"),
    ("size_m", "0.05", "3 numbers"),
    ("size_m", "['a', 0.06, 0.07]", ">= 0.02"),
    ("size_m", "[true, 0.06, 0.07]", ">= 0.02"),
    ("size_m", "[nan, 0.06, 0.07]", ">= 0.02"),
    ("size_m", "[inf, 0.06, 0.07]", "<= 0.3"),
    ("size_m", "[-0.05, 0.06, 0.07]", ">= 0.02"),
    ("size_m", "[0.0, 0.06, 0.07]", ">= 0.02"),
    ("size_m", "[56.0, 56.0, 56.0]", "<= 0.3"),  # mm
    ("size_sd_m", "0.0", "> 0"),
    ("size_sd_m", "-0.001", "> 0"),
    ("size_sd_m", "nan", "> 0"),
    ("size_sd_m", "[0.001]", "> 0"),
    ("position_m", "[0.5]", "2 numbers"),
    ("position_m", "[0.5, inf]", "<= 0.9"),
    ("position_m", "[9.0, 0.0]", "<= 0.9"),
    ("yaw_deg", "'east'", ">= -180"),
    ("yaw_deg", "false", ">= -180"),
    ("yaw_deg", "1e400", "<= 180"),
    ("yaw_deg", "1" + "0" * 400, "<= 180"),
    ("yaw_deg", "2026-01-01", "<= 180"),
    ("shape", "'torus'", "box"),
    ("shape", "3", "box"),
    ("name", "7", "a text"),
    ("name", "''", "printable"),
    ("name", "'..'", "printable"),
    ("name", "'a/b'", "slashes"),
    ("name", "'../../out'", "slashes"),
    ("name", '"a\\nb"', "printable"),
    ("name", f"'{'x' * (LONGEST_NAME + 1)}'", "printable"),
]


@pytest.mark.parametrize(("key", "value", "valid"), MISTAKES)
def test_mistake_is_told_with_file_key_value_and_what_is_valid(tmp_path, key, value, valid):
    path = write(tmp_path, {key: value})
    with pytest.raises(InvalidInput) as refusal:
        read_declared(path)
    text = str(refusal.value)
    assert len(text.splitlines()) == 1
    for part in (str(path), key, valid):
        assert part in text


@pytest.mark.parametrize(
    ("extra", "named"),
    [
        ("colour = 'red'", "colour"),
        ("mass_kg = 0.1", "mass_kg"),  # truth has no place among what is declared
        ("[declare]\na = 1", "declare"),
        ("[truth]\n[extra]", "extra"),
    ],
)
def test_unknown_key_is_named_with_the_known_ones(tmp_path, extra, named):
    path = write(tmp_path, extra=extra)
    with pytest.raises(InvalidInput, match=f"unknown key {named}") as refusal:
        read_declared(path)
    assert str(path) in str(refusal.value)
    assert "size_m" in str(refusal.value) or "declared" in str(refusal.value)


@pytest.mark.parametrize(
    "content", [b"", b"declared = 3", b"[[declared]]\nsize_m = 1", b"about = 5\n[declared]", b"\x00\xff\x80" * 50]
)
def test_file_without_the_table(tmp_path, content):
    path = tmp_path / "thing.toml"
    path.write_bytes(content)
    with pytest.raises(InvalidInput) as refusal:
        read_declared(path)
    assert str(path) in str(refusal.value)
    assert len(str(refusal.value).splitlines()) == 1


def test_missing_file(tmp_path):
    path = tmp_path / "missing.toml"
    with pytest.raises(InvalidInput, match="readable TOML file") as refusal:
        read_declared(path)
    assert str(path) in str(refusal.value)


NUMBERS = st.one_of(
    st.floats().map(repr),
    st.integers().map(str),
    st.integers(10**300, 10**310).map(str),
    st.floats(-1, 1).map(repr),
)
VALUES = st.one_of(
    NUMBERS,
    st.lists(NUMBERS, max_size=4).map(lambda parts: f"[{', '.join(parts)}]"),
    st.lists(st.floats(0.02, 0.3).map(repr), min_size=2, max_size=3).map(lambda parts: f"[{', '.join(parts)}]"),
    st.sampled_from(["true", "'box'", '"\\u0000"', "2026-01-01", "{}", "[[]]", "", "nan"]),
    st.text(max_size=8),
)
KEYS = st.sampled_from(["name", "shape", "size_m", "size_sd_m", "position_m", "yaw_deg", "colour", "[truth]\na"])


@settings(
    deadline=None,
    derandomize=True,
    max_examples=200,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(changes=st.dictionaries(KEYS, VALUES, max_size=3))
def test_whatever_a_file_holds_only_our_errors_come_out(tmp_path, changes):
    path = tmp_path / "thing.toml"
    keys = {**GOOD, **changes}
    text = "[declared]\n" + "\n".join(f"{key} = {value}" for key, value in keys.items())
    path.write_bytes(text.encode("utf-8", "surrogatepass"))
    try:
        declared, complaint = read_declared(path), ""
    except PalpateError as error:
        declared, complaint = None, str(error)
    if declared is None:
        assert str(path) in complaint
        assert len(complaint.splitlines()) == 1
    else:
        numbers = (*declared.size, declared.size_sd, *declared.position, declared.yaw, declared.volume_sd)
        assert all(math.isfinite(number) for number in numbers)
        assert min(declared.size) >= 0.02
