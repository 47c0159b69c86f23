"""The thesis' optimization modes 1, 2 and 3, literally, so that its tables can be compared.

They are kept for comparison. Mode 1 estimates I(material; z) by sampling; Mode 2 is no information gain (of
one Gaussian it never exceeds half a bit, however good the sensor); Mode 3 adds the two.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from dynamics.errors import InvalidInput, UnknownName
from estimation.network import LINEAR, MATERIAL, Network
from estimation.sensor import Sensor

JOKER = "joker"
MODES = ("mode 1", "mode 2", "mode 3")


@dataclass(frozen=True, eq=False)
class ThesisProperty:
    """A property as the thesis sees it: one Gaussian per material, a noise, and a working window.

    Attributes:
        name: such as ``density``.
        means: reference means, shape (M,).
        sds: reference standard deviations, shape (M,).
        noise: measurement error sd.
        low: lower end of the working window, on which the joker is uniform.
        high: its upper end.
        bins: number of bins of the window, odd.
    """

    name: str
    means: np.ndarray
    sds: np.ndarray
    noise: float
    low: float
    high: float
    bins: int = 3001

    @property
    def grid(self) -> np.ndarray:
        """The window's bins, shape (bins,)."""
        return np.linspace(self.low, self.high, self.bins)

    @cached_property
    def densities(self) -> np.ndarray:
        """Density of every material, and last of the joker, on the bins, shape (M + 1, bins)."""
        known = _normal(self.grid, self.means[:, None], self.sds[:, None])
        return np.vstack([known, np.full(self.bins, 1.0 / (self.high - self.low))])

    @cached_property
    def emulations(self) -> np.ndarray:
        """The same convolved with the measurement error on the working window (Eq. 3.30)."""
        error = _normal(self.grid, 0.5 * (self.low + self.high), self.noise)
        return np.stack([np.convolve(density, error, mode="same") for density in self.densities])


def thesis_properties(network: Network, window_sds: float = 5.0) -> tuple[ThesisProperty, ...]:
    """Return the measurable properties of a network.

    A working window reaches from the lowest class to the highest one, and so many of their sds beyond.

    Raises:
        InvalidInput: if a property is not a Gaussian per material.
    """
    found = []
    for _, sensor in network.sensors:
        if not isinstance(sensor, Sensor):
            continue
        prop = network.property(sensor.property)
        if prop.scale != LINEAR or prop.parent != MATERIAL:
            raise InvalidInput(f"thesis modes: {prop.name}", prop.scale, "a linear property of the material")
        means, sds = np.array(prop.means), np.array(prop.sds)
        lowest, highest = int(means.argmin()), int(means.argmax())
        low = float(means[lowest] - window_sds * sds[lowest])
        high = float(means[highest] + window_sds * sds[highest])
        found.append(ThesisProperty(prop.name, means, sds, sensor.sd, low, high))
    return tuple(found)


def update(pmf: np.ndarray, prop: ThesisProperty, z: float | np.ndarray) -> np.ndarray:
    """Return the thesis' Bayesian update of the material (Eqs. 3.10 and 3.17), of one belief or of many.

    Args:
        pmf: probabilities of the materials, the joker last where it takes part, shape (..., M) or (..., M + 1).
        prop: the property measured.
        z: the reading, shape (...).
    """
    posterior = pmf * _likelihoods(pmf.shape[-1], prop, np.asarray(z))
    return np.asarray(posterior / posterior.sum(axis=-1, keepdims=True))


def mode_1(pmf: np.ndarray, prop: ThesisProperty, rng: np.random.Generator, samples: int = 100) -> float:
    """Return the discrete information gain of Algorithm 1 in bits: H(M) - mean over samples of H(M | z)."""
    return float(material_gain(pmf, prop, emulated(pmf, prop, rng.random(samples), rng.standard_normal(samples))))


def emulated(pmf: np.ndarray, prop: ThesisProperty, picks: np.ndarray, errors: np.ndarray) -> np.ndarray:
    """Return readings drawn from the prior widened by the measurement error (section 3.3.5).

    Args:
        pmf: probabilities, shape (..., M) or (..., M + 1).
        prop: the property.
        picks: uniform numbers that pick the component, and the joker's place, shape (..., N).
        errors: standard normal numbers, shape (..., N).
    """
    ends = np.cumsum(pmf, axis=-1) / pmf.sum(axis=-1, keepdims=True)
    component = (picks[..., None] >= ends[..., None, :-1]).sum(axis=-1)
    known = np.minimum(component, len(prop.means) - 1)
    total = np.hypot(prop.sds, prop.noise)
    gaussian = prop.means[known] + total[known] * errors
    if pmf.shape[-1] == len(prop.means):
        return np.asarray(gaussian)
    joker = np.maximum(pmf[..., -1:], 1e-300) / pmf.sum(axis=-1, keepdims=True)
    place = np.clip((picks - ends[..., -2:-1]) / joker, 0.0, 1.0)
    inside = prop.low + place * (prop.high - prop.low)
    return np.asarray(np.where(component < len(prop.means), gaussian, inside))


