"""The thesis' optimization modes 1, 2 and 3, literally, so that its tables can be compared.

They are kept for comparison. Mode 1 estimates I(material; z) by sampling; Mode 2 is no information gain (of
one Gaussian it never exceeds half a bit, however good the sensor); Mode 3 adds the two.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

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


def update(pmf: np.ndarray, prop: ThesisProperty, z: float) -> np.ndarray:
    """Return the thesis' Bayesian update of the material (Eqs. 3.10 and 3.17).

    Args:
        pmf: probabilities of the materials, the joker last where it takes part, shape (M,) or (M + 1,).
        prop: the property measured.
        z: the reading.
    """
    likelihood = _likelihoods(pmf, prop, np.array([z]))[0]
    posterior = pmf * likelihood
    return np.asarray(posterior / posterior.sum())


def mode_1(pmf: np.ndarray, prop: ThesisProperty, rng: np.random.Generator, samples: int = 100) -> float:
    """Return the discrete information gain of Algorithm 1 in bits: H(M) - mean over samples of H(M | z)."""
    component = rng.choice(len(pmf), size=samples, p=pmf)
    known = np.minimum(component, len(prop.means) - 1)
    total = np.hypot(prop.sds, prop.noise)
    z = np.where(
        component < len(prop.means),
        rng.normal(prop.means[known], total[known]),
        rng.uniform(prop.low, prop.high, size=samples),
    )
    posterior = pmf * _likelihoods(pmf, prop, z)
    posterior /= posterior.sum(axis=1, keepdims=True)
    return _bits(pmf) - float(np.mean([_bits(row) for row in posterior]))


def mode_2(pmf: np.ndarray, prop: ThesisProperty) -> float:
    """Return the differential information gain of Algorithm 2 in bits: H(f) - H(f o (f * g)).

    The belief f is convolved on the working window with the measurement error g (Eq. 3.30) and multiplied
    by itself (Eq. 3.31); the product is normalised, as section 3.3.6 says and Algorithm 2 leaves out.
    """
    x = prop.grid
    step = float(x[1] - x[0])
    prior = _mixture(pmf, prop, x)
    emulation = np.convolve(prior, _normal(x, 0.5 * (prop.low + prop.high), prop.noise), mode="same")
    product = prior * emulation
    prior, product = prior / (prior.sum() * step), product / (product.sum() * step)
    return _differential(prior, step) - _differential(product, step)


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


def _likelihoods(pmf: np.ndarray, prop: ThesisProperty, z: np.ndarray) -> np.ndarray:
    """Return p(z | material), shape (N, len(pmf))."""
    total = np.hypot(prop.sds, prop.noise)
    found = _normal(z[:, None], prop.means, total)
    if len(pmf) == len(prop.means):
        return found
    inside = np.full(len(z), 1.0 / (prop.high - prop.low))
    return np.column_stack([found, inside])


def _mixture(pmf: np.ndarray, prop: ThesisProperty, x: np.ndarray) -> np.ndarray:
    known = len(prop.means)
    density = _normal(x[:, None], prop.means, prop.sds) @ pmf[:known]
    if len(pmf) > known:
        density = density + pmf[known] / (prop.high - prop.low)
    return np.asarray(density)


def _normal(x: np.ndarray, mean: np.ndarray | float, sd: np.ndarray | float) -> np.ndarray:
    return np.asarray(np.exp(-0.5 * ((x - mean) / sd) ** 2) / (sd * math.sqrt(2 * math.pi)))


def _bits(pmf: np.ndarray) -> float:
    used = pmf[pmf > 0]
    return -float(np.sum(used * np.log2(used)))


def _differential(density: np.ndarray, step: float) -> float:
    """Return the differential entropy of Eq. 3.26 in bits."""
    used = density[density > 0]
    return -step * float(np.sum(used * np.log2(used)))
