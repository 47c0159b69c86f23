import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dynamics.compression import Geometry, geometry_of, stress_strain
from dynamics.errors import InvalidInput, UnknownName
from dynamics.gripper import robotiq_2f85

CUBE = (0.056, 0.056, 0.056)


def test_stress_is_force_over_area_and_strain_compression_over_width():
    g = Geometry("box", 0.05, 0.001, kappa=2.0)
    curve = stress_strain(np.array([0.0, 4.0]), np.array([0.06, 0.04]), g)
    np.testing.assert_allclose(curve.stress, [0.0, 2000.0])
    np.testing.assert_allclose(curve.strain, [-0.2, 0.2])


def test_rules_differ_in_area_as_they_say():
    face = geometry_of("box", CUBE, robotiq_2f85(), rule="face")
    pad = geometry_of("box", CUBE, robotiq_2f85(), rule="pad", poisson=0.0)
    thesis = geometry_of("box", CUBE, robotiq_2f85(), rule="pad-area")
    assert face.area == pytest.approx(0.056**2)
    assert thesis.area == pytest.approx(0.022 * 0.0375)
    assert thesis.area < pad.area < face.area  # a small pad feels more than its own area, less than the face


def test_auto_follows_the_gripper():
    assert geometry_of("box", CUBE, robotiq_2f85("face")) == geometry_of("box", CUBE, robotiq_2f85(), rule="face")


def test_a_whole_body_strained_evenly_has_volume_over_length():
    sphere = geometry_of("sphere", CUBE, robotiq_2f85(), rule="face")
    assert sphere.area * 0.056 == pytest.approx(math.pi / 6 * 0.056**3)


@given(st.floats(1e3, 1e6), st.floats(0.01, 0.08), st.floats(0.0, 0.45), st.floats(1e-4, 5e-3))
def test_sphere_is_two_hertz_contacts_in_series(modulus, diameter, poisson, compression):
    g = geometry_of("sphere", (diameter,) * 3, robotiq_2f85(), poisson=poisson)
    force = modulus * float(g.law_of(np.array([compression / diameter]))[0]) * g.area
    hertz = 4 / 3 * modulus / (1 - poisson**2) * math.sqrt(diameter / 2) * (compression / 2) ** 1.5
    assert force == pytest.approx(hertz, rel=1e-9)


@given(st.floats(0.01, 0.25), st.floats(0.0, 0.45))
def test_cylinder_gives_back_the_published_compression(strain, poisson):
    wide = dataclasses.replace(robotiq_2f85(), pad_width=0.05)
    g = geometry_of("cylinder", (0.05, 0.05, 0.02), wide, poisson=poisson)
    modulus, radius, length = 1e5, 0.025, 0.02
    load = modulus * float(g.law_of(np.array([strain]))[0]) * g.area / length
    half = math.sqrt(4 * load * radius * (1 - poisson**2) / (math.pi * modulus))
    u = 2 * load * (1 - poisson**2) / (math.pi * modulus) * (2 * math.log(4 * radius / half) - 1)
    assert u / (2 * radius) == pytest.approx(strain, rel=1e-3)  # the table's steps are 4 % of load


def test_a_block_softens_under_pads_smaller_than_its_faces():
    strain = np.array([0.1, 0.2])
    pads = geometry_of("box", CUBE, robotiq_2f85("pad"), poisson=0.3)
    free = 1 - 0.022 * 0.0375 / 0.056**2
    np.testing.assert_allclose(pads.law_of(strain), strain - (0.13 + 0.57 * 0.3) * free * strain**2)
    small = geometry_of("box", (0.02, 0.02, 0.03), robotiq_2f85("pad"))
    np.testing.assert_array_equal(small.law_of(strain), strain)  # all of its faces is pressed on
    np.testing.assert_array_equal(geometry_of("box", CUBE, robotiq_2f85("face")).law_of(strain), strain)
    with pytest.raises(InvalidInput, match="softening"):
        Geometry("box", 0.05, 0.001, softening=0.5)


@given(st.floats(0.025, 0.08))
def test_line_contact_grows_until_it_is_as_wide_as_the_pads(diameter):
    gripper = robotiq_2f85()
    g = geometry_of("cylinder", (diameter, diameter, 0.03), gripper)
    load = float(g.law_of(np.array([g.covered]))[0])
    assert diameter / 2 * math.sqrt(4 * load / math.pi) == pytest.approx(gripper.pad_width / 2, rel=1e-3)
    # A stamp of one width is as stiff however deep it presses.
    beyond = g.covered + np.array([0.0, 0.05, 0.1])
    np.testing.assert_allclose(np.diff(g.law_of(beyond)) / 0.05, g.slope_of_law(beyond[1:]), rtol=1e-6)
    assert g.slope_of_law(beyond)[1] == pytest.approx(float(g.slope_of_law(beyond[:1] - 1e-6)[0]), rel=1e-3)


@pytest.mark.parametrize(("law", "softening"), [("linear", 0.0), ("linear", 0.3), ("hertz", 0.0), ("line", 0.0)])
def test_slope_of_a_law_is_its_derivative(law, softening):
    g = Geometry("box", 0.05, 0.001, law=law, softening=softening)
    strain, step = np.linspace(0.02, 0.6 if law == "linear" else 0.3, 40), 2e-3
    by_differences = (g.law_of(strain + step) - g.law_of(strain - step)) / (2 * step)
    np.testing.assert_allclose(g.slope_of_law(strain), by_differences, rtol=0.01)
    assert np.all(g.law_of(-strain) == 0)
    assert np.all(g.slope_of_law(-strain) == 0)


def test_series_compliance_is_strain_per_stress():
    g = Geometry("box", 0.05, 0.001, series_stiffness=2e4, series_stiffness_sd=2e3)
    force = 10.0
    assert g.series_compliance * force / g.area == pytest.approx(force / 2e4 / 0.05)
    assert g.series_compliance_sd == pytest.approx(0.1 * g.series_compliance)


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"width": 56.0}, "width"),
        ({"width": math.nan}, "width"),
        ({"contact_area": 0.0}, "contact area"),
        ({"series_stiffness": -1.0}, "series stiffness"),
        ({"kappa_sd": math.inf}, "kappa_sd"),
        ({"covered": 0.0}, "covered"),
    ],
)
def test_geometry_refuses_what_cannot_be(change, word):
    with pytest.raises(InvalidInput, match=word):
        dataclasses.replace(Geometry("box", 0.05, 0.001), **change)


def test_unknown_shapes_and_rules_are_named():
    with pytest.raises(UnknownName, match="box, cylinder, sphere"):
        geometry_of("cone", CUBE, robotiq_2f85())
    with pytest.raises(UnknownName, match="pad-area"):
        geometry_of("box", CUBE, robotiq_2f85(), rule="thesis")


def test_an_object_wider_than_the_gripper_opens_is_refused():
    with pytest.raises(InvalidInput, match=r"0\.085"):
        geometry_of("box", (0.09, 0.05, 0.05), robotiq_2f85())


@pytest.mark.parametrize(
    ("force", "opening", "word"),
    [
        ([1.0, 2.0], [50.0, 48.0], "metres"),
        ([1e6, 2e6], [0.05, 0.04], "newtons"),
        ([1.0, math.nan], [0.05, 0.04], "nan at 1"),
        ([1.0], [0.05, 0.04], "shapes"),
    ],
)
def test_mixed_up_units_and_broken_series_are_refused(force, opening, word):
    with pytest.raises(InvalidInput, match=word):
        stress_strain(np.array(force), np.array(opening), Geometry("box", 0.05, 0.001))