def material_gain(pmf: np.ndarray, prop: ThesisProperty, z: np.ndarray) -> np.ndarray:
    """Return H(M) - mean over emulated readings of H(M | z) in bits, of one belief or of many.

    Args:
        pmf: probabilities, shape (..., M) or (..., M + 1).
        prop: the property.
        z: emulated readings, shape (..., N).
    """
    return np.asarray(_bits(pmf) - _bits(update(pmf[..., None, :], prop, z)).mean(axis=-1))


def mode_2(pmf: np.ndarray, prop: ThesisProperty) -> float:
    """Return the differential information gain of Algorithm 2 in bits: H(f) - H(f o (f * g)).

    The belief f is convolved on the working window with the measurement error g (Eq. 3.30) and multiplied
    by itself (Eq. 3.31); the product is normalised, as section 3.3.6 says and Algorithm 2 leaves out.
    """
    return float(property_gain(pmf, prop))


def property_gain(pmf: np.ndarray, prop: ThesisProperty) -> np.ndarray:
    """Return the differential information gain of Mode 2 in bits, of one belief or of many.

    Args:
        pmf: probabilities, shape (..., M) or (..., M + 1).
        prop: the property.
    """
    step = (prop.high - prop.low) / (prop.bins - 1)
    used = slice(pmf.shape[-1])
    prior, emulation = pmf @ prop.densities[used], pmf @ prop.emulations[used]
    before = _differential(prior, step)
    prior *= emulation
    return np.asarray(before - _differential(prior, step))


def mode_3(pmf: np.ndarray, prop: ThesisProperty, rng: np.random.Generator, samples: int = 100) -> float:
    """Return the hybrid sum of Mode 1 and Mode 2."""
    return mode_1(pmf, prop, rng, samples) + mode_2(pmf, prop)


def planned(
    mode: str, pmf: np.ndarray, properties: Sequence[ThesisProperty], rng: np.random.Generator
) -> str | None:
    """Return the property that a mode measures next, or None when no gain is positive.

    Raises:
        UnknownName: if there is no such mode.
    """
    if mode not in MODES:
        raise UnknownName("thesis mode", mode, MODES)
    best, choice = 0.0, None
    for prop in properties:
        if mode == "mode 1":
            gain = mode_1(pmf, prop, rng)
        elif mode == "mode 2":
            gain = mode_2(pmf, prop)
        else:
            gain = mode_3(pmf, prop, rng)
        if gain > best:
            best, choice = gain, prop.name
    return choice


def pmf_of(network: Network, probabilities: Mapping[str, float]) -> np.ndarray:
    """Return probabilities of the materials in the network's order, the joker last if it is among them.

    Raises:
        UnknownName: if a name is neither a material nor the joker.
    """
    names = (*network.materials, *((JOKER,) if JOKER in probabilities else ()))
    for name in probabilities:
        if name not in names:
            raise UnknownName("prior", name, names)
    pmf = np.array([probabilities.get(name, 0.0) for name in names])
    return np.asarray(pmf / pmf.sum())


def _likelihoods(count: int, prop: ThesisProperty, z: np.ndarray) -> np.ndarray:
    """Return p(z | material), the joker last where it takes part, shape (..., count)."""
    total = np.hypot(prop.sds, prop.noise)
    found = _normal(z[..., None], prop.means, total)
    if count == len(prop.means):
        return found
    inside = np.full((*z.shape, 1), 1.0 / (prop.high - prop.low))
    return np.concatenate([found, inside], axis=-1)


def _normal(x: np.ndarray, mean: np.ndarray | float, sd: np.ndarray | float) -> np.ndarray:
    return np.asarray(np.exp(-0.5 * ((x - mean) / sd) ** 2) / (sd * math.sqrt(2 * math.pi)))


def _bits(pmf: np.ndarray) -> np.ndarray:
    return np.asarray(-np.sum(pmf * np.log2(np.where(pmf > 0, pmf, 1.0)), axis=-1))


def _differential(density: np.ndarray, step: float) -> np.ndarray:
    """Return the differential entropy of Eq. 3.26 in bits, of a density that need not be normalised."""
    total = density.sum(axis=-1)
    log = np.maximum(density, 1e-300)
    np.log2(log, out=log)
    return np.asarray(np.log2(total * step) - np.einsum("...i,...i->...", density, log) / total)
