"""One measured value of one property, with its uncertainty: what estimators give and beliefs take."""

from __future__ import annotations

import math
from dataclasses import dataclass

from dynamics.errors import InvalidInput


@dataclass(frozen=True)
class Measurement:
    """A Gaussian reading of a property of the explored object, in SI units.

    Attributes:
        property: name of the property, such as ``mass`` or ``elasticity``.
        mean: the value read [unit].
        sd: its standard deviation [unit], > 0.
        unit: SI unit, such as ``kg`` or ``Pa``.

    Raises:
        InvalidInput: if a number is not finite or the sd not positive.
    """

    property: str
    mean: float
    sd: float
    unit: str

    def __post_init__(self) -> None:
        if not math.isfinite(self.mean):
            raise InvalidInput(f"measurement of {self.property}: mean", self.mean, "a finite number")
        if not (math.isfinite(self.sd) and self.sd > 0):
            raise InvalidInput(f"measurement of {self.property}: sd", self.sd, "a finite number > 0")
