"""The mass in an estimate of inertial parameters: its value, sd and interval."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class MassEstimate:
    """Inertial parameters of which the first is the mass.

    Attributes:
        parameters: [m, m c, ...] in the tool frame [kg, kg m, ...], (P,).
        covariance: of the parameters, scaled so that +-1.96 sd cover 95 %, (P, P).
    """

    parameters: Array
    covariance: Array

    @property
    def mass(self) -> float:
        """Mass [kg]."""
        return float(self.parameters[0])

    @property
    def mass_sd(self) -> float:
        """Standard deviation of the mass [kg]."""
        return float(np.sqrt(self.covariance[0, 0]))

    @property
    def mass_interval(self) -> tuple[float, float]:
        """95 % interval of the mass [kg]."""
        return self.mass - 1.96 * self.mass_sd, self.mass + 1.96 * self.mass_sd

    @property
    def mass_is_distinct(self) -> bool:
        """Tell whether the mass differs from zero by more than two sd."""
        return abs(self.mass) > 2 * self.mass_sd
