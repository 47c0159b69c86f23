"""The belief about one property: a mixture of Gaussians, of the value itself or of its logarithm."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from dynamics.errors import InvalidInput

_SQRT2 = math.sqrt(2.0)
_CANDIDATES = 64  # components whose peaks are searched for the highest
_erf = np.vectorize(math.erf, otypes=[float])


@dataclass(frozen=True, eq=False)
class Mixture:
    """p(x) = sum_k w_k N(x; mean_k, sd_k^2), or the same of ln x on the log scale.

    Attributes:
        weights: probabilities of the components, shape (K,), summing to one.
        means: means of the coordinate x or ln x, shape (K,).
        sds: standard deviations of the coordinate, shape (K,).
        scale: ``linear`` or ``log``.
        unit: SI unit of x.
    """

    weights: np.ndarray
    means: np.ndarray
    sds: np.ndarray
    scale: str = "linear"
    unit: str = ""

    @property
    def mean(self) -> float:
        """Expected value of x [unit]."""
        return float(self.weights @ self._component_means())

    @property
    def sd(self) -> float:
        """Standard deviation of x [unit]."""
        means = self._component_means()
        variances = self.sds**2 if self.scale == "linear" else means**2 * np.expm1(self.sds**2)
        centre = self.weights @ means
        return math.sqrt(float(self.weights @ (variances + (means - centre) ** 2)))

    def density(self, x: np.ndarray | float) -> np.ndarray:
        """Return p(x) [1/unit]; the shape of x."""
        values = np.asarray(x, dtype=float)
        if self.scale == "linear":
            return self._coordinate_density(values)
        positive = values > 0
        safe = np.where(positive, values, 1.0)
        return np.where(positive, self._coordinate_density(np.log(safe)) / safe, 0.0)

    def cdf(self, x: np.ndarray | float) -> np.ndarray:
        """Return P(X <= x); the shape of x."""
        values = np.asarray(x, dtype=float)
        if self.scale == "linear":
            return self._coordinate_cdf(values)
        positive = values > 0
        return np.where(positive, self._coordinate_cdf(np.log(np.where(positive, values, 1.0))), 0.0)

    def quantile(self, probability: float) -> float:
        """Return x with P(X <= x) = probability, by bisection to the last digits [unit].

        Raises:
            InvalidInput: if the probability is not strictly between 0 and 1.
        """
        if not 0 < probability < 1:
            raise InvalidInput("quantile: probability", probability, "a number strictly between 0 and 1")
        used = self.weights > 0
        reach = 40.0 * self.sds[used]
        low, high = float(np.min(self.means[used] - reach)), float(np.max(self.means[used] + reach))
        for _ in range(200):
            middle = 0.5 * (low + high)
            if not low < middle < high:
                break
            if self._coordinate_cdf(np.array(middle)) < probability:
                low = middle
            else:
                high = middle
        return self._value(0.5 * (low + high))

    def interval(self, level: float = 0.9) -> tuple[float, float]:
        """Return the central credible interval that holds this probability [unit]."""
        return self.quantile(0.5 * (1 - level)), self.quantile(0.5 * (1 + level))

    def mode(self) -> float:
        """Return the most probable value: argmax of p(x) [unit]."""
        peak = np.log(np.maximum(self.weights, 1e-300)) - np.log(self.sds)
        if self.scale == "log":
            peak = peak - self.means
        used = np.argsort(-peak, kind="stable")[:_CANDIDATES]
        means, sds = self.means[used], self.sds[used]
        starts = means - sds**2 if self.scale == "log" else means
        fine = np.concatenate([starts + sds * step for step in np.linspace(-2, 2, 33)])
        best = float(fine[np.argmax(self._log_value_density(fine))])
        step = float(sds.min())
        for _ in range(60):
            around = best + step * np.linspace(-1, 1, 9)
            best = float(around[np.argmax(self._log_value_density(around))])
            step *= 0.5
        return self._value(best)

    def _log_value_density(self, u: np.ndarray) -> np.ndarray:
        """Return ln p(x(u)) up to a constant, for coordinates u."""
        z = (u[:, None] - self.means) / self.sds
        with np.errstate(divide="ignore"):
            terms = np.log(self.weights) - np.log(self.sds) - 0.5 * z * z
        top = terms.max(axis=1)
        log = top + np.log(np.exp(terms - top[:, None]).sum(axis=1))
        return np.asarray(log - u if self.scale == "log" else log)

    def _component_means(self) -> np.ndarray:
        if self.scale == "linear":
            return self.means
        return np.asarray(np.exp(self.means + 0.5 * self.sds**2))

    def _coordinate_density(self, u: np.ndarray) -> np.ndarray:
        z = (u[..., None] - self.means) / self.sds
        return np.asarray((np.exp(-0.5 * z * z) / (self.sds * math.sqrt(2 * math.pi))) @ self.weights)

    def _coordinate_cdf(self, u: np.ndarray) -> np.ndarray:
        return np.asarray((0.5 * (1 + _erf((u[..., None] - self.means) / (self.sds * _SQRT2)))) @ self.weights)

    def _value(self, u: float) -> float:
        return math.exp(u) if self.scale == "log" else u
