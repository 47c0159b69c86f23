"""The checked helper refuses what would crash or mislead gtsam, and solves like numpy."""

import gtsam
import numpy as np
import pytest

from dynamics.errors import InvalidInput
from estimation.graph import LinearGraph, key, linear_container, prior_container

X, Y = key("x"), key("y")


def test_solution_and_information_equal_numpy():
    rng = np.random.default_rng(0)
    a, b, right = rng.normal(size=(9, 3)), rng.normal(size=(9, 2)), rng.normal(size=9)
    sigma = rng.uniform(0.1, 2, 9)
    graph = LinearGraph()
    graph.add({X: a[:4], Y: b[:4]}, right[:4], sigma[:4])
    graph.add({Y: b[4:], X: a[4:]}, right[4:], sigma[4:])
    graph.add_prior(X, np.ones(3), 0.5)
    rows = np.vstack([np.hstack([a, b]) / sigma[:, None], np.hstack([2 * np.eye(3), np.zeros((3, 2))])])
    expected = np.linalg.lstsq(rows, np.concatenate([right / sigma, np.full(3, 2.0)]), rcond=None)[0]
    solution = graph.solve(last=X)
    np.testing.assert_allclose(np.concatenate([solution[X], solution[Y]]), expected, atol=1e-12)
    covariance = np.linalg.inv(rows.T @ rows)[:3, :3]
    np.testing.assert_allclose(np.linalg.inv(solution.root.T @ solution.root), covariance, atol=1e-12)


@pytest.mark.parametrize(
    ("blocks", "b", "sigma"),
    [
        ({X: np.ones((2, 3))}, np.ones(3), np.ones(3)),
        ({X: np.ones((3, 3))}, np.ones(3), np.ones(2)),
        ({X: np.ones(3)}, np.ones(3), np.ones(3)),
        ({X: np.ones((3, 0))}, np.ones(3), np.ones(3)),
        ({X: np.ones((3, 2))}, np.ones((3, 1)), np.ones(3)),
        ({X: np.ones((0, 2))}, np.ones(0), np.ones(0)),
        ({X: np.full((3, 2), np.nan)}, np.ones(3), np.ones(3)),
        ({X: np.ones((3, 2))}, np.array([1, np.inf, 1]), np.ones(3)),
        ({X: np.ones((3, 2))}, np.ones(3), np.array([1, 0, 1.0])),
        ({X: np.ones((3, 2))}, np.ones(3), np.array([1, -1, 1.0])),
        ({}, np.ones(3), np.ones(3)),
        ({key("a", i): np.ones((3, 2)) for i in range(4)}, np.ones(3), np.ones(3)),
    ],
)
def test_bad_factor_is_refused_and_leaves_no_trace(blocks, b, sigma):
    graph = LinearGraph()
    with pytest.raises(InvalidInput):
        graph.add(blocks, b, sigma)
    assert graph.dimensions == {}
    assert graph.graph.size() == 0


def test_a_variable_keeps_its_dimension():
    graph = LinearGraph()
    graph.add_prior(X, np.zeros(2), 1.0)
    with pytest.raises(InvalidInput, match="x0"):
        graph.add_prior(X, np.zeros(3), 1.0)


def test_undetermined_variable_is_named_as_such():
    graph = LinearGraph()
    graph.add({X: np.ones((1, 2))}, np.zeros(1), np.ones(1))
    with pytest.raises(InvalidInput, match="factors that fix every variable"):
        graph.solve(last=X)


def test_container_is_heard_by_nonlinear_solvers():
    graph, start = gtsam.NonlinearFactorGraph(), gtsam.Values()
    linear_container(graph, {X: np.diag([1.0, 2.0])}, np.array([3.0, 4.0]), np.ones(2))
    prior_container(graph, X, np.full(2, 1e3))
    start.insert(X, np.zeros(2))
    found = gtsam.GaussNewtonOptimizer(graph, start).optimize().atVector(X)
    np.testing.assert_allclose(found, [3, 2], rtol=1e-5)
