"""From everything measured of an object to a belief."""

from __future__ import annotations

import math
from collections.abc import Iterable

from estimation.belief import Belief
from estimation.bounds import bound_of
from estimation.measurement import Measurement
from estimation.observation import Observation
from estimation.size import SizeEstimate


def conclude(
    blank: Belief,
    size: SizeEstimate,
    measurements: Iterable[Measurement],
    observations: Iterable[Observation] = (),
) -> Belief:
    """Condition a belief on what is known of an object; quantities and variables unknown to it are left out.

    Args:
        blank: before anything was measured.
        size: what is known of the size.
        measurements: of other quantities than edges of the object.
        observations: of its classes.

    Raises:
        UnknownName: if an observation names a class that the belief does not know.
        InvalidInput: if an observation lacks a class, or makes all impossible that are possible.
    """
    quantities = blank.network.quantities
    volume = size.volume()
    belief = blank.update(volume) if "volume" in quantities else blank
    for one in measurements:
        measurement = one
        if one.property == "mass" and "mass" not in quantities:
            measurement = density_of(one, volume)
        bound = bound_of(measurement)
        if bound is not None and bound[0] in quantities:
            belief = belief.update_bound(*bound)
        elif measurement.property in quantities:
            belief = belief.update(measurement)
    for seen in observations:
        if seen.variable in blank.network.variables:
            belief = belief.update_class(seen.variable, seen.by_class)
    return belief


def density_of(mass: Measurement, volume: Measurement) -> Measurement:
    """Return the density of a mass in a volume, rho = m / V with independent errors [kg/m^3]."""
    density = mass.mean / volume.mean
    relative = math.hypot(mass.sd / max(abs(mass.mean), 1e-12), volume.sd / volume.mean)
    return Measurement("density", density, abs(density) * relative, "kg/m^3")
