"""What is known of a material's stiffness after a squeeze: Young's modulus or a bound, and every other modulus."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dynamics.compression import Geometry
from dynamics.errors import InvalidInput
from estimation.stiffness.fit import CURVE, MODULUS, Fit, curve_of, slope_of

Array = NDArray[np.float64]


class NoContact(InvalidInput):
    """The force never rose: the pads did not touch, or touched something too soft to feel."""


class TooLittleCompression(InvalidInput):
    """The opening moved too few of its steps in contact to tell a modulus from quantisation.

    Attributes:
        estimate: what can still be said: a bound, the onset.
    """

    def __init__(self, where: str, found: object, valid: str, estimate: StiffnessEstimate) -> None:
        super().__init__(where, found, valid)
        self.estimate = estimate


@dataclass(frozen=True)
class StiffnessEstimate:
    """A material's stiffness.

    Young's modulus is the slope at the onset of S(h) = E (h + a2 h^2 + a3 h^3) over h(strain), with a2 = a3 = 0
    unless the readings call for curvature. Every other modulus is one of the curve's, which has an a3 wherever the
    compression is enough for it: a line is the better guess of E, a curve the safer one of a slope further up.

    Attributes:
        young_modulus: E, the slope at the onset [Pa]; NaN where only a bound is known.
        sd: its standard deviation with that of the calibration [Pa]; infinite where only a bound is known.
        reading_sd: the part of it that other readings of the same gripper would average out [Pa].
        interval: of 95 % [Pa]; its upper end is infinite where only a bound is known.
        bound: the modulus is at least this, with 95 % confidence [Pa]; None where a modulus is known.
        onset, onset_sd: opening at which the object was touched [m].
        compression: from the onset to the largest strain of the loading [m].
        spike_rate: estimated share of the readings that are spikes.
        weights: probability of each loading reading to be no spike, (N,).
        noise_sd: median standard deviation of a stress reading [Pa].
        fit: what E was read from.
        curve: what the other moduli are read from; strain counts from its onset.
        geometry: how the curve was made.
    """

    young_modulus: float
    sd: float
    reading_sd: float
    interval: tuple[float, float]
    bound: float | None
    onset: float
    onset_sd: float
    compression: float
    spike_rate: float
    weights: Array
    noise_sd: float
    fit: Fit
    curve: Fit
    geometry: Geometry

    @property
    def max_strain(self) -> float:
        """Largest strain of the loading, from the onset [-]."""
        return self.compression / self.geometry.width

    @property
    def max_slope(self) -> float:
        """Largest tangent modulus over the strains that were reached [Pa]."""
        h = self.geometry.law_of(np.linspace(0.0, self.max_strain, 200))
        return float(np.max(slope_of(self.curve.parameters, h)))

    def stress(self, strain: float) -> float:
        """Return the curve's stress at a strain from the onset [Pa]."""
        return float(curve_of(self.curve.parameters, self._h(strain))[0])

    def tangent(self, strain: float) -> float:
        """Return the tangent modulus dS/dh at a strain from the onset [Pa]."""
        return float(slope_of(self.curve.parameters, self._h(strain))[0])

    def chord(self, a: float, b: float) -> float:
        """Return the chord modulus (S(b) - S(a)) / (h(b) - h(a)) between two strains from the onset [Pa].

        Raises:
            InvalidInput: if the strains are equal.
        """
        low, high = float(self._h(a)[0]), float(self._h(b)[0])
        if low == high:
            raise InvalidInput("chord modulus: strains", (a, b), "two different strains")
        return (self.stress(b) - self.stress(a)) / (high - low)

    def secant(self, strain: float) -> float:
        """Return the secant modulus S / h at a strain from the onset > 0 [Pa]."""
        return self.chord(0.0, strain)

    def tangent_sd(self, strain: float) -> float:
        """Return the standard deviation of the tangent modulus, with that of the calibration [Pa]."""
        h = float(self._h(strain)[0])
        x = self.curve.parameters
        row = np.zeros(len(x))
        row[MODULUS] = slope_of(x, np.array([h]))[0] / x[MODULUS]
        for power in range(2, 2 + len(x) - CURVE):
            row[CURVE + power - 2] = x[MODULUS] * power * h ** (power - 1)
        gain = self.tangent(strain) * self._gain_sd
        return math.sqrt(float(row @ self.curve.covariance @ row) + gain**2)

    def chord_sd(self, a: float, b: float) -> float:
        """Return the standard deviation of the chord modulus, with that of the calibration [Pa]."""
        low, high = float(self._h(a)[0]), float(self._h(b)[0])
        x, chord = self.curve.parameters, self.chord(a, b)
        row = np.zeros(len(x))
        row[MODULUS] = chord / x[MODULUS]
        for power in range(2, 2 + len(x) - CURVE):
            row[CURVE + power - 2] = x[MODULUS] * (high**power - low**power) / (high - low)
        return math.sqrt(float(row @ self.curve.covariance @ row) + (chord * self._gain_sd) ** 2)

    @property
    def _gain_sd(self) -> float:
        if not math.isfinite(self.sd):
            return 0.0
        return math.sqrt(max(self.sd**2 - self.reading_sd**2, 0.0)) / self.young_modulus

    def _h(self, strain: float) -> Array:
        if not (math.isfinite(strain) and 0 <= strain < 1):
            raise InvalidInput("modulus: strain", strain, "a number in [0, 1)")
        return self.geometry.law_of(np.array([strain]))
