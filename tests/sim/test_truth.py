"""What an object really is, read from its file: physics in range, and every mistake told in one line."""

import math

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from dynamics.errors import InvalidInput, PalpateError
from dynamics.objects import read_declared
from models import objects
from sim.truth import read_truth

DECLARED = "[declared]\nsize_m = [0.05, 0.06, 0.07]\n[truth]\n"
GOOD = {"mass_kg": "0.21", "young_modulus_pa": "5e4", "material": "'foam'"}


def write(folder, changes=()):
    keys = {**GOOD, **dict(changes)}
    path = folder / "thing.toml"
    lines = [f"{key} = {value}" for key, value in keys.items() if value is not None]
    path.write_bytes((DECLARED + "\n".join(lines) + "\n").encode("utf-8", "surrogatepass"))
    return path


def test_good_file(tmp_path):
    truth = read_truth(write(tmp_path))
    assert truth.declared == read_declared(tmp_path / "thing.toml")
    assert truth.size == truth.declared.size
    assert (truth.mass, truth.young_modulus, truth.material) == (0.21, 5e4, "foam")
    assert truth.volume == pytest.approx(0.05 * 0.06 * 0.07)
    assert truth.density == pytest.approx(1000.0)


def test_true_size_may_differ_from_the_declared_one(tmp_path):
    truth = read_truth(write(tmp_path, {"size_m": "[0.051, 0.06, 0.07]"}))
    assert truth.size == (0.051, 0.06, 0.07)
    assert truth.declared.size == (0.05, 0.06, 0.07)


@pytest.mark.parametrize("name", objects.names())
def test_every_shipped_object_can_be_read(name):
    truth = read_truth(objects.locate(name))
    assert 0.004 <= truth.mass <= 1.0
    assert 5e3 <= truth.young_modulus <= (1e12 if truth.is_rigid else 1e6)


@pytest.mark.parametrize(
    ("key", "value", "valid"),
    [
        ("mass_kg", None, "no mass_kg"),
        ("mass_kg", "-0.1", ">= 0.002"),
        ("mass_kg", "0", ">= 0.002"),
        ("mass_kg", "100", "<= 1.2"),  # grams
        ("mass_kg", "nan", ">= 0.002"),
        ("mass_kg", "inf", "<= 1.2"),
        ("mass_kg", "true", ">= 0.002"),
        ("mass_kg", "'0.1'", ">= 0.002"),
        ("mass_kg", "1" + "0" * 400, "<= 1.2"),
        ("young_modulus_pa", None, "no young_modulus_pa"),
        ("young_modulus_pa", "50", ">= 4000"),  # kPa
        ("young_modulus_pa", "-nan", "Pa"),
        ("young_modulus_pa", "[5e4]", "Pa"),
        ("poisson", "0.5", "<= 0.45"),
        ("friction", "0.0", ">= 0.2"),
        ("damping_s", "-0.001", ">= 0"),
        ("size_m", "[0.05, 0.06]", "3 numbers"),
        ("size_m", "[0.05, 0.06, 56]", "<= 0.3"),
        ("material", "3", "a text"),
        ("mass", "0.1", "mass_kg"),
    ],
)
def test_mistake_is_told_with_file_key_and_what_is_valid(tmp_path, key, value, valid):
    path = write(tmp_path, {key: value})
    with pytest.raises(InvalidInput) as refusal:
        read_truth(path)
    text = str(refusal.value)
    assert len(text.splitlines()) == 1
    for part in (str(path), "truth", key, valid):
        assert part in text


@pytest.mark.parametrize("content", [b"", b"\xff" * 100, DECLARED.split("[truth]")[0].encode(), b"truth = 3"])
def test_file_without_truth(tmp_path, content):
    path = tmp_path / "thing.toml"
    path.write_bytes(content)
    with pytest.raises(InvalidInput) as refusal:
        read_truth(path)
    assert str(path) in str(refusal.value)


VALUES = st.one_of(
    st.floats().map(repr),
    st.integers().map(str),
    st.floats(0, 1.5).map(repr),
    st.floats(1e3, 2e6).map(repr),
    st.sampled_from(["true", "[]", "{}", "''", "nan", "9" * 400, "2026-01-01"]),
    st.text(max_size=6),
)
KEYS = st.sampled_from(
    ["mass_kg", "young_modulus_pa", "poisson", "friction", "damping_s", "size_m", "material", "a"]
)


@settings(
    deadline=None,
    derandomize=True,
    max_examples=200,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(changes=st.dictionaries(KEYS, VALUES, max_size=3))
def test_whatever_a_file_holds_only_our_errors_come_out(tmp_path, changes):
    path = write(tmp_path, changes)
    try:
        truth, complaint = read_truth(path), ""
    except PalpateError as error:
        truth, complaint = None, str(error)
    if truth is None:
        assert str(path) in complaint
        assert len(complaint.splitlines()) == 1
    else:
        assert 0.002 <= truth.mass <= 1.2
        assert 4e3 <= truth.young_modulus <= 1e12
        assert all(math.isfinite(x) for x in (truth.poisson, truth.friction, truth.damping, truth.density))


@pytest.mark.parametrize(
    ("declared", "truth", "found"),
    [
        ("shape = 'sphere'\ndiameter_m = 0.06", "shape = 'box'", "shape"),
        ("shape = 'sphere'\ndiameter_m = 0.06", "size_m = [0.06, 0.06, 0.06]", "unknown key size_m"),
        ("shape = 'sphere'\ndiameter_m = 0.06", "diameter_m = 0.065", "standard deviations"),
        ("shape = 'cylinder'\ndiameter_m = 0.06\nheight_m = 0.08", "height_m = 0.07", "standard deviations"),
        ("size_m = [0.05, 0.06, 0.07]", "size_m = [0.06, 0.05, 0.07]", "standard deviations"),
        ("size_m = [0.05, 0.06, 0.07]", "young_modulus_pa = 1e13", "<= 1e+12"),
        ("size_m = [0.05, 0.06, 0.07]", "young_modulus_pa = 1e9\nyield_strain = 0.1", "yield_strain"),
        ("size_m = [0.05, 0.06, 0.07]", "yield_strain = -0.1", ">= 0"),
    ],
)
def test_truth_that_contradicts_what_is_declared_is_refused(tmp_path, declared, truth, found):
    path = tmp_path / "thing.toml"
    modulus = "" if "young" in truth else "young_modulus_pa = 5e4\n"
    path.write_text(f"[declared]\n{declared}\n[truth]\nmass_kg = 0.1\n{modulus}{truth}\n")
    with pytest.raises(InvalidInput) as refusal:
        read_truth(path)
    assert str(path) in str(refusal.value)
    assert found in str(refusal.value)
    assert len(str(refusal.value).splitlines()) == 1


def test_true_lengths_of_a_shape_may_differ_a_little(tmp_path):
    path = tmp_path / "thing.toml"
    path.write_text(
        "[declared]\nshape = 'sphere'\ndiameter_m = 0.06\n"
        "[truth]\nmass_kg = 0.1\nyoung_modulus_pa = 5e4\ndiameter_m = 0.061\n"
    )
    truth = read_truth(path)
    assert truth.size == (0.061,) * 3
    assert truth.volume == pytest.approx(math.pi / 6 * 0.061**3)
