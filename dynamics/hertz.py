"""Contact of a curved body with a flat: how the force grows with the approach, Hertz's theory.

    F = 4/3 E* sqrt(Re) (d / F2)^(3/2),    Re = sqrt(R1 R2),

for the approach d of one contact, with the body's principal radii of curvature R1 >= R2 there and a factor F2 <= 1
of their ratio (Johnson, Contact Mechanics, 1985, eqs. 4.24 to 4.28).
"""

from __future__ import annotations

import math

from dynamics.errors import InvalidInput

_ROUNDS = 100
_ROUND = 1e-9  # 1 - ratio of the radii below which the contact is a circle


def approach_factor(ratio: float) -> float:
    """Return F2, the approach of an elliptical contact over that of a round one of the same Re and force [-].

    Args:
        ratio: of the radii of curvature, R1 / R2 >= 1.

    Raises:
        InvalidInput: for a ratio below 1 or above 1e4.
    """
    if not 1 <= ratio <= 1e4:
        raise InvalidInput("Hertz: ratio of radii of curvature", ratio, "a number from 1 to 1e4")
    if ratio - 1 < _ROUND:
        return 1.0
    low, high = 1e-7, 1.0 - 1e-7  # of b / a, the axes of the contact's ellipse
    for _ in range(_ROUNDS):
        middle = math.sqrt(low * high)
        if _radii(middle) > ratio:
            low = middle
        else:
            high = middle
    k = math.sqrt(low * high)
    first, second = _elliptic(k)
    one, other = second / k**2 - first, first - second
    f1 = math.cbrt(4 / (math.pi * (1 - k**2))) * math.sqrt(k * math.cbrt(one * other))
    return 2 / math.pi * math.sqrt(k) * first / f1


def _radii(k: float) -> float:
    """Return R1 / R2 of the contact whose ellipse has the axes' ratio k."""
    first, second = _elliptic(k)
    return (second / k**2 - first) / (first - second)


def _elliptic(k: float) -> tuple[float, float]:
    """Return the complete elliptic integrals K and E of e = sqrt(1 - k^2), by the arithmetic-geometric mean."""
    a, g = 1.0, k
    total, power = (1 - k**2) / 2, 0.5
    while abs(a - g) > 1e-15:
        c = (a - g) / 2
        a, g = (a + g) / 2, math.sqrt(a * g)
        power *= 2
        total += power * c**2
    first = math.pi / (2 * a)
    return first, first * (1 - total)
