"""Linear factor graphs: the one place where gtsam's factors are built, because gtsam trusts its caller.

A factor says ``sum_k A_k x_k = b + noise``. Wrong shapes kill the process or give silently wrong answers, a NaN
gives a misleading message: all of it is refused here instead. Robust kernels have no place in a linear graph;
weights enter as standard deviations, by the caller's own reweighting.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dynamics.errors import InvalidInput

Array = NDArray[np.float64]


def key(letter: str, index: int = 0) -> int:
    """Return the key of a variable, such as ``p0`` for ``key("p")``."""
    import gtsam

    return int(gtsam.symbol(letter, index))


@dataclass
class LinearGraph:
    """A Gaussian factor graph of checked factors.

    Attributes:
        dimensions: dimension of every variable, by key.
    """

    dimensions: dict[int, int] = field(default_factory=dict)
    _graph: Any = None

    def add(self, blocks: Mapping[int, Array], b: Array, sigma: Array) -> None:
        """Add one factor.

        Args:
            blocks: the matrix of every variable, (m, dimension of the variable).
            b: right side, (m,).
            sigma: standard deviation of every row, > 0, (m,).

        Raises:
            InvalidInput: for a wrong shape, a number that is not finite, or a sigma <= 0.
        """
        self._check(blocks, b, sigma)
        self.graph.add(*_arguments(blocks, b, sigma))

    def add_prior(self, variable: int, mean: ArrayLike, sigma: ArrayLike) -> None:
        """Add a factor that says x = mean +- sigma, both (dimension,)."""
        center = np.atleast_1d(np.asarray(mean, float))
        self.add({variable: np.eye(len(center))}, center, np.broadcast_to(np.asarray(sigma, float), center.shape))

    @property
    def graph(self) -> Any:
        """The gtsam.GaussianFactorGraph, to be read."""
        if self._graph is None:
            import gtsam

            self._graph = gtsam.GaussianFactorGraph()
        return self._graph

    def solve(self, last: int) -> Solution:
        """Return the most probable values, by QR, a variable of one's choice eliminated last.

        Raises:
            InvalidInput: if the factors leave a variable undetermined.
        """
        import gtsam

        ordering = gtsam.Ordering()
        for variable in (*(k for k in self.dimensions if k != last), last):
            ordering.push_back(variable)
        try:
            return Solution(self.graph.eliminateSequential(ordering, gtsam.EliminateQR))
        except RuntimeError as error:
            raise InvalidInput(
                "factor graph", str(error).split("\n")[0], "factors that fix every variable"
            ) from None

    def _check(self, blocks: Mapping[int, Array], b: Array, sigma: Array) -> None:
        rows = len(b) if np.ndim(b) == 1 else -1
        if rows < 1 or np.shape(sigma) != (rows,):
            raise InvalidInput("factor", f"b {np.shape(b)}, sigma {np.shape(sigma)}", "vectors of one length >= 1")
        if not 1 <= len(blocks) <= 3:  # as many as the binding's signatures take
            raise InvalidInput("factor", f"{len(blocks)} variables", "1 to 3")
        for variable, matrix in blocks.items():
            found = np.shape(matrix)
            columns = self.dimensions.get(variable, found[1] if len(found) == 2 else 0)
            if found != (rows, columns) or columns < 1:
                raise InvalidInput(f"factor: block of {_name(variable)}", f"shape {found}", f"({rows}, {columns})")
        total = float(np.sum(b)) + float(np.sum(sigma)) + sum(float(np.sum(m)) for m in blocks.values())
        if not np.isfinite(total):
            raise InvalidInput("factor", "a number that is not finite", "finite numbers")
        if np.min(sigma) <= 0:
            raise InvalidInput("factor: sigma", float(np.min(sigma)), "numbers > 0")
        for variable, matrix in blocks.items():
            self.dimensions.setdefault(variable, matrix.shape[1])


class Solution:
    """The eliminated graph: the most probable values, and the marginal of the variable eliminated last.

    Attributes:
        root: upper triangular R of that variable's marginal information R^T R, (d, d).
    """

    def __init__(self, net: Any) -> None:
        self._net = net
        self._values = net.optimize()
        self.root: Array = np.array(net.back().R())  # a copy: the binding hands out its own memory

    def __getitem__(self, variable: int) -> Array:
        return np.array(self._values.at(variable))


def linear_container(graph: Any, blocks: Mapping[int, Array], b: Array, sigma: Array) -> None:
    """Add a checked linear factor to a gtsam.NonlinearFactorGraph, for its incremental solvers.

    It is linearised about zero explicitly: without a point gtsam's container says nothing, silently.
    """
    import gtsam

    checked = LinearGraph()
    checked.add(blocks, b, sigma)
    point = gtsam.Values()
    for variable, size in checked.dimensions.items():
        point.insert(variable, np.zeros(size))
    graph.push_back(gtsam.LinearContainerFactor(checked.graph.at(0), point))


def prior_container(graph: Any, variable: int, sigma: Array) -> None:
    """Add a checked factor x = 0 +- sigma to a gtsam.NonlinearFactorGraph."""
    linear_container(graph, {variable: np.eye(len(sigma))}, np.zeros(len(sigma)), sigma)


def _arguments(blocks: Mapping[int, Array], b: Array, sigma: Array) -> list[Any]:
    import gtsam

    parts: list[Any] = []
    for variable, matrix in blocks.items():
        parts += [variable, np.ascontiguousarray(matrix, float)]
    return [*parts, np.ascontiguousarray(b, float), gtsam.noiseModel.Diagonal.Sigmas(np.ascontiguousarray(sigma))]


def _name(variable: int) -> str:
    import gtsam

    return f"{chr(gtsam.symbolChr(variable))}{gtsam.symbolIndex(variable)}"
