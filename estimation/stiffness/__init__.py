"""How stiff an object is, from a stress-strain curve.

`curve` states the estimate, `fit` is its robust fit, `profile` its intervals and bounds, `noise` describes the
readings, `strain` makes the best of a coarse opening, `cycle` compares loading with unloading and speeds, and
`repeats` fuses several squeezes.
"""

from estimation.stiffness.curve import estimate_stiffness
from estimation.stiffness.estimate import NoContact, StiffnessEstimate, TooLittleCompression
from estimation.stiffness.noise import CurveNoise

__all__ = ["CurveNoise", "NoContact", "StiffnessEstimate", "TooLittleCompression", "estimate_stiffness"]
