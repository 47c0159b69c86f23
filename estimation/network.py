"""The reference network: materials, categories and the properties that objects made of them have."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from dynamics.errors import InvalidInput, UnknownName
from estimation.sensor import ClassSensor, Sensor

UNKNOWN = "unknown"
LINEAR, LOG = "linear", "log"
MATERIAL, CATEGORY = "material", "category"
BOTH, EVERYTHING = "both", "everything"
RESERVED = (MATERIAL, CATEGORY, BOTH, EVERYTHING)
"""Names that no property or relation may have: what a plan can be about besides them."""


@dataclass(frozen=True)
class Property:
    """A continuous property: a Gaussian (scale linear) or a log-normal (scale log) per class of its parent.

    Attributes:
        name: such as ``density``.
        parent: ``material``, ``category``, or None where it depends on neither.
        unit: SI unit.
        scale: ``linear`` or ``log``.
        means: mean per class of the parent (one number without a parent) [unit].
        sds: standard deviation per class, of the value itself on either scale [unit], > 0.
    """

    name: str
    parent: str | None
    unit: str
    scale: str
    means: tuple[float, ...]
    sds: tuple[float, ...]

    @cached_property
    def location(self) -> np.ndarray:
        """Mean of the coordinate x (linear) or ln x (log) per class."""
        means, sds = np.array(self.means), np.array(self.sds)
        if self.scale == LINEAR:
            return means
        return np.asarray(np.log(means) - 0.5 * np.log1p((sds / means) ** 2))

    @cached_property
    def spread(self) -> np.ndarray:
        """Standard deviation of the coordinate x (linear) or ln x (log) per class."""
        means, sds = np.array(self.means), np.array(self.sds)
        if self.scale == LINEAR:
            return sds
        return np.asarray(np.sqrt(np.log1p((sds / means) ** 2)))


@dataclass(frozen=True)
class Relation:
    """A quantity that follows from properties: prod x_i^c_i (kind product) or sum c_i x_i (kind sum).

    Attributes:
        name: such as ``mass``.
        kind: ``product`` or ``sum``.
        unit: SI unit.
        terms: pairs of a property's name and its exponent (product) or coefficient (sum).
    """

    name: str
    kind: str
    unit: str
    terms: tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class Unknown:
    """The class of everything that the reference does not list.

    Per property it is N(mean of the classes, (width sd_mix)^2) with sd_mix^2 = mean of the variances plus
    variance of the means, and never narrower than 1.25 of the broadest class, so that it wins far outside.

    Attributes:
        weight: its prior probability.
        width: standard deviation in units of sd_mix.
    """

    weight: float = 0.05
    width: float = 2.0


@dataclass(frozen=True)
class Hypotheses:
    """The prior bank: one row per possible joint class; arrays are read-only.

    Attributes:
        material: index of the material's name, shape (K,).
        category: index of the category's name, shape (K,); zeros without categories.
        log_weight: log prior probability, shape (K,).
        mean: mean of the coordinates, shape (K, d).
        variance: variance of the coordinates, shape (K, d); they are independent given the class.
    """

    material: np.ndarray
    category: np.ndarray
    log_weight: np.ndarray
    mean: np.ndarray
    variance: np.ndarray


@dataclass(frozen=True)
class Network:
    """A Bayesian network P(category) P(material | category) prod p(property | parent).

    Attributes:
        name: what the file calls itself.
        materials: names, without ``unknown``.
        categories: names, without ``unknown``; empty where the reference has none.
        prior: P(category), or P(material) where there are no categories; sums to one.
        conditional: P(material | category), one row per category, each summing to one; empty without.
        properties: the continuous properties.
        relations: quantities that follow from them.
        unknown: the class of everything else, or None.
        sensors: pairs of a name and the sensor model that the reference gives.
        source: where the numbers come from.
    """

    name: str
    materials: tuple[str, ...]
    properties: tuple[Property, ...]
    prior: tuple[float, ...]
    categories: tuple[str, ...] = ()
    conditional: tuple[tuple[float, ...], ...] = ()
    relations: tuple[Relation, ...] = ()
    unknown: Unknown | None = field(default_factory=Unknown)
    sensors: tuple[tuple[str, Sensor | ClassSensor], ...] = ()
    source: str = ""

    @classmethod
    def from_file(cls, path_or_name: str | Path) -> Network:
        """Read and check a reference file.

        Args:
            path_or_name: the path of a JSON file, or the name of a shipped reference.

        Raises:
            UnknownName: if there is no such file, or a name in it is not known.
            InvalidInput: if a value in it is unusable; the message names file, key and value.
        """
        from estimation.network_file import read_network

        return read_network(path_or_name)

    def save(self, path: str | Path) -> None:
        """Write the network as a reference file, in SI units."""
        from estimation.network_file import write_network

        write_network(self, path)

    @property
    def property_names(self) -> tuple[str, ...]:
        """Names of the properties, in the order of the coordinates."""
        return tuple(prop.name for prop in self.properties)

    @property
    def quantities(self) -> tuple[str, ...]:
        """Everything that can be measured: properties, then relations."""
        return self.property_names + tuple(relation.name for relation in self.relations)

    def classes(self, variable: str) -> tuple[str, ...]:
        """Return the classes of ``material`` or ``category``, ``unknown`` last where the network has it.

        Raises:
            UnknownName: if the variable is not one of the network's.
        """
        extra = (UNKNOWN,) if self.unknown is not None else ()
        if variable == MATERIAL:
            return self.materials + extra
        if variable == CATEGORY and self.categories:
            return self.categories + extra
        raise UnknownName("class variable", variable, self.variables)

    @property
    def variables(self) -> tuple[str, ...]:
        """The discrete variables."""
        return (MATERIAL, CATEGORY) if self.categories else (MATERIAL,)

    def index(self, prop: str) -> int:
        """Return the coordinate of a property.

        Raises:
            UnknownName: if there is no such property.
        """
        if prop not in self.property_names:
            raise UnknownName(f"property of network {self.name}", prop, self.property_names)
        return self.property_names.index(prop)

    def property(self, name: str) -> Property:
        """Return a property by name.

        Raises:
            UnknownName: if there is no such property.
        """
        return self.properties[self.index(name)]

    def relation(self, name: str) -> Relation | None:
        """Return a relation by name, or None for the name of a property.

        Raises:
            UnknownName: if there is neither.
        """
        for relation in self.relations:
            if relation.name == name:
                return relation
        if name not in self.property_names:
            raise UnknownName(f"quantity of network {self.name}", name, self.quantities)
        return None

    def unit(self, quantity: str) -> str:
        """Return the SI unit of a property or relation.

        Raises:
            UnknownName: if there is no such quantity.
        """
        relation = self.relation(quantity)
        return relation.unit if relation is not None else self.property(quantity).unit

    def sensor(self, name: str) -> Sensor | ClassSensor:
        """Return a sensor model of the reference.

        Raises:
            UnknownName: if there is no such sensor.
        """
        for known, sensor in self.sensors:
            if known == name:
                return sensor
        raise UnknownName(f"sensor of network {self.name}", name, [known for known, _ in self.sensors])

    def without_unknown(self) -> Network:
        """Return the network in which every object is one of the listed classes."""
        return replace(self, unknown=None)

    def with_unknown(self, weight: float = 0.05, width: float = 2.0) -> Network:
        """Return the network with another unknown class.

        Raises:
            InvalidInput: if the weight is not in [0, 1) or the width not positive.
        """
        if not 0 <= weight < 1:
            raise InvalidInput("unknown: weight", weight, "a number in [0, 1)")
        if not (math.isfinite(width) and width > 0):
            raise InvalidInput("unknown: width", width, "a finite number > 0")
        return replace(self, unknown=Unknown(weight, width))

    @cached_property
    def hypotheses(self) -> Hypotheses:
        """The prior bank of joint classes with non-zero probability (K rows)."""
        count = len(self.materials)
        if self.categories:
            joint = np.array(self.prior)[:, None] * np.array(self.conditional)
            category, material = np.nonzero(joint)
            weight = joint[category, material]
        else:
            material = np.arange(count)
            category = np.zeros(count, dtype=int)
            weight = np.array(self.prior, dtype=float)
        if self.unknown is not None:
            material = np.append(material, count)
            category = np.append(category, len(self.categories))
            weight = np.append(weight * (1 - self.unknown.weight), self.unknown.weight)
        mean = np.empty((len(material), len(self.properties)))
        variance = np.empty_like(mean)
        parents = {MATERIAL: material, CATEGORY: category, None: np.zeros_like(material)}
        for i, prop in enumerate(self.properties):
            location, spread = self._with_unknown(prop)
            mean[:, i] = location[parents[prop.parent]]
            variance[:, i] = spread[parents[prop.parent]] ** 2
        with np.errstate(divide="ignore"):
            rows = (material, category, np.log(weight), mean, variance)
        for row in rows:
            row.setflags(write=False)
        return Hypotheses(*rows)

    def _with_unknown(self, prop: Property) -> tuple[np.ndarray, np.ndarray]:
        """Return a property's coordinate means and sds, the unknown class appended."""
        location, spread = prop.location, prop.spread
        if self.unknown is None or prop.parent is None:
            return location, spread
        mixture = math.sqrt(float(np.mean(spread**2) + np.var(location)))
        broad = max(self.unknown.width * mixture, 1.25 * float(spread.max()))
        return np.append(location, location.mean()), np.append(spread, broad)

    def noise_floor(self, quantity: str) -> float:
        """Return the smallest noise that makes sense for a quantity: 1e-9 of its scale [SI unit]."""
        relation = self.relation(quantity)
        if relation is None:
            return 1e-9 * self._scale(quantity)
        parts = [(self._scale(name), value) for name, value in relation.terms]
        if relation.kind == "sum":
            return 1e-9 * sum(abs(value) * scale for scale, value in parts)
        return 1e-9 * float(math.prod(scale**value for scale, value in parts))

    def _scale(self, prop: str) -> float:
        own = self.property(prop)
        return max(max(map(abs, own.means)), max(own.sds))


def uniform(count: int) -> tuple[float, ...]:
    """Return equal probabilities."""
    return (1.0 / count,) * count


def checked_probabilities(values: Mapping[str, float], where: str) -> dict[str, float]:
    """Return probabilities by name, exactly normalised.

    Raises:
        InvalidInput: if one is negative or not finite, or the sum is not one within 1e-3.
    """
    for name, value in values.items():
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise InvalidInput(f"{where}: {name}", value, "a number >= 0")
        if not (math.isfinite(value) and value >= 0):
            raise InvalidInput(f"{where}: {name}", value, "a finite number >= 0")
    total = math.fsum(values.values())
    if abs(total - 1) > 1e-3:
        raise InvalidInput(f"{where}: sum", total, "probabilities that sum to 1")
    return {name: value / total for name, value in values.items()}
