"""What an action's reading tells: a Gaussian reading of a quantity, or a class named by a classifier."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from dynamics.errors import InvalidInput, UnknownName


@dataclass(frozen=True)
class Sensor:
    """A reading z = x + e of a property or relation x, with e ~ N(0, sd^2 + (relative_sd x)^2).

    Attributes:
        property: name of the property or relation read.
        sd: constant part of the noise [SI unit of the property], >= 0.
        relative_sd: part of the noise proportional to the value [-], >= 0.

    Raises:
        InvalidInput: if a part is negative, not finite, or both are zero.
    """

    property: str
    sd: float
    relative_sd: float = 0.0

    def __post_init__(self) -> None:
        where = f"sensor of {self.property}"
        for key, value in (("sd", self.sd), ("relative_sd", self.relative_sd)):
            if not (math.isfinite(value) and value >= 0):
                raise InvalidInput(f"{where}: {key}", value, "a finite number >= 0")
        if self.sd == 0 and self.relative_sd == 0:
            raise InvalidInput(f"{where}: sd", 0.0, "sd > 0 or relative_sd > 0")

    def noise(self, value: float) -> float:
        """Return the standard deviation of a reading of this true value [SI unit]."""
        return math.hypot(self.sd, self.relative_sd * value)

    def observed(self, sd: float, value: float) -> Sensor:
        """Return the sensor rescaled so that it predicts an sd that an estimator reported at a value.

        Args:
            sd: reported standard deviation [SI unit], > 0.
            value: the value it was reported for [SI unit].
        """
        if not (math.isfinite(sd) and sd > 0):
            raise InvalidInput(f"sensor of {self.property}: observed sd", sd, "a finite number > 0")
        expected = self.noise(value)
        if expected == 0:
            return replace(self, sd=sd)
        ratio = sd / expected
        return replace(self, sd=self.sd * ratio, relative_sd=self.relative_sd * ratio)


@dataclass(frozen=True)
class ClassSensor:
    """A classifier of material or category with its confusion matrix.

    Attributes:
        variable: ``material`` or ``category``.
        classes: the true classes, one per column.
        outcomes: what the classifier can say, one per row.
        confusion: P(outcome | class), rows of numbers, shape (outcomes, classes); columns sum to one.

    Raises:
        InvalidInput: if the shape is wrong, an entry negative, or a column does not sum to one within 1e-3.
    """

    variable: str
    classes: tuple[str, ...]
    outcomes: tuple[str, ...]
    confusion: tuple[tuple[float, ...], ...]

    def __post_init__(self) -> None:
        where = f"confusion of {self.variable}"
        shape = (len(self.outcomes), len(self.classes))
        if len(self.confusion) != shape[0] or any(len(row) != shape[1] for row in self.confusion):
            raise InvalidInput(where, [len(row) for row in self.confusion], f"{shape[0]} rows of {shape[1]}")
        table = np.asarray(self.confusion, dtype=float)
        if not np.all(np.isfinite(table)) or np.any(table < 0):
            raise InvalidInput(where, float(np.nanmin(table)), "finite numbers >= 0")
        for name, total in zip(self.classes, table.sum(axis=0), strict=True):
            if abs(total - 1) > 1e-3:
                raise InvalidInput(f"{where}: column {name}", float(total), "a column that sums to 1")

    @cached_property
    def matrix(self) -> np.ndarray:
        """P(outcome | class), shape (outcomes, classes), columns exactly normalised."""
        table = np.asarray(self.confusion, dtype=float)
        return np.asarray(table / table.sum(axis=0, keepdims=True))

    def likelihoods(self, output: str | Mapping[str, float] | Sequence[float]) -> dict[str, float]:
        """Return the likelihood of every class for a classifier's output.

        A soft output q over the outcomes gives L^T q, with L the confusion matrix.

        Args:
            output: an outcome's name, or probabilities of the outcomes (by name, or in their order).

        Raises:
            UnknownName: if an outcome is not known.
            InvalidInput: if the probabilities are negative or do not sum to one within 1e-3.
        """
        q = self.distribution(output)
        return dict(zip(self.classes, (self.matrix.T @ q).tolist(), strict=True))

    def distribution(self, output: str | Mapping[str, float] | Sequence[float]) -> np.ndarray:
        """Return an output as probabilities of the outcomes, shape (outcomes,)."""
        where = f"output of the {self.variable} classifier"
        q = np.zeros(len(self.outcomes))
        if isinstance(output, str):
            output = {output: 1.0}
        if isinstance(output, Mapping):
            for name, value in output.items():
                if name not in self.outcomes:
                    raise UnknownName(where, name, self.outcomes)
                q[self.outcomes.index(name)] = value
        else:
            if len(output) != len(q):
                raise InvalidInput(where, len(output), f"{len(q)} probabilities")
            q[:] = output
        if not np.all(np.isfinite(q)) or np.any(q < 0) or abs(q.sum() - 1) > 1e-3:
            raise InvalidInput(where, q.tolist(), "probabilities >= 0 that sum to 1")
        return np.asarray(q / q.sum())
