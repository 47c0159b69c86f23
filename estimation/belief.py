"""What is believed about one object: a bank of Gaussian hypotheses, conditioned exactly on readings."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from dynamics.errors import InvalidInput, UnknownName
from estimation import units
from estimation.bank import Bank, condition_property, predictive
from estimation.bounds import condition_bound
from estimation.conditioning import logsumexp
from estimation.measurement import Measurement
from estimation.mixture import Mixture
from estimation.network import (
    CATEGORY,
    LOG,
    MATERIAL,
    UNKNOWN,
    Network,
    Relation,
    checked_probabilities,
)
from estimation.network_file import network_content, parse_network
from estimation.relations import condition_bank
from estimation.sensor import ClassSensor

CORRECT, WEAK, DIVERGED, UNDECIDED = "C", "W", "D", "U"
OUTLIER = 6.0
SKEWED = 0.05
"""Relative noise of a direct reading beyond which its log-scale posterior is not taken for a Gaussian."""
_FORMAT = "palpate-belief/1"


class Belief:
    """A belief about one object, immutable: every update returns a new one.

    Readings of one quantity share its true value, so they are fused before they meet the prior; properties
    come before relations. Hence the order of measurements does not matter.

    Args:
        network: the reference.
        prior: probabilities of all materials, or of all categories, that replace the reference's; without
            ``unknown`` among them they are meant for the listed classes and ``unknown`` keeps its weight.

    Raises:
        UnknownName: if a class is not known.
        InvalidInput: if the probabilities are negative or do not sum to one.
    """

    def __init__(self, network: Network, prior: Mapping[str, float] | None = None) -> None:
        self.network = network
        self._log_prior = network.hypotheses.log_weight if prior is None else _reweighted(network, prior)
        self._log_likelihood = np.zeros_like(self._log_prior)
        self._readings: dict[str, tuple[float, float]] = {}
        self._counts: dict[str, int] = {}
        self._direct: dict[str, tuple[np.ndarray, np.ndarray, np.ndarray]] = {}
        self._bounds: dict[str, float] = {}

    @cached_property
    def bank(self) -> Bank:
        """The hypotheses: log weights, means, covariances of the coordinates."""
        network, prior = self.network, self.network.hypotheses
        log_weight = self._log_prior + self._log_likelihood
        mean, variance = prior.mean, prior.variance
        mean, variance = mean.copy(), variance.copy()
        for name, (evidence, centre, spread) in sorted(self._direct.items()):
            i = network.index(name)
            log_weight = log_weight + evidence
            mean[:, i], variance[:, i] = centre, spread
        for name, least in sorted(self._bounds.items()):
            i, scale = network.index(name), network.property(name).scale
            evidence, mean[:, i], variance[:, i] = condition_bound(scale, mean[:, i], variance[:, i], least)
            log_weight = log_weight + evidence
        bank = Bank(log_weight, mean, variance)
        for relation in network.relations:
            if relation.name in self._readings:
                skewed = self._skewed(relation) if bank.joint is None else {}
                bank = condition_bank(network, relation.name, bank, self._readings[relation.name], skewed)
        log_weight = bank.log_weight
        return Bank(log_weight - logsumexp(log_weight), bank.mean, bank.variance, bank.joint)

    def update(self, measurement: Measurement) -> Belief:
        """Return the belief after a reading of a property or relation: p(x | z) ~ p(x) N(z; x, sd^2).

        Raises:
            UnknownName: if the network has no such quantity, or the unit is not known.
            InvalidInput: if the unit does not fit.
        """
        name = measurement.property
        network = self.network
        relation = network.relation(name)
        factor = units.conversion(measurement.unit, network.unit(name), f"measurement of {name}")
        floor = network.noise_floor(name)
        z, sd = measurement.mean * factor, max(measurement.sd * factor, floor)
        if name in self._readings:
            z, sd = _fused(self._readings[name], (z, sd))
            sd = max(sd, floor)
        updated = self._copy()
        updated._readings[name] = (z, sd)
        updated._counts[name] = self._counts.get(name, 0) + 1
        if relation is None:
            i, prior = network.index(name), network.hypotheses
            updated._direct[name] = condition_property(
                network, name, prior.mean[:, i], prior.variance[:, i], z, sd
            )
        return updated

    def update_bound(self, quantity: str, least: float, unit: str) -> Belief:
        """Return the belief after a bound that a property exceeds with 95 % confidence.

        Bounds share what they are uncertain by, a calibration: of several the largest counts.

        Args:
            quantity: a property; of a relation nothing is learnt.
            least: the bound [unit], > 0.
            unit: its unit.

        Raises:
            UnknownName: if the network has no such quantity, or the unit is not known.
            InvalidInput: if the unit does not fit, or the bound is not positive.
        """
        where = f"bound of {quantity}"
        if not (math.isfinite(least) and least > 0):
            raise InvalidInput(where, least, "a finite number > 0")
        network = self.network
        updated = self._copy()
        if network.relation(quantity) is None:
            value = least * units.conversion(unit, network.unit(quantity), where)
            updated._bounds[quantity] = max(value, self._bounds.get(quantity, 0.0))
        return updated

    def update_class(self, variable: str, likelihoods: Mapping[str, float]) -> Belief:
        """Return the belief after evidence about a class: P(c | e) ~ P(c) P(e | c).

        Args:
            variable: ``material`` or ``category``.
            likelihoods: P(e | class) up to a factor for every class; left out for ``unknown`` it is the mean
                of the others.

        Raises:
            UnknownName: if a class is not known.
            InvalidInput: if one is missing, negative, or all that are possible are zero.
        """
        where = f"likelihoods of {variable}"
        classes = self.network.classes(variable)
        for name, value in likelihoods.items():
            if name not in classes:
                raise UnknownName(where, name, classes)
            if not (math.isfinite(value) and value >= 0):
                raise InvalidInput(f"{where}: {name}", value, "a finite number >= 0")
        known = [name for name in classes if name != UNKNOWN]
        for name in known:
            if name not in likelihoods:
                raise InvalidInput(where, sorted(likelihoods), f"a likelihood for {name}")
        values = np.array([likelihoods[name] for name in known], dtype=float)
        if UNKNOWN in classes:
            values = np.append(values, likelihoods.get(UNKNOWN, values.mean()))
        with np.errstate(divide="ignore"):
            log = np.log(values)[self._rows(variable)]
        total = self._log_likelihood + log
        top = float(np.max(np.where(np.isneginf(self._log_prior), -np.inf, total)))
        if not math.isfinite(top):
            raise InvalidInput(where, dict(likelihoods), "a positive likelihood for a class that is possible")
        updated = self._copy()
        updated._log_likelihood = total - top
        return updated

    def update_output(self, sensor: ClassSensor, output: str | Mapping[str, float] | Sequence[float]) -> Belief:
        """Return the belief after a classifier's output, hard or soft, through its confusion matrix.

        Raises:
            UnknownName: if an outcome is not known.
            InvalidInput: if the output is not a distribution over the outcomes.
        """
        return self.update_class(sensor.variable, sensor.likelihoods(output))

    def probabilities(self, variable: str) -> dict[str, float]:
        """Return P(class) of ``material`` or ``category``, summing to one.

        Raises:
            UnknownName: if the network has no such variable.
        """
        classes = self.network.classes(variable)
        total = np.bincount(self._rows(variable), weights=self.bank.weight, minlength=len(classes))
        return dict(zip(classes, total.tolist(), strict=True))

    def marginal(self, quantity: str) -> Mixture:
        """Return the belief about a property or relation as a mixture, one component per hypothesis.

        Raises:
            UnknownName: if the network has no such quantity.
        """
        found = predictive(self.network, self.bank, quantity)
        sds = np.sqrt(np.maximum(found.variance, np.finfo(float).tiny))
        return Mixture(self.bank.weight, found.mean, sds, found.link, self.network.unit(quantity))

    def argmax(self, name: str) -> str | float:
        """Return the most probable class of a variable, or value of a quantity [SI unit].

        Raises:
            UnknownName: if the network has no such variable or quantity.
        """
        if name in self.network.variables:
            found = self.probabilities(name)
            return max(found, key=lambda key: found[key])
        return self.marginal(name).mode()

    def outcome(self, truth: str, variable: str = MATERIAL, threshold: float = 0.6) -> str:
        """Return how a run ended: C correct, W weakly correct, D diverged, U undecided (thesis, chapter 4).

        C: the most probable class is the truth with P >= threshold; W: it is, with less; D: it is another
        one with P >= threshold, or it is ``unknown``; U, which the thesis has no letter for: it is another
        one with less. For an object of no listed class the truth is ``unknown``.

        Raises:
            UnknownName: if the truth is not a class of the variable.
        """
        found = self.probabilities(variable)
        if truth not in found:
            raise UnknownName(f"true {variable}", truth, found)
        best = max(found, key=lambda key: found[key])
        if best == truth:
            return CORRECT if found[best] >= threshold else WEAK
        return DIVERGED if best == UNKNOWN or found[best] >= threshold else UNDECIDED

    def surprise(self, measurement: Measurement) -> float:
        """Return the distance of a reading from the nearest listed class, in its predictive sds.

        Above `OUTLIER` a reading fits nothing listed.
        """
        name = measurement.property
        factor = units.conversion(measurement.unit, self.network.unit(name), f"measurement of {name}")
        found = predictive(self.network, self.bank, name)
        mean, variance = found.mean, found.variance
        if found.link == "log":
            mean, variance = np.exp(mean + 0.5 * variance), np.exp(2 * mean + variance) * np.expm1(variance)
        listed = self.network.hypotheses.material < len(self.network.materials)
        distance = np.abs(measurement.mean * factor - mean) / np.sqrt(variance + (measurement.sd * factor) ** 2)
        return float(distance[listed & ~np.isneginf(self._log_prior)].min())

    @property
    def counts(self) -> dict[str, int]:
        """Number of readings of every quantity measured so far."""
        return dict(self._counts)

    def to_json(self) -> str:
        """Return the belief, its network included, as JSON that loses nothing."""
        content = {
            "format": _FORMAT,
            "network": network_content(self.network),
            "log_prior": [_finite_or_none(value) for value in self._log_prior.tolist()],
            "log_likelihood": [_finite_or_none(value) for value in self._log_likelihood.tolist()],
            "readings": {
                name: {"mean": z, "sd": sd, "count": self._counts[name]}
                for name, (z, sd) in self._readings.items()
            },
            "bounds": self._bounds,
        }
        return json.dumps(content, ensure_ascii=False, allow_nan=False)

    @classmethod
    def from_json(cls, text: str, where: str = "belief") -> Belief:
        """Return the belief that `to_json` wrote.

        Raises:
            InvalidInput: if the text is not such a belief.
        """
        try:
            content: dict[str, Any] = json.loads(text)
            if content["format"] != _FORMAT:
                raise InvalidInput(f"{where}: format", content["format"], _FORMAT)
            belief = cls(parse_network(content["network"], f"{where}: network"))
            for key in ("log_prior", "log_likelihood"):
                values = np.array([-np.inf if value is None else value for value in content[key]], dtype=float)
                if values.shape != belief._log_prior.shape:
                    raise InvalidInput(f"{where}: {key}", values.shape, f"shape {belief._log_prior.shape}")
                setattr(belief, f"_{key}", values)
            readings = content["readings"]
            for name, row in readings.items():
                belief = belief.update(Measurement(name, row["mean"], row["sd"], belief.network.unit(name)))
                belief._counts[name] = int(row["count"])
            for name, least in content.get("bounds", {}).items():
                belief = belief.update_bound(name, least, belief.network.unit(name))
        except (KeyError, TypeError, ValueError) as error:
            raise InvalidInput(where, repr(error), f"JSON of the format {_FORMAT}") from None
        return belief

    def save(self, path: str | Path) -> None:
        """Write the belief to a file."""
        Path(path).write_text(self.to_json() + "\n", encoding="utf-8")

    @classmethod
    def load(cls, path: str | Path) -> Belief:
        """Read a belief from a file.

        Raises:
            InvalidInput: if the file is not a belief.
        """
        return cls.from_json(Path(path).read_text(encoding="utf-8"), str(path))

    def _skewed(self, relation: Relation) -> dict[int, tuple[float, float]]:
        """Return the coordinates of a relation whose own reading leaves them far from Gaussian, with it."""
        if relation.kind == "sum":
            return {}
        found = {}
        for name, _ in relation.terms:
            z, sd = self._readings.get(name, (1.0, 0.0))
            if self.network.property(name).scale == LOG and sd > SKEWED * abs(z):
                found[self.network.index(name)] = (z, sd)
        return found

    def _rows(self, variable: str) -> np.ndarray:
        """Return the class index of every hypothesis, shape (K,)."""
        return self.network.hypotheses.category if variable == CATEGORY else self.network.hypotheses.material

    def _copy(self) -> Belief:
        twin = object.__new__(Belief)
        twin.network = self.network
        twin._log_prior, twin._log_likelihood = self._log_prior, self._log_likelihood
        twin._readings, twin._counts = dict(self._readings), dict(self._counts)
        twin._direct, twin._bounds = dict(self._direct), dict(self._bounds)
        return twin


def _fused(first: tuple[float, float], second: tuple[float, float]) -> tuple[float, float]:
    """Return the reading that says what two independent readings of one value say together."""
    (z1, s1), (z2, s2) = first, second
    smaller = min(s1, s2)
    a, b = (smaller / s1) ** 2, (smaller / s2) ** 2
    return (a * z1 + b * z2) / (a + b), smaller / math.sqrt(a + b)


def _reweighted(network: Network, prior: Mapping[str, float]) -> np.ndarray:
    """Return log prior weights of the hypotheses for given probabilities of materials or categories."""
    variable = next((v for v in network.variables if set(prior) <= set(network.classes(v))), None)
    if variable is None:
        known = network.classes(MATERIAL)
        raise UnknownName("prior", next(name for name in prior if name not in known), known)
    given = checked_probabilities(prior, "prior")
    if UNKNOWN not in given and network.unknown is not None:
        weight = network.unknown.weight
        given = {name: value * (1 - weight) for name, value in given.items()} | {UNKNOWN: weight}
    classes, bank = network.classes(variable), network.hypotheses
    rows = bank.category if variable == CATEGORY else bank.material
    own = np.exp(bank.log_weight)
    total = np.bincount(rows, weights=own, minlength=len(classes))
    size = np.bincount(rows, minlength=len(classes))
    new = np.array([given.get(name, 0.0) for name in classes])
    if np.any((size == 0) & (new > 0)):
        lost = classes[int(np.argmax((size == 0) & (new > 0)))]
        raise InvalidInput(f"prior: {lost}", given[lost], "0: no category of the reference contains it")
    share = np.where(total[rows] > 0, own / np.where(total[rows] > 0, total[rows], 1.0), 1.0 / size[rows])
    with np.errstate(divide="ignore"):
        return np.asarray(np.log(new[rows] * share))


def _finite_or_none(value: float) -> float | None:
    return value if math.isfinite(value) else None
