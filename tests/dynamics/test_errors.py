"""Errors say where, what and what is valid, on one line of bounded length, whatever the value is."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dynamics.errors import ActionFailed, InvalidInput, MotionRefused, PalpateError, UnknownName


@pytest.mark.parametrize("kind", [InvalidInput, UnknownName, MotionRefused, ActionFailed])
def test_one_base_class(kind):
    assert issubclass(kind, PalpateError)
    assert not issubclass(PalpateError, ValueError)  # nothing that a careless `except ValueError` would swallow


def test_invalid_input_keeps_its_values():
    error = InvalidInput("cube.toml: mass_kg", -1.5, "a number > 0 [kg]")
    assert (error.where, error.found, error.valid) == ("cube.toml: mass_kg", -1.5, "a number > 0 [kg]")
    for part in (error.where, "-1.5", error.valid):
        assert part in str(error)


def test_unknown_name_lists_the_known_ones():
    error = UnknownName("--object", "cub", (name for name in ("cube", "sponge")))
    assert error.known == ("cube", "sponge")
    assert "cube, sponge" in str(error)
    assert "'cub'" in str(error)
    assert "no names" in str(UnknownName("--object", "cub", ()))


def test_action_failed_has_a_reason():
    error = ActionFailed("dropped", "nothing presses back")
    assert error.reason == "dropped"
    assert str(error) == "dropped: nothing presses back"


@settings(deadline=None, derandomize=True)
@given(st.one_of(st.text(), st.binary(max_size=2000), st.lists(st.floats()), st.integers(), st.none()))
def test_any_value_is_told_on_one_short_line(value):
    text = str(InvalidInput("here", value, "something else"))
    assert len(text.splitlines()) == 1
    assert len(text) <= len("here: found ; valid: something else") + 120


def test_long_values_are_cut():
    text = str(InvalidInput("here", "x" * 10_000, "less"))
    assert len(text) < 200
    assert "..." in text
