"""The size of an object, as declared and as measured length by length, and the volume that follows."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from dynamics.objects import DeclaredObject
from dynamics.shapes import Shape, relative_volume_sd, tied_to
from estimation.measurement import Measurement


@dataclass(frozen=True)
class SizeEstimate:
    """Gaussian beliefs about the lengths of an object's bounding box.

    Lengths of different names are independent; those that are one, such as a cylinder's two diameters, are known
    together.

    Attributes:
        mean: lengths along the object's x, y and z [m].
        sd: their standard deviations [m].
        shape: of the object.
        fill: share of the box that it fills.
    """

    mean: tuple[float, float, float]
    sd: tuple[float, float, float]
    shape: Shape = "box"
    fill: float = 1.0

    @classmethod
    def declared(cls, known: DeclaredObject) -> SizeEstimate:
        """Return what the user declared."""
        sd = known.size_sd
        if known.shape == "mesh":  # its scale is uncertain, by so much along the longest length
            relative = sd / max(known.size)
            return cls(known.size, _scaled(known.size, relative), known.shape, known.fill)
        return cls(known.size, (sd, sd, sd), known.shape, known.fill)

    def with_edge(self, edge: int, measured: Measurement) -> SizeEstimate:
        """Return the estimate after a measurement of one length: the product of the two Gaussians.

        Lengths that are tied to it keep their ratio to it.

        Args:
            edge: which length, 0 to 2.
            measured: it [m].
        """
        precision = 1 / self.sd[edge] ** 2 + 1 / measured.sd**2
        mean = (self.mean[edge] / self.sd[edge] ** 2 + measured.mean / measured.sd**2) / precision
        factor, spread = mean / self.mean[edge], precision**-0.5 / mean
        together = tied_to(self.shape, edge)
        known = [
            (length * factor, length * factor * spread) if axis in together else (length, sd)
            for axis, (length, sd) in enumerate(zip(self.mean, self.sd, strict=True))
        ]
        (a, sd_a), (b, sd_b), (c, sd_c) = known
        return replace(self, mean=(a, b, c), sd=(sd_a, sd_b, sd_c))

    def volume(self) -> Measurement:
        """Return the volume, V = fill a b c, its relative variance the sum of those of its lengths [m^3]."""
        volume = self.fill * math.prod(self.mean)
        return Measurement("volume", volume, volume * relative_volume_sd(self.shape, self.mean, self.sd), "m^3")


def _scaled(size: tuple[float, float, float], factor: float) -> tuple[float, float, float]:
    a, b, c = size
    return a * factor, b * factor, c * factor
