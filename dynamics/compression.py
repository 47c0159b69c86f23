"""Stress and strain of a squeezed object: what force and opening say of the material, by shape and contact.

One relation covers every case: a force F at the compression u of an object of width L obeys

    F / A = E h(u / L),        A = kappa * contact area,

with E the Young's modulus and h the *law* of the contact, h(e) = e where the object is strained evenly, and a
little less, e - b e^2, where pads smaller than its faces sink in. Stress is
F / A, strain is u / L, and every modulus is a slope of stress over h(strain): of the material, not of the shape.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from dynamics.errors import InvalidInput, UnknownName
from dynamics.gripper import ParallelGripper
from dynamics.hertz import approach_factor
from dynamics.indentation import indentation_factor
from dynamics.shapes import FILL, SHAPES, Lengths, Shape

Array = NDArray[np.float64]
Law = Literal["linear", "hertz", "line"]
Rule = Literal["auto", "face", "pad", "pad-area"]

LARGEST = 1.0  # m; nothing a gripper holds is wider, so a larger number is another unit
LARGEST_FORCE = 1e4  # N; a larger number is another unit
LINE_LOAD = 1.0  # largest line load over E* R that the law of the line contact is used for
LINE_TABLE = 512  # points of its inverse
UNKNOWN_SURFACE_SD = 0.3  # relative, of kappa, for a surface that no theory of contact is known of
SOFTENING = 0.13, 0.57  # b of pads much smaller than a face, and what Poisson's ratio adds: simulated, within 0.1
SOFTEST = 0.45  # largest b: h rises all the way
SOFTENS_TO = 0.5  # strain from which the linear law goes straight on


@dataclass(frozen=True)
class Geometry:
    """How an object's shape and the gripper's pads turn force into stress and opening into strain.

    Attributes:
        shape: one of `dynamics.shapes.SHAPES`.
        width: extent of the free object along the closing direction [m].
        contact_area: the area that the factor kappa refers to [m^2].
        kappa: force over E h(strain) and contact area [-].
        law: ``linear``: h(e) = e - b e^2, and straight on from e = 0.5; ``hertz``: h(e) = e^(3/2); ``line``: the
            inverse of e = h/pi (ln(4 pi/h) - 1), and straight on from ``covered``.
        kappa_sd: standard deviation of kappa [-].
        softening: b of the linear law [-].
        covered: strain from which the line contact is as wide as the pads and grows no more [-].
        series_stiffness, series_stiffness_sd: of gripper and pads in series with the object [N/m]; their
            deflection belongs to the opening but not to the object.

    Raises:
        InvalidInput: for a number out of range.
        UnknownName: for a shape or law that is not known.
    """

    shape: Shape
    width: float
    contact_area: float
    kappa: float = 1.0
    law: Law = "linear"
    kappa_sd: float = 0.0
    series_stiffness: float = math.inf
    series_stiffness_sd: float = 0.0
    covered: float = math.inf
    softening: float = 0.0

    def __post_init__(self) -> None:
        if self.shape not in SHAPES:
            raise UnknownName("geometry: shape", self.shape, SHAPES)
        if self.law not in get_args(Law):
            raise UnknownName("geometry: law", self.law, get_args(Law))
        _within("geometry: width [m]", self.width, LARGEST)
        _within("geometry: contact area [m^2]", self.contact_area, LARGEST**2)
        _within("geometry: kappa", self.kappa, 100.0)
        if not self.series_stiffness > 0:
            raise InvalidInput("geometry: series stiffness [N/m]", self.series_stiffness, "a number > 0")
        if not self.covered > 0:
            raise InvalidInput("geometry: covered", self.covered, "a strain > 0")
        if not 0 <= self.softening <= SOFTEST:
            raise InvalidInput("geometry: softening", self.softening, f"a number in [0, {SOFTEST}]")
        for name in ("kappa_sd", "series_stiffness_sd"):
            if not (math.isfinite(getattr(self, name)) and getattr(self, name) >= 0):
                raise InvalidInput(f"geometry: {name}", getattr(self, name), "a finite number >= 0")

    @property
    def area(self) -> float:
        """The area that turns force into stress, kappa times the contact area [m^2]."""
        return self.kappa * self.contact_area

    @property
    def series_compliance(self) -> float:
        """Strain that gripper and pads add per stress [1/Pa]."""
        return self.area / (self.series_stiffness * self.width)

    @property
    def series_compliance_sd(self) -> float:
        """Standard deviation of the strain that gripper and pads add per stress [1/Pa]."""
        return self.series_compliance * self.series_stiffness_sd / self.series_stiffness

    def law_of(self, strain: Array) -> Array:
        """Return h(strain), 0 where there is no compression, (N,)."""
        compression = np.maximum(strain, 0.0)
        if self.law == "linear":
            soft = np.minimum(compression, SOFTENS_TO)
            bent: Array = compression - self.softening * soft * (2 * compression - soft)
            return bent
        if self.law == "hertz":
            return compression**1.5
        strains, loads = _line_table()
        value: Array = np.interp(np.minimum(compression, self.covered), strains, loads)
        if math.isfinite(self.covered):
            slope = _line_slope(np.interp(np.array([self.covered]), strains, loads))
            value += slope * np.maximum(compression - self.covered, 0.0)
        return value

    def slope_of_law(self, strain: Array) -> Array:
        """Return dh/d(strain), 0 where there is no compression, (N,)."""
        compression = np.maximum(strain, 0.0)
        if self.law == "linear":
            return np.where(strain > 0, 1 - 2 * self.softening * np.minimum(compression, SOFTENS_TO), 0.0)
        if self.law == "hertz":
            return 1.5 * np.sqrt(compression)
        load = np.maximum(self.law_of(np.minimum(compression, self.covered)), 1e-12)
        slope: Array = np.where(strain > 0, _line_slope(load), 0.0)
        return slope


def geometry_of(
    shape: Shape,
    size: Lengths,
    gripper: ParallelGripper,
    *,
    poisson: float = 0.3,
    rule: Rule = "auto",
    fill: float | None = None,
) -> Geometry:
    """Return the geometry of an object between a gripper's pads.

    Rules:
        ``face``: the whole body is strained evenly, F = E (V / L) e with its volume V: a block under plates
        larger than its faces, and any shape in a simulation with one deformable cell.
        ``pad``: a box larger than the pads, F = kappa(nu, sizes) A_pad E (e - b e^2), kappa by
        :mod:`dynamics.indentation`, b = (0.13 + 0.57 nu) times the share of the face that is free; a sphere by
        Hertz, F = 4/3 E/(1 - nu^2) sqrt(R) (u/2)^(3/2) (Johnson, Contact Mechanics, 1985, eq. 4.23, at two
        contacts); an ellipsoid likewise by its radii of curvature, see :mod:`dynamics.hertz`; a cylinder along its
        side, u = 2 P (1 - nu^2)/(pi E) (2 ln(4R/a) - 1) with the load per length P and
        a^2 = 4 P R (1 - nu^2)/(pi E) (there, eq. 4.57, at two contacts), and straight on from where the contact is
        as wide as the pads. No theory covers every mesh: as the box of its width and its mean cross-section, with
        30 % uncertainty.
        ``pad-area``: stress is force over the pad's area whatever the object, as some publications do.
        ``auto``: the gripper's ``load_spread``.

    Args:
        shape: ``box``, ``sphere``, ``ellipsoid``, ``mesh``; ``cylinder``, its axis along the approach direction.
        size: extents along the closing direction, across it, and along the approach direction [m].
        gripper: gives the pads and their stiffness.
        poisson: Poisson's ratio of the object, in [0, 0.5).
        rule: see above.
        fill: share of its bounding box that the object fills; the shape's if None, and needed for a mesh.

    Raises:
        UnknownName: for a shape or rule that is not known.
        InvalidInput: for a size that is not positive, wider than the gripper opens or not in metres, a Poisson's
            ratio out of range, or a mesh without its fill.
    """
    if shape not in SHAPES:
        raise UnknownName("geometry: shape", shape, SHAPES)
    if rule not in get_args(Rule):
        raise UnknownName("geometry: rule", rule, get_args(Rule))
    if len(size) != 3:
        raise InvalidInput("geometry: size [m]", size, "three extents: closing direction, across, approach")
    for extent in size:
        _within("geometry: size [m]", extent, LARGEST)
    width, across, along = size
    if width > gripper.max_opening:
        raise InvalidInput(
            "geometry: size [m]",
            width,
            f"at most the opening of the gripper, {gripper.max_opening}, along closing",
        )
    if not 0 <= poisson < 0.5:
        raise InvalidInput("geometry: Poisson's ratio", poisson, "a number in [0, 0.5)")
    fill = FILL.get(shape) if fill is None else fill
    if fill is None or not 0 < fill <= 1 + 1e-9:
        raise InvalidInput("geometry: share of the bounding box", fill, "a number in (0, 1], for a mesh")
    spread = gripper.load_spread if rule == "auto" else rule
    touched = min(across, gripper.pad_width) * min(along, gripper.pad_length)
    kappa, kappa_sd, law, area, covered, softening = 1.0, 0.0, "linear", touched, math.inf, 0.0
    if spread == "face":
        area = fill * across * along
    elif spread == "pad-area":
        area = gripper.pad_area
    elif shape == "box":
        kappa, kappa_sd = indentation_factor(size, (gripper.pad_width, gripper.pad_length), poisson)
        softening = (SOFTENING[0] + SOFTENING[1] * poisson) * (1 - touched / (across * along))
    elif shape == "mesh":
        # Rounded blocks are 0.72 to 1.05 times as stiff as this one: simulated with 2 and 4 cells, to 10 and 30 %.
        block = (width, across * math.sqrt(fill), along * math.sqrt(fill))
        area = min(block[1], gripper.pad_width) * min(block[2], gripper.pad_length)
        kappa, sd = indentation_factor(block, (gripper.pad_width, gripper.pad_length), poisson)
        kappa_sd = math.hypot(sd, UNKNOWN_SURFACE_SD * kappa)
    elif shape in ("sphere", "ellipsoid"):
        area, kappa, law = math.pi * across * along / 4, _hertz(size) / (1 - poisson**2), "hertz"
    else:
        area, kappa, law = width * min(along, gripper.pad_length), 1 / (2 * (1 - poisson**2)), "line"
        covered = _covering_strain(width, gripper.pad_width)
    return Geometry(
        shape=shape,
        width=width,
        contact_area=area,
        kappa=kappa,
        law=law,  # type: ignore[arg-type]
        kappa_sd=kappa_sd,
        series_stiffness=gripper.stiffness,
        series_stiffness_sd=gripper.stiffness_sd,
        covered=covered,
        softening=softening,
    )


@dataclass(frozen=True)
class StressStrain:
    """A stress-strain curve as it was read, compression positive.

    Attributes:
        strain: (width - opening) / width, negative before contact [-], (N,). The deflection of gripper and pads
            is still in it.
        stress: force over area [Pa], (N,).
        geometry: how they were made.
    """

    strain: Array
    stress: Array
    geometry: Geometry

    def __len__(self) -> int:
        return len(self.strain)


def stress_strain(force: Array, opening: Array, geometry: Geometry) -> StressStrain:
    """Turn force and opening into stress and strain.

        stress = force / area,     strain = (width - opening) / width.

    Args:
        force: what one pad presses with, compression positive [N], (N,), in the order it was read.
        opening: distance of the pads [m], (N,).
        geometry: of object and pads.

    Raises:
        InvalidInput: for wrong shapes, numbers that are not finite, or numbers that can only be another unit.
    """
    force, opening = np.asarray(force, dtype=np.float64), np.asarray(opening, dtype=np.float64)
    if force.ndim != 1 or force.shape != opening.shape:
        raise InvalidInput(
            "stress and strain", f"shapes {force.shape} and {opening.shape}", "two equal shapes (N,)"
        )
    for name, series in (("force", force), ("opening", opening)):
        if not np.all(np.isfinite(series)):
            at = int(np.argmax(~np.isfinite(series)))
            raise InvalidInput(f"stress and strain: {name}", f"{series[at]} at {at}", "finite numbers")
    if len(opening) and (np.max(opening) > LARGEST or np.min(opening) < -0.01):
        raise InvalidInput(
            "stress and strain: opening",
            f"{np.min(opening):g} to {np.max(opening):g}",
            f"metres, 0 to {LARGEST:g}",
        )
    if len(force) and np.median(np.abs(force)) > LARGEST_FORCE:
        raise InvalidInput("stress and strain: force", np.median(np.abs(force)), f"newtons, to {LARGEST_FORCE:g}")
    return StressStrain((geometry.width - opening) / geometry.width, force / geometry.area, geometry)


def _hertz(size: Lengths) -> float:
    """Return F (1 - nu^2) / (E area h(e)) of an ellipsoid between plates; 4 / (3 pi) for a ball."""
    width, across, along = size
    radii = across**2 / (2 * width), along**2 / (2 * width)
    mean, ratio = math.sqrt(radii[0] * radii[1]), max(radii) / min(radii)
    approach = width / 2 / approach_factor(ratio)
    return 4 / 3 * math.sqrt(mean * approach) * approach / (math.pi * across * along / 4)


def _line_table() -> tuple[Array, Array]:
    """Return strain and load of the line contact, the load over E* R, from 0 on."""
    loads = np.concatenate([[0.0], np.geomspace(1e-9, LINE_LOAD, LINE_TABLE)])
    strains = np.zeros_like(loads)
    strains[1:] = loads[1:] / math.pi * (np.log(4 * math.pi / loads[1:]) - 1.0)
    return strains, loads


def _line_slope(load: Array) -> Array:
    """Return dh/d(strain) of the line contact at a load over E* R."""
    slope: Array = math.pi / (np.log(4 * math.pi / load) - 2.0)
    return slope


def _covering_strain(width: float, pad_width: float) -> float:
    """Return the strain at which the contact of a cylinder with a flat is as wide as a pad; inf if it never is.

    Half its width is a = R sqrt(4 h / pi) at the load h = F / (L E* R) (Johnson, 1985, eq. 4.43).
    """
    load = math.pi / 4 * (pad_width / width) ** 2
    return load / math.pi * (math.log(4 * math.pi / load) - 1.0) if load < LINE_LOAD else math.inf


def _within(where: str, value: float, largest: float) -> None:
    if not (math.isfinite(value) and 0 < value <= largest):
        raise InvalidInput(where, value, f"a number in (0, {largest:g}]")
