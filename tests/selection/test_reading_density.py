"""Predictive densities of readings whose noise depends on the value, and gains from them, against dense grids."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from estimation.belief import Belief
from estimation.network import Network, Property, Relation
from estimation.sensor import Sensor
from selection.information import information_gain, split
from selection.reading_density import reading_columns


def dense(mean: float, sd: float, z: np.ndarray, noise: tuple[float, float], link: str) -> np.ndarray:
    """Return p(z) by a sum over 40001 values of the quantity."""
    t = mean + sd * np.linspace(-9, 9, 40_001)
    x = np.exp(t) if link == "log" else t
    own = np.hypot(noise[0], noise[1] * x)
    prior = np.exp(-0.5 * ((t - mean) / sd) ** 2) / (sd * 2 * math.pi) * (t[1] - t[0]) / own
    return np.array([float(prior @ np.exp(-0.5 * ((value - x) / own) ** 2)) for value in z])


@pytest.mark.parametrize(("sd", "relative"), [(6.0, 0.0), (0.5, 0.0), (1.0, 0.12), (0.1, 0.2), (5.0, 0.4)])
@pytest.mark.parametrize("width", [1e-5, 0.01, 0.22, 0.7, 1.7])
def test_densities_of_log_scale_quantities(sd: float, relative: float, width: float) -> None:
    mean, widths = np.array([np.log(20.0), np.log(7.0)]), np.array([width, 0.55])
    z = np.sort(np.concatenate([np.linspace(-15, 15, 7), [7.0, 20.0], np.geomspace(16, 400, 9)]))
    found = reading_columns(mean, widths**2, z, sd, relative)
    for u in (0, 1):
        expected = dense(mean[u], widths[u], z, (sd, relative), "log")
        np.testing.assert_allclose(found[:, u], expected, rtol=2e-5, atol=2e-8 * expected.max())


@pytest.mark.parametrize(("sd", "relative"), [(0.5, 0.1), (0.2, 0.05), (1.0, 0.3), (20.0, 0.02)])
def test_densities_of_linear_quantities(sd: float, relative: float) -> None:
    mean, widths = np.array([20.0, 7.0, -3.0]), np.array([0.3, 4.0, 2.0])
    z = np.linspace(-20, 40, 31)
    found = reading_columns(mean, widths**2, z, sd, relative, "linear")
    for u in range(3):
        expected = dense(mean[u], widths[u], z, (sd, relative), "linear")
        np.testing.assert_allclose(found[:, u], expected, rtol=2e-5, atol=2e-8 * expected.max())


@pytest.mark.parametrize(
    ("link", "means", "sds", "sd", "relative"),
    [
        ("log", (1.0, 3.0, 8.0), (0.2, 1.5, 0.4), 0.5, 0.0),
        ("log", (1.0, 3.0, 8.0), (0.9, 1.5, 4.0), 0.1, 0.1),
        ("log", (1.0, 3.0, 8.0), (0.9, 1.5, 0.1), 5.0, 0.0),
        ("log", (1.0, 3.0, 8.0), (0.9, 1.5, 4.0), 0.2, 0.3),
        ("linear", (10.0, 11.0, 13.0), (1.0, 2.0, 0.5), 0.5, 0.05),
        ("linear", (1.0, 2.0, 4.0), (0.1, 0.2, 0.4), 0.05, 0.1),
    ],
)
def test_gain_against_a_dense_grid(
    link: str, means: tuple[float, ...], sds: tuple[float, ...], sd: float, relative: float
) -> None:
    prop = Property("x", "material", "1", link, means, sds)
    network = Network("three", ("a", "b", "c"), (prop,), (0.2, 0.5, 0.3), unknown=None)
    if link == "log":
        y = np.arange(math.asinh(-80 / sd), math.asinh(1e4 / sd), 0.02)
        z, q = sd * np.sinh(y), 0.02 * sd * np.cosh(y)
    else:
        z = np.linspace(-5.0, 30.0, 1401)
        q = np.full(len(z), z[1] - z[0])
    pairs = zip(prop.location.tolist(), prop.spread.tolist(), strict=True)
    columns = np.column_stack([dense(m, s, z, (sd, relative), link) for m, s in pairs])
    weight = np.array(network.prior)
    mixed = (columns @ weight)[:, None]
    information = columns * np.log2(np.maximum(columns, 1e-300) / np.maximum(mixed, 1e-300))
    exact = float(q @ information @ weight)
    found = information_gain(Belief(network), Sensor("x", sd, relative))
    assert found == pytest.approx(exact, abs=2e-7)


@settings(max_examples=25, deadline=None)
@given(
    st.sampled_from(["log", "linear"]),
    st.lists(st.tuples(st.floats(1, 30), st.floats(0.05, 0.9)), min_size=1, max_size=4),
    st.floats(0.01, 3),
    st.floats(0.02, 0.4),
    st.floats(1e-5, 1e5),
)
def test_laws_of_information(
    link: str, classes: list[tuple[float, float]], sd: float, relative: float, unit: float
) -> None:
    def gains(factor: float) -> tuple[float, float]:
        means = tuple(factor * mean for mean, _ in classes)
        sds = tuple(factor * mean * share for mean, share in classes)
        names = tuple(f"m{i}" for i in range(len(classes)))
        prop = Property("x", "material", "1", link, means, sds)
        network = Network("some", names, (prop,), (1 / len(names),) * len(names), unknown=None)
        found = split(Belief(network), Sensor("x", factor * sd, relative))
        return found.classes, found.total

    about_class, about_all = gains(1.0)
    assert 0 <= about_class <= min(math.log2(len(classes)), about_all) + 1e-6
    assert gains(unit) == pytest.approx((about_class, about_all), abs=2e-6)


def test_products_of_linear_properties_against_a_dense_grid() -> None:
    """Mass = density x volume with proportional noise, summed over both factors."""
    properties = (
        Property("density", "material", "kg/m^3", "linear", (500.0, 620.0), (40.0, 70.0)),
        Property("volume", None, "m^3", "linear", (2e-4,), (2e-5,)),
    )
    mass = Relation("mass", "product", "kg", (("density", 1.0), ("volume", 1.0)))
    network = Network("mass", ("a", "b"), properties, (0.5, 0.5), relations=(mass,), unknown=None)
    z = np.linspace(-0.02, 0.32, 601)
    u = np.linspace(-8, 8, 81)
    share = np.exp(-0.5 * u**2) / np.exp(-0.5 * u**2).sum()
    columns = np.zeros((len(z), 2))
    for k in range(2):
        true = (properties[0].means[k] + properties[0].sds[k] * u)[:, None] * (2e-4 + 2e-5 * u)
        noise = np.hypot(0.004, 0.05 * true)
        weight = (share[:, None] * share / (noise * math.sqrt(2 * math.pi))).ravel()
        columns[:, k] = np.exp(-0.5 * ((z[:, None] - true.ravel()) / noise.ravel()) ** 2) @ weight
    mixed = columns.mean(axis=1)[:, None]
    information = columns * np.log2(np.maximum(columns, 1e-300) / np.maximum(mixed, 1e-300))
    exact = 0.5 * float(information.sum() * (z[1] - z[0]))
    found = information_gain(Belief(network), Sensor("mass", 0.004, 0.05))
    assert found == pytest.approx(exact, abs=1e-6)
