"""Hertz's contact: the factor of elliptical contacts against the integrals and a published approximation."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from dynamics.compression import geometry_of
from dynamics.errors import InvalidInput
from dynamics.gripper import robotiq_2f85
from dynamics.hertz import approach_factor


def integrals(k):
    """Return K and E of e^2 = 1 - k^2, by quadrature."""
    e2 = 1 - k**2
    first = quad(lambda t: 1 / math.sqrt(1 - e2 * math.sin(t) ** 2), 0, math.pi / 2)[0]
    return first, quad(lambda t: math.sqrt(1 - e2 * math.sin(t) ** 2), 0, math.pi / 2)[0]


@pytest.mark.parametrize("k", [0.99, 0.7, 0.3, 0.1])
def test_against_the_integrals(k):
    """Johnson, Contact Mechanics, eqs. 4.25 to 4.28, from the contact ellipse to the radii instead of back."""
    first, second = integrals(k)
    ratio = (second / k**2 - first) / (first - second)
    f1 = (4 / (math.pi * (1 - k**2))) ** (1 / 3) * math.sqrt(k)
    f1 *= ((second / k**2 - first) * (first - second)) ** (1 / 6)
    assert approach_factor(ratio) == pytest.approx(2 / math.pi * math.sqrt(k) * first / f1, rel=1e-9)


@pytest.mark.parametrize("ratio", [1.0, 1.5, 3.0, 10.0, 30.0])
def test_against_the_approximation_of_the_handbooks(ratio):
    """F2 ~ 1 - ((R1/R2)^0.0684 - 1)^1.531, good to half a percent."""
    assert approach_factor(ratio) == pytest.approx(1 - (ratio**0.0684 - 1) ** 1.531, rel=6e-3)


@pytest.mark.parametrize("ratio", [0.5, -1.0, math.nan, math.inf])
def test_ratio_out_of_range(ratio):
    with pytest.raises(InvalidInput):
        approach_factor(ratio)


def test_ball_is_the_round_ellipsoid():
    size = (0.06, 0.06, 0.06)
    ball, round_one = (geometry_of(s, size, robotiq_2f85("pad"), poisson=0.3) for s in ("sphere", "ellipsoid"))
    assert round_one.area == pytest.approx(ball.area, rel=1e-9)
    # F = 4/3 E / (1 - nu^2) sqrt(R) (u/2)^1.5
    strain = np.array([0.05])
    force = 1e5 * ball.area * ball.law_of(strain)[0]
    assert force == pytest.approx(4 / 3 * 1e5 / 0.91 * math.sqrt(0.03) * (0.06 * 0.05 / 2) ** 1.5, rel=1e-9)


def test_flat_side_of_an_ellipsoid_is_stiffer_than_its_tip():
    gripper = robotiq_2f85("pad")
    flat = geometry_of("ellipsoid", (0.04, 0.08, 0.08), gripper).area * 0.04**-1.5
    tip = geometry_of("ellipsoid", (0.08, 0.04, 0.04), gripper).area * 0.08**-1.5
    # At the same approach u the force goes with sqrt(R): radii 0.08 and 0.01 m, so eightfold radius.
    assert flat / tip == pytest.approx(math.sqrt(8.0), rel=1e-9)


@pytest.mark.parametrize("shape", ["box", "cylinder", "sphere", "ellipsoid", "mesh"])
def test_evenly_strained_body_has_its_mean_section(shape):
    fill = {"box": 1, "cylinder": math.pi / 4, "sphere": math.pi / 6, "ellipsoid": math.pi / 6, "mesh": 0.7}[shape]
    geometry = geometry_of(shape, (0.05, 0.06, 0.07), robotiq_2f85("face"), fill=0.7 if shape == "mesh" else None)
    assert geometry.law == "linear"
    assert geometry.area == pytest.approx(fill * 0.06 * 0.07)


def test_a_mesh_is_the_box_of_its_mean_section_but_less_surely():
    whole = geometry_of("mesh", (0.05, 0.06, 0.07), robotiq_2f85(), fill=1.0)
    box = geometry_of("box", (0.05, 0.06, 0.07), robotiq_2f85())
    assert whole.area == pytest.approx(box.area)
    assert whole.kappa_sd > 0.3 * whole.kappa > box.kappa_sd
    half = geometry_of("mesh", (0.05, 0.06, 0.07), robotiq_2f85(), fill=0.49)
    smaller = geometry_of("box", (0.05, 0.042, 0.049), robotiq_2f85())
    assert half.area == pytest.approx(smaller.area)


def test_mesh_needs_its_fill():
    with pytest.raises(InvalidInput, match="share of the bounding box"):
        geometry_of("mesh", (0.05, 0.06, 0.07), robotiq_2f85())
