"""Learn a class from an object that none of the listed ones explains."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from dynamics.errors import InvalidInput
from estimation.bank import predictive
from estimation.belief import Belief
from estimation.network import LINEAR, MATERIAL, UNKNOWN, Network, Property
from estimation.sensor import ClassSensor, Sensor

REFERENCE = "reference.json"


def with_class(belief: Belief, name: str) -> Network:
    """Return the belief's network with the measured object as a new material.

    Every property of the material gets the value measured, and as spread the uncertainty of that value plus
    the median spread of the listed classes: one object does not show how much its material varies. A property
    that was not measured stays as broad as ``unknown``. In networks with categories the new material takes an
    equal share, 1 / (number of materials), of each.

    Args:
        belief: what was measured; only its readings count, not its probabilities.
        name: name of the new material.

    Raises:
        InvalidInput: if the name is taken, empty or ``unknown``, or the network has no unknown class.
    """
    network = belief.network
    check_name(network, name)
    row = int(np.flatnonzero(network.hypotheses.material == len(network.materials))[0])
    properties = tuple(_extended(belief, prop, row) for prop in network.properties)
    share = 1.0 / (len(network.materials) + 1)
    if network.categories:
        conditional = tuple((*(p * (1 - share) for p in line), share) for line in network.conditional)
        prior = network.prior
    else:
        conditional = ()
        prior = (*(p * (1 - share) for p in network.prior), share)
    sensors = tuple((key, _widened(sensor, name)) for key, sensor in network.sensors)
    return replace(
        network,
        materials=(*network.materials, name),
        properties=properties,
        prior=prior,
        conditional=conditional,
        sensors=sensors,
    )


def check_name(network: Network, name: str) -> None:
    """Refuse a name, or a network, that no new class can be made with.

    Raises:
        InvalidInput: if the name is taken, empty or ``unknown``, or the network has no unknown class.
    """
    if not name.strip() or name in (UNKNOWN, *network.materials):
        raise InvalidInput("new class: name", name, "a name that is not taken")
    if network.unknown is None:
        raise InvalidInput(f"new class: network {network.name}", None, "a network with an unknown class")


def save_class(belief: Belief, name: str, directory: Path) -> Path | None:
    """Save the object as a new material in a copy of its reference, if no listed one explains it.

    Args:
        belief: about the object.
        name: of the new material.
        directory: where ``reference.json`` is written.

    Returns:
        The file, or None if ``unknown`` is not the most probable material.
    """
    if belief.argmax(MATERIAL) != UNKNOWN:
        return None
    file = directory / REFERENCE
    with_class(belief, name).save(file)
    return file


def _widened(sensor: Sensor | ClassSensor, name: str) -> Sensor | ClassSensor:
    """Return a classifier of the material that says about the new one what it says on average."""
    if not isinstance(sensor, ClassSensor) or sensor.variable != MATERIAL:
        return sensor
    rows = tuple(
        (*row, float(mean)) for row, mean in zip(sensor.confusion, sensor.matrix.mean(axis=1), strict=True)
    )
    return replace(sensor, classes=(*sensor.classes, name), confusion=rows)


def _extended(belief: Belief, prop: Property, row: int) -> Property:
    """Return a property with the measured object as one more class of the material."""
    if prop.parent != MATERIAL:
        return prop
    found = predictive(belief.network, belief.bank, prop.name)
    mean, variance = float(found.mean[row]), float(found.variance[row])
    prior = belief.network.hypotheses.variance[row, belief.network.index(prop.name)]
    if variance < 0.999 * prior:
        variance += float(np.median(prop.spread)) ** 2
    sd = float(np.sqrt(variance))
    if prop.scale != LINEAR:
        sd_log, mean_log = sd, mean
        mean = float(np.exp(mean_log + 0.5 * sd_log**2))
        sd = mean * float(np.sqrt(np.expm1(sd_log**2)))
    return replace(prop, means=(*prop.means, mean), sds=(*prop.sds, sd))
