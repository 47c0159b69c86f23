import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dynamics.errors import InvalidInput
from estimation.fusion import fuse
from estimation.measurement import Measurement


def readings(values, sds):
    return [Measurement("mass", float(v), float(s), "kg") for v, s in zip(values, sds, strict=True)]


def test_two_readings_are_a_weighted_mean():
    fused = fuse(readings([1.0, 1.3], [0.1, 0.2]))
    weight = np.array([100.0, 25.0])
    assert fused.mean == pytest.approx(float(weight @ [1.0, 1.3] / weight.sum()))
    assert fused.sd == pytest.approx(1 / math.sqrt(weight.sum()))
    assert (fused.property, fused.unit) == ("mass", "kg")


@given(st.floats(-1e6, 1e6), st.floats(1e-3, 1e6))
def test_units_do_not_matter(shift, factor):
    values, sds = np.array([1.0, 1.1, 0.9, 3.0]), np.array([0.1, 0.1, 0.2, 0.1])
    one, other = fuse(readings(values, sds)), fuse(readings(factor * values + shift, factor * sds))
    assert other.mean == pytest.approx(factor * one.mean + shift, rel=1e-6, abs=1e-6 * factor)
    assert other.sd == pytest.approx(factor * one.sd, rel=1e-6)


def test_an_odd_reading_is_weighed_down():
    fused = fuse(readings([1.0, 1.02, 0.98, 1.01, 9.0], [0.02] * 5))
    assert fused.mean == pytest.approx(1.0, abs=0.1)


def test_a_common_error_stays():
    many = readings([1.0] * 100, [0.1] * 100)
    assert fuse(many, common_sd=0.05).sd == pytest.approx(math.hypot(0.05, fuse(many).sd))
    assert fuse(many).sd < 0.012


def test_fused_intervals_hold_the_truth():
    rng = np.random.default_rng(0)
    runs, held = 150, 0
    for _ in range(runs):
        fused = fuse(readings(rng.normal(2.0, 0.3, 4), [0.3] * 4))
        held += abs(fused.mean - 2.0) < 1.96 * fused.sd
    assert held / runs == pytest.approx(0.95, abs=3.3 * math.sqrt(0.95 * 0.05 / runs))


def test_what_cannot_be_fused_is_refused():
    with pytest.raises(InvalidInput, match="at least one"):
        fuse([])
    with pytest.raises(InvalidInput, match="throughout"):
        fuse([*readings([1.0], [0.1]), Measurement("mass", 1000.0, 1.0, "g")])
    with pytest.raises(InvalidInput, match="common_sd"):
        fuse(readings([1.0], [0.1]), common_sd=math.nan)
