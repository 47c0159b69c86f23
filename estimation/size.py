"""The size of a box, as declared and as measured edge by edge, and the volume that follows."""

from __future__ import annotations

import math
from dataclasses import dataclass

from dynamics.objects import DeclaredObject
from estimation.measurement import Measurement


@dataclass(frozen=True)
class SizeEstimate:
    """Gaussian beliefs about the three edges of a box, independent of each other.

    Attributes:
        mean: edge lengths [m].
        sd: their standard deviations [m].
    """

    mean: tuple[float, float, float]
    sd: tuple[float, float, float]

    @classmethod
    def declared(cls, known: DeclaredObject) -> SizeEstimate:
        """Return what the user declared."""
        return cls(known.size, (known.size_sd,) * 3)

    def with_edge(self, edge: int, measured: Measurement) -> SizeEstimate:
        """Return the estimate after a measurement of one edge: the product of the two Gaussians.

        Args:
            edge: which edge, 0 to 2.
            measured: its length [m].
        """
        precision = 1 / self.sd[edge] ** 2 + 1 / measured.sd**2
        mean = (self.mean[edge] / self.sd[edge] ** 2 + measured.mean / measured.sd**2) / precision
        return SizeEstimate(_replaced(self.mean, edge, mean), _replaced(self.sd, edge, precision**-0.5))

    def volume(self) -> Measurement:
        """Return the volume, V = a b c with (sd_V / V)^2 = sum (sd_i / edge_i)^2 [m^3]."""
        volume = math.prod(self.mean)
        relative = math.sqrt(sum((sd / edge) ** 2 for sd, edge in zip(self.sd, self.mean, strict=True)))
        return Measurement("volume", volume, volume * relative, "m^3")


def _replaced(edges: tuple[float, float, float], edge: int, value: float) -> tuple[float, float, float]:
    a, b, c = (value if i == edge else old for i, old in enumerate(edges))
    return a, b, c
