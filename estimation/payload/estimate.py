"""What an estimate of a payload says: mass, centre of mass, how sure, and what the poses could not tell."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dynamics.payload import STATIC_PARAMETERS
from estimation.measurement import Measurement
from estimation.payload.mass import MassEstimate

Array = NDArray[np.float64]

PRIOR_SD = np.array([100.0, 100.0, 100.0, 100.0])  # kg, kg m: so broad that it only keeps the graph solvable
IDENTIFIED = 0.2  # share of what the arm can carry, below which an sd counts as knowledge
HAND = 0.1  # m: the size of things held in a hand, for first moments


@dataclass(frozen=True)
class PayloadEstimate(MassEstimate):
    """A payload estimated from joint torques.

    Attributes:
        parameters: [m, m c] in the tool frame [kg, kg m], (4,).
        covariance: of the parameters, (4, 4). Where the noise was estimated it is widened so that
            +-1.96 sd cover 95 % although the noise is not known exactly.
        weights: probability of every reading to be good, tare before load, (N, nv).
        pose_weights: probability of every pose to be good, (N,).
        residuals: of every reading, tare before load [N m], (N, nv).
        noise_sd: sd that the readings were given or found to have [N m], (N, nv).
        condition: condition number of the scaled information on the parameters; large when poses are poor.
        capacity: mass that the arm can hold at full reach [kg]; a parameter counts as identified if its sd is
            less than a fifth of that (times 0.1 m for m c).
    """

    weights: Array
    pose_weights: Array
    residuals: Array
    noise_sd: Array
    condition: float
    capacity: float

    @property
    def center_of_mass(self) -> Array:
        """Centre of mass in the tool frame [m], (3,); nan where it is not identified."""
        if not self.mass_is_distinct:
            return np.full(3, np.nan)
        found = np.isin(STATIC_PARAMETERS[1:], self.identified)
        return np.where(found, self.parameters[1:] / self.mass, np.nan)

    @property
    def center_of_mass_sd(self) -> Array:
        """Standard deviation of the centre of mass, to first order [m], (3,)."""
        slope = np.column_stack([-self.parameters[1:] / self.mass, np.eye(3)]) / self.mass
        return np.where(np.isnan(self.center_of_mass), np.nan, np.sqrt(np.diag(slope @ self.covariance @ slope.T)))

    @property
    def intervals(self) -> Array:
        """95 % intervals of the parameters [kg, kg m], (4, 2)."""
        half = 1.96 * np.sqrt(np.diag(self.covariance))
        return np.column_stack([self.parameters - half, self.parameters + half])

    @property
    def identified(self) -> tuple[str, ...]:
        """Names of the parameters that the poses identify."""
        needed = IDENTIFIED * self.capacity * np.array([1.0, HAND, HAND, HAND])
        told = np.sqrt(np.diag(self.covariance)) < needed
        return tuple(name for name, known in zip(STATIC_PARAMETERS, told, strict=True) if known)

    @property
    def mass_is_distinct(self) -> bool:
        """Tell whether the mass is identified and differs from zero by more than two sd."""
        return "mass" in self.identified and super().mass_is_distinct

    @property
    def verdict(self) -> str:
        """What the poses could and could not tell, in a sentence."""
        missing = [name for name in STATIC_PARAMETERS if name not in self.identified]
        if missing:
            return f"not identifiable from these poses: {', '.join(missing)}; choose poses that differ in tilt"
        if self.mass < -2 * self.mass_sd:
            return f"negative mass ({self.mass:.3f} kg): are tare and load exchanged?"
        if not self.mass_is_distinct:
            low, high = self.mass_interval
            return f"no payload distinguishable from zero: mass in [{low:.3f}, {high:.3f}] kg"
        return "mass and centre of mass identified"

    def measurement(self) -> Measurement:
        """Return the reading of the property ``mass`` [kg]."""
        return Measurement("mass", self.mass, self.mass_sd, "kg")
