"""Classifiers that perceive the object: eyes, or ears, drawn in simulation or told by a vision module."""

from __future__ import annotations

import json
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from dynamics.errors import InvalidInput, UnknownName
from estimation.json_checks import mapping, number, only
from estimation.network import UNKNOWN, Network
from estimation.observation import Observation
from estimation.sensor import ClassSensor

VISION_FORMAT = "palpate-vision/1"
_LARGEST = 1 << 20  # bytes of a vision file


class Classifier(Protocol):
    """Tells what class an object seems to be of, each time it is asked."""

    def perceive(self) -> Observation:
        """Return what is perceived now."""
        ...


Senses = Mapping[str, Classifier]
"""Classifiers by the name of the reference's sensor model: ``observe``, ``sound``."""


@dataclass(frozen=True)
class Told:
    """A classifier that has been asked already.

    Attributes:
        observation: its answer.
    """

    observation: Observation

    def perceive(self) -> Observation:
        """Return the answer."""
        return self.observation


def drawn(sensor: ClassSensor, truth: str, seed: tuple[int, ...]) -> Told:
    """Return a simulated classifier: its outcome is drawn from the confusion matrix, given the true class.

    The error of a classifier is common to all its looks at one object, so it is drawn once and every look has the
    same outcome; nothing but that is kept of the truth. An object of no listed class is called what the
    classifier says on average.

    Args:
        sensor: the confusion matrix.
        truth: the true class, or anything else for none of the listed ones.
        seed: of the draw.
    """
    known, matrix = sensor.classes, sensor.matrix
    column = matrix[:, known.index(truth)] if truth in known else matrix.mean(axis=1)
    outcome = int(np.random.default_rng(seed).choice(len(column), p=column / column.sum()))
    return Told(Observation.of(sensor.variable, sensor.likelihoods(sensor.outcomes[outcome])))


def drawn_senses(network: Network, truth: Mapping[str, str], seed: int) -> dict[str, Classifier]:
    """Return simulated classifiers, one for every classifier of a reference.

    Args:
        network: the reference.
        truth: the true class by variable.
        seed: of all draws.
    """
    return {
        name: drawn(sensor, truth.get(sensor.variable, UNKNOWN), (seed, zlib.crc32(name.encode())))
        for name, sensor in network.sensors
        if isinstance(sensor, ClassSensor)
    }


def read_vision(path: Path, network: Network, name: str = "observe") -> Told:
    """Read what a vision module made of the object (format: docs/references.md).

    Args:
        path: a JSON file.
        network: the reference; its classifier of that name says how far the module is to be trusted.
        name: of the classifier.

    Raises:
        InvalidInput: for a file that cannot be read or a value that is unusable, naming file, key and value.
        UnknownName: for a key, variable, class or outcome that is not known.
    """
    spec = _content(path)
    where = str(path)
    only(spec, ("format", "variable", "output", "likelihoods"), where)
    if spec.get("format") != VISION_FORMAT:
        raise InvalidInput(f"{where}: format", spec.get("format"), VISION_FORMAT)
    sensor = _classifier(network, name)
    if spec.get("variable", sensor.variable) != sensor.variable:
        raise UnknownName(f"{where}: variable", spec.get("variable"), (sensor.variable,))
    given = [key for key in ("output", "likelihoods") if key in spec]
    if len(given) != 1:
        raise InvalidInput(where, given or "neither", "either output or likelihoods")
    place = f"{where}: {given[0]}"
    table = {key: number(value, f"{place}: {key}") for key, value in mapping(spec[given[0]], place).items()}
    for key, value in table.items():
        if value < 0:
            raise InvalidInput(f"{place}: {key}", value, "a number >= 0")
    names = sensor.outcomes if given == ["output"] else sensor.classes
    for key in table:
        if key not in names:
            raise UnknownName(place, key, names)
    if given == ["output"]:
        if abs(sum(table.values()) - 1) > 1e-3:
            raise InvalidInput(f"{place}: sum", sum(table.values()), "probabilities that sum to 1")
        table = sensor.likelihoods(table)
    missing = [key for key in sensor.classes if key not in table]
    if missing:
        raise InvalidInput(place, sorted(table), f"a likelihood for {missing[0]}")
    if not any(table.values()):
        raise InvalidInput(place, "zeros only", "a likelihood > 0 for one class at least")
    return Told(Observation.of(sensor.variable, table))


def chosen_senses(own: Senses, eyes: Classifier | None, vision: str, camera: bool) -> Senses:
    """Return the classifiers to explore with.

    Args:
        own: those that came with the robot.
        eyes: what a vision module told, if it was asked.
        vision: ``none`` for no looking at all.
        camera: whether the arm has one.
    """
    if eyes is not None:
        return {**own, "observe": eyes}
    if vision == "none" or not camera:
        return {name: sense for name, sense in own.items() if name != "observe"}
    return own


def _classifier(network: Network, name: str) -> ClassSensor:
    sensor = dict(network.sensors).get(name)
    if not isinstance(sensor, ClassSensor):
        valid = f"a classifier named {name}: how far what is seen is to be trusted"
        raise InvalidInput(f"reference {network.name}: sensors", [key for key, _ in network.sensors], valid)
    return sensor


def _content(path: Path) -> Mapping[str, Any]:
    try:
        with path.open("rb") as stream:
            text = stream.read(_LARGEST + 1)
        if len(text) > _LARGEST:
            raise InvalidInput(str(path), f"more than {_LARGEST} bytes", "a small JSON file")
        content = json.loads(text)
    except OSError as error:
        raise InvalidInput(str(path), error.strerror or str(error), "a readable JSON file") from None
    except (ValueError, RecursionError) as error:
        raise InvalidInput(str(path), str(error), "a JSON object") from None
    return mapping(content, str(path))
