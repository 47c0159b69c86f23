"""What a classifier made of one look at the object, or of one sound of it: evidence about a class."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from dynamics.errors import InvalidInput


@dataclass(frozen=True)
class Observation:
    """The likelihoods P(what was perceived | class) of one observation, up to a common factor.

    Attributes:
        variable: ``material`` or ``category``.
        likelihoods: pairs of a class and its likelihood, >= 0, not all zero.

    Raises:
        InvalidInput: if a likelihood is negative or not finite, all are zero, or a class is named twice.
    """

    variable: str
    likelihoods: tuple[tuple[str, float], ...]

    def __post_init__(self) -> None:
        where = f"observation of {self.variable}"
        names = [name for name, _ in self.likelihoods]
        if len(set(names)) != len(names):
            raise InvalidInput(where, names, "every class once")
        for name, value in self.likelihoods:
            if not (math.isfinite(value) and value >= 0):
                raise InvalidInput(f"{where}: {name}", value, "a finite likelihood >= 0")
        if not any(value > 0 for _, value in self.likelihoods):
            raise InvalidInput(where, dict(self.likelihoods), "a likelihood > 0 for one class at least")

    @classmethod
    def of(cls, variable: str, likelihoods: Mapping[str, float]) -> Observation:
        """Return an observation from likelihoods by class."""
        return cls(variable, tuple(likelihoods.items()))

    @property
    def best(self) -> str:
        """The class of highest likelihood."""
        return max(self.likelihoods, key=lambda item: item[1])[0]

    @property
    def by_class(self) -> dict[str, float]:
        """The likelihoods by class."""
        return dict(self.likelihoods)
