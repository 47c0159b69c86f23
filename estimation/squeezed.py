"""What a squeeze action comes to: the measurements that can be believed, and what a person should know besides."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from dynamics.arm import Arm
from dynamics.errors import ActionFailed
from dynamics.gripper import ParallelGripper
from dynamics.shapes import Shape
from dynamics.signals import Phase
from estimation.carried import held_weight
from estimation.measurement import Measurement
from estimation.size import SizeEstimate
from estimation.springing import PLASTIC, lost_work
from estimation.squeezing import air_current, measure_squeeze
from estimation.stiffness import StiffnessEstimate

METHOD_SD = 0.035  # relative; what shapes and sizes of all kinds differ by in the hand, simulated without noise
WIDTH_SD = 2.5e-4  # m; what widths differ by besides, for a thing in the hand may stand a little askew
SURPRISING = 5.0  # standard deviations by which an object met narrower or wider than known is not as known
ASIDE = 0.05  # share of its width by which it must be wider besides, to be another side of it


@dataclass(frozen=True)
class SqueezeFindings:
    """What a squeeze came to.

    Attributes:
        estimate: of the stiffness.
        measurements: of ``elasticity`` or ``compliance`` and of ``width``, without what cannot be believed.
        notes: what a person should know besides.
    """

    estimate: StiffnessEstimate
    measurements: tuple[Measurement, ...]
    notes: tuple[str, ...] = ()


def believe_squeeze(
    arm: Arm, gripper: ParallelGripper, shape: Shape, size: SizeEstimate, edge: int, phases: Sequence[Phase]
) -> SqueezeFindings:
    """Measure a squeeze, and hold what comes of it against what is known of the object.

    Args:
        arm, gripper: their descriptions.
        shape, size: of the object.
        edge: which of its lengths the pads close on.
        phases: of one squeeze, see :func:`estimation.squeezing.measure_squeeze`.

    Raises:
        InvalidInput: as `measure_squeeze`.
        ActionFailed: ``displaced``, if the object was met so much wider than it is that the pads cannot be where
            they are believed to be on it: then force and opening do not tell its modulus.
    """
    extents, spread = _closing_first(size.mean, edge), _closing_first(size.sd, edge)
    by_hand = any(phase.name == "grasp" for phase in phases)  # a bench centres what it presses
    estimate, measurements = measure_squeeze(
        gripper,
        shape,
        extents,
        phases,
        size_sd=spread,
        fill=size.fill,
        weight=held_weight(arm, phases),
        method_sd=METHOD_SD if by_hand else 0.0,
    )
    if by_hand:
        measurements = tuple(
            replace(m, sd=math.hypot(m.sd, WIDTH_SD)) if m.property == "width" else m for m in measurements
        )
    notes: tuple[str, ...] = ()
    known = any(m.property == "elasticity" for m in measurements)
    if all(m.property == "width" for m in measurements):
        notes += ("the readings do not tell its elasticity, nor a bound of it",)
    air, _ = air_current([p.gripper() for p in phases if p.name == "air"], gripper)
    lost = lost_work(phases, air, gripper.opening_quantum)
    if lost > PLASTIC:
        notes += (f"it does not spring back: {lost:.0%} of the work of pressing it is lost",)
    for width in (m for m in measurements if m.property == "width"):
        surprising = SURPRISING * math.hypot(width.sd, spread[0])
        met = f"{width.mean:.4f} m wide, not {extents[0]:.4f}"
        if width.mean > extents[0] + max(surprising, ASIDE * extents[0]):
            raise ActionFailed("displaced", f"it was met {met}: the pads are not where they should be on it")
        if width.mean < extents[0] - surprising:
            measurements = tuple(m for m in measurements if m is not width)
            deformed = known or lost > PLASTIC  # else it was pressed by so much all along that little is told
            notes += (f"it was met {met}: it does not spring back" if deformed else f"it seems {met}",)
    return SqueezeFindings(estimate, measurements, notes)


def _closing_first(lengths: tuple[float, float, float], edge: int) -> tuple[float, float, float]:
    """Return lengths along the closing direction, across it, and along the approach."""
    return lengths[edge], lengths[1 - edge], lengths[2]
