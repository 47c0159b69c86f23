"""What a squeeze tells: the phases of the action become a stiffness and measurements of elasticity and width.

The motor current tells of force only while the gripper closes, so only readings of moving pads are used: those
of ``close`` (through the air into contact) and of every ``compress``. The current in air comes from ``air``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from dynamics.compression import Geometry, Rule, StressStrain, geometry_of, stress_strain
from dynamics.errors import InvalidInput
from dynamics.gripper import ParallelGripper
from dynamics.shapes import Shape
from dynamics.signals import GripperReadings, Phase
from estimation.bounds import elasticity_at_least
from estimation.carried import pull_of_weight
from estimation.measurement import Measurement
from estimation.springing import PLASTIC, elastic_readings, lost_work
from estimation.stiffness import (
    CurveNoise,
    NoContact,
    StiffnessEstimate,
    TooLittleCompression,
    estimate_stiffness,
)
from estimation.stiffness.fit import predict
from estimation.stiffness.noise import quantum_of
from estimation.stiffness.unyielding import hardly_gives

Array = NDArray[np.float64]

CURRENT_SD = 0.01  # A; noise of a current reading, where only its shape over force matters
CURRENT_RELATIVE_SD = 0.02  # and the part that grows with the current
FEW_TICKS = 2.0  # steps of the opening in contact below which not even a wide interval is given
DELAYS = (0.005, 0.01, 0.015, 0.02)  # s
DELAY_EVIDENCE = 6.0  # log-likelihood that a delay must gain
LATE_LOAD = 0.25  # share of the largest force above which the readings of the loading are taken to begin late,
EARLY_SHARE = 0.05  # but for so many of them
RIGID_STEP = 5e-3  # strain to which the opening over an object that has not given way is believed
RIGID_STRAIN = 1e-3  # compression of all squeezes below which an object has not given way
PUSHED = 0.25  # share of the largest force on what does not give, up to which it may be pushed along the table
SETTLING = 2  # samples left out at the start of a motion, where the motor still speeds up


def measure_squeeze(
    gripper: ParallelGripper,
    shape: Shape,
    size: tuple[float, float, float],
    phases: Sequence[Phase],
    *,
    size_sd: tuple[float, float, float] = (0.0, 0.0, 0.0),
    poisson: float = 0.3,
    rule: Rule = "auto",
    fill: float | None = None,
    weight: float = 0.0,
    method_sd: float = 0.0,
) -> tuple[StiffnessEstimate, tuple[Measurement, ...]]:
    """Estimate the stiffness of a squeezed object and measure its elasticity and width.

    Force is ``force_per_ampere (current - current in air)`` plus what friction swallows; the uncertainty of both
    is in the interval and in the measurements' standard deviations. Compression of 2 to 10 steps of the opening
    gives a wide interval, less a bound. Of an object that does
    not spring back only the readings count that pressed it again, no further than before: its elastic modulus, by
    the size it had.

    Args:
        gripper: what closed on the object.
        shape, size: of the object: extents along the closing direction, across it, along the approach [m].
        phases: of one squeeze: at least one ``air`` and one ``close`` or ``compress``; others are not looked at.
        size_sd: standard deviations of the extents [m].
        poisson: Poisson's ratio of the object.
        rule: how force spreads in the object, see :func:`dynamics.compression.geometry_of`.
        fill: share of its bounding box that the object fills, for a mesh.
        weight: that hangs between the pads [N], see :mod:`estimation.carried`.
        method_sd: relative standard deviation of all that formula and grip leave out.

    Returns:
        The estimate, and measurements of ``elasticity`` [Pa] (of ``compliance`` [1/Pa] if it is a bound, see
        :mod:`estimation.bounds`) and of ``width`` [m] (unless the readings leave open where it was touched).

    Raises:
        NoContact: if the force never rose.
        InvalidInput: if a phase is missing or has no readings of moving pads, or a size is out of range.
    """
    for name in ("air", "compress"):
        if not any(phase.name == name for phase in phases):
            raise InvalidInput(
                "squeeze: phases", sorted({phase.name for phase in phases}), f"a phase named {name}"
            )
    air, air_sd = air_current(_readings(phases, "air"), gripper)
    quantum = _quantum(gripper, phases)
    closing = _readings(phases, "close", "compress")
    if lost_work(phases, air, quantum) > PLASTIC:
        closing = elastic_readings(phases) or closing
    rigid = _gave_by(closing) <= max(quantum, RIGID_STRAIN * size[0])
    if rigid:  # then only how the grasp met it shows where it is, and its give is not told from that of the pads
        closing = _readings(phases, "grasp") + closing
        if quantum == 0:
            quantum = RIGID_STEP * size[0]
            closing = [replace(r, opening=np.round(r.opening / quantum) * quantum) for r in closing]
    locked = locked_current(_readings(phases, "dwell"))
    geometry = geometry_of(shape, size, gripper, poisson=poisson, rule=rule, fill=fill)
    noise = CurveNoise(
        stress_sd=_force_sd(np.zeros(1), gripper) / geometry.area,
        scale_known=False,
        strain_quantum=quantum / geometry.width,
        baseline_sd=max(air_sd * gripper.force_per_ampere, 1e-6) / geometry.area,
        deadband=gripper.friction_force / geometry.area,
        deadband_sd=gripper.friction_force_sd / geometry.area,
        gain_sd=math.hypot(
            method_sd, _gain_sd(gripper, shape, size, size_sd, geometry.contact_area == gripper.pad_area)
        ),
    )
    reported, reported_effort = _reported(closing, locked, rigid)
    reported_force = gripper.force_per_ampere * (reported_effort - air)
    if rigid:  # before both pads press on it, one may push it along the table, if it stands aside
        pressed = reported_force > PUSHED * np.max(reported_force, initial=0.0)
        reported, reported_force = reported[pressed], reported_force[pressed]
    reported_sd = _force_sd(np.maximum(reported_force, 0.0), gripper)
    estimate = hardly_gives(reported, reported_force, reported_sd, quantum, geometry, noise)
    if estimate is None:
        opening, effort, speed = closing_readings(closing, quantum, locked, stuck=rigid)
        force = gripper.force_per_ampere * (effort - air)
        if weight > 0:
            force = force + pull_of_weight(gripper, weight, opening)
        noise = replace(noise, stress_sd=_force_sd(np.zeros(len(force)), gripper) / geometry.area)
        try:
            estimate = _estimate(force, opening, speed, geometry, noise, gripper)
        except TooLittleCompression as little:
            estimate = little.estimate
        except NoContact:
            # Pressed all the same, but it moved between the pads: force and opening make no line, only a bound.
            estimate = hardly_gives(reported, reported_force, reported_sd, quantum, geometry, noise, math.inf)
            if estimate is None:
                raise
    widths: tuple[Measurement, ...] = ()
    if math.isfinite(estimate.onset_sd):  # an object that hardly gives may have been touched anywhere
        sd = math.hypot(estimate.onset_sd, _resolution(quantum))
        widths = (Measurement("width", estimate.onset, sd, "m"),)
    if estimate.bound is not None:
        told = (elasticity_at_least(estimate.bound),) if estimate.bound > 0 else ()
        return estimate, (*told, *widths)
    return estimate, (Measurement("elasticity", estimate.young_modulus, estimate.sd, "Pa"), *widths)


def closing_curve(gripper: ParallelGripper, geometry: Geometry, phases: Sequence[Phase]) -> StressStrain:
    """Return stress over strain of all readings of closing pads in a squeeze.

    Raises:
        InvalidInput: if the pads hardly move.
    """
    air, _ = air_current(_readings(phases, "air"), gripper)
    locked = locked_current(_readings(phases, "dwell"))
    closing = _readings(phases, "close", "compress")
    opening, effort, _ = closing_readings(closing, _quantum(gripper, phases), locked)
    return stress_strain(gripper.force_per_ampere * (effort - air), opening, geometry)


def _estimate(
    force: Array,
    opening: Array,
    speed: Array,
    geometry: Geometry,
    noise: CurveNoise,
    gripper: ParallelGripper,
) -> StiffnessEstimate:
    """Return the estimate with the noise and the delay that fit the readings best."""
    # Only a block's curve bends by its material alone: what contact does to that of others would be taken for it.
    degree = 3 if geometry.shape == "box" and _begins_early(force) else 1
    first = estimate_stiffness(
        stress_strain(force, opening, geometry), noise, min_ticks=FEW_TICKS, max_degree=degree
    )
    # The noise grows with the force: known only now, and from the fit, for a reading's own noise must not set its
    # weight.
    curve = stress_strain(force, opening, geometry)
    level = predict(first.fit.parameters, curve.strain, geometry)[0] * geometry.area
    noise = replace(noise, stress_sd=_force_sd(level, gripper) / geometry.area)
    best = estimate_stiffness(curve, noise, min_ticks=FEW_TICKS, max_degree=degree)
    quantum = noise.strain_quantum * geometry.width
    evidence = best.fit.log_likelihood + DELAY_EVIDENCE
    for delay in DELAYS:
        # A viscous material answers to u + delay du/dt, and so does a sensor that is late.
        curve = stress_strain(force, opening - delay * speed, geometry)
        try:
            found = estimate_stiffness(curve, noise, min_ticks=FEW_TICKS, max_degree=degree)
        except InvalidInput:  # with that delay the readings would not begin at the object
            continue
        if found.fit.log_likelihood > evidence and found.compression > quantum:
            best, evidence = found, found.fit.log_likelihood
    return best


def _begins_early(force: Array) -> bool:
    """Tell whether the loading is seen from near its begin, so that a curve's slope there is no extrapolation."""
    return float(np.quantile(force, EARLY_SHARE)) < LATE_LOAD * float(np.max(force))


def locked_current(dwells: Sequence[GripperReadings]) -> float:
    """Return the current above which the pads must be moving [A]; infinite where the gripper was never locked."""
    effort = np.concatenate([np.zeros(0), *(readings.effort for readings in dwells)])
    if len(effort) < 3:
        return math.inf
    middle = float(np.median(effort))
    return middle + max(5 * 1.4826 * float(np.median(np.abs(effort - middle))), 0.05)


def air_current(tares: Sequence[GripperReadings], gripper: ParallelGripper) -> tuple[float, float]:
    """Return the current of a gripper closing in air and its standard deviation [A].

    Raises:
        InvalidInput: if the pads did not move.
    """
    efforts = [readings.effort[moving(readings)] for readings in tares]
    effort = np.concatenate([np.zeros(0), *efforts])
    if len(effort) < 3:
        raise InvalidInput("squeeze: air", f"{len(effort)} readings of moving pads", "at least 3")
    air = float(np.median(effort))
    if float(np.std(effort)) > 0:  # the mean resolves less than a step of the current, the median does not
        near = effort[np.abs(effort - air) <= 3 * CURRENT_SD + gripper.effort_quantum]
        air = float(np.mean(near))
    spread = max(float(np.std(effort)), gripper.effort_quantum / math.sqrt(12.0), 1e-6)
    return air, spread * math.sqrt(math.pi / 2 / len(effort)) + 1e-9


def closing_readings(
    series: Sequence[GripperReadings], quantum: float, locked: float = math.inf, stuck: bool = False
) -> tuple[Array, Array, Array]:
    """Return opening [m], current [A] and closing speed [m/s] of the readings with closing pads.

    An opening that is reported in steps is interpolated between them.

    Raises:
        InvalidInput: if the pads hardly move.
    """
    openings, efforts, speeds = [np.zeros(0)], [np.zeros(0)], [np.zeros(0)]
    for readings in series:
        at = moving(readings, locked, stuck)
        if at.any():
            smooth = between_steps(readings) if quantum > 0 else readings.opening
            openings.append(smooth[at])
            efforts.append(readings.effort[at])
            speeds.append(_speed(readings.time, smooth)[at])
    opening, effort, speed = np.concatenate(openings), np.concatenate(efforts), np.concatenate(speeds)
    if len(opening) < 7:
        raise InvalidInput("squeeze: close, compress", f"{len(opening)} readings of closing pads", "at least 7")
    return opening, effort, speed


def _reported(series: Sequence[GripperReadings], locked: float, stuck: bool) -> tuple[Array, Array]:
    """Return opening [m] and current [A] of closing pads as they were reported, (N,) each."""
    at = [moving(readings, locked, stuck) for readings in series]
    opening = np.concatenate([readings.opening[rows] for readings, rows in zip(series, at, strict=True)])
    return opening, np.concatenate([readings.effort[rows] for readings, rows in zip(series, at, strict=True)])


def moving(readings: GripperReadings, locked: float = math.inf, stuck: bool = False) -> NDArray[np.bool_]:
    """Return which readings were taken while the pads closed, (N,).

    Those between the first and the last step of the opening, and those with more current than a locked gripper's,
    for an object so stiff that the opening hardly steps. The first few are left out: the motor still speeds up,
    and its current is no force. Readings without a step count only if the pads are known to be ``stuck``, closing
    on what does not give way.
    """
    at = np.zeros(len(readings), dtype=np.bool_)
    steps = np.flatnonzero(np.diff(readings.opening) < 0)
    if len(steps):
        at[int(steps[0]) + 1 : int(steps[-1]) + 2] = True
    if len(steps) or stuck:
        at |= readings.effort > locked
    at[np.flatnonzero(at)[:SETTLING]] = False
    return at


def _gave_by(series: Sequence[GripperReadings]) -> float:
    """Return how far the opening changed in all of some readings [m]."""
    openings = np.concatenate([np.zeros(0), *(readings.opening for readings in series)])
    return float(np.ptp(openings)) if len(openings) else 0.0


def _speed(time: Array, opening: Array) -> Array:
    """Return the closing speed [m/s], (N,)."""
    if len(time) < 3 or np.any(np.diff(time) <= 0):
        return np.zeros(len(time))
    speed: Array = -np.gradient(opening, time)
    return speed


def between_steps(readings: GripperReadings) -> Array:
    """Return the opening interpolated between the steps of its reading [m], (N,).

    Half way in time between two readings of different openings, the opening was about half way between them: where
    the pads move evenly this resolves a fraction of a step.
    """
    steps = np.flatnonzero(np.diff(readings.opening) != 0)
    if len(steps) < 2:
        return readings.opening
    time = (readings.time[steps] + readings.time[steps + 1]) / 2
    middle = (readings.opening[steps] + readings.opening[steps + 1]) / 2
    smooth: Array = np.interp(readings.time, time, middle)
    for end, near in ((readings.time < time[0], slice(0, 3)), (readings.time > time[-1], slice(-3, None))):
        t, x = time[near], middle[near]  # a line through the nearest steps carries on to the ends
        slope = (x[-1] - x[0]) / (t[-1] - t[0])
        at = x[0] + slope * (readings.time - t[0])
        half = np.max(np.abs(np.diff(readings.opening))) / 2
        smooth = np.where(end, np.clip(at, readings.opening - half, readings.opening + half), smooth)
    return smooth


def _readings(phases: Sequence[Phase], *names: str) -> list[GripperReadings]:
    """Return the gripper's readings in the phases of some names."""
    return [phase.gripper() for phase in phases if phase.name in names]


def _quantum(gripper: ParallelGripper, phases: Sequence[Phase]) -> float:
    """Return the steps in which the opening is reported [m]; 0 if it is not."""
    return gripper.opening_quantum if quantum_of(opening_grid(phases)) > 0 else 0.0


def opening_grid(phases: Sequence[Phase]) -> Array:
    """Return every opening that was reported [m], (N,)."""
    return np.array([sample.opening for phase in phases for sample in phase.samples])


def _force_sd(force: Array, gripper: ParallelGripper) -> Array:
    """Return the noise of force readings, up to a common scale [N], (N,)."""
    flat = math.hypot(CURRENT_SD, gripper.effort_quantum / math.sqrt(12.0)) * gripper.force_per_ampere
    return np.hypot(flat, CURRENT_RELATIVE_SD * force)


def _resolution(quantum: float) -> float:
    return max(quantum / math.sqrt(12.0), 1e-6)


def _gain_sd(
    gripper: ParallelGripper,
    shape: Shape,
    size: tuple[float, float, float],
    size_sd: tuple[float, float, float],
    whole_pad: bool,
) -> float:
    """Return the relative standard deviation that calibration and sizes put on every modulus."""
    relative = [sd / extent for sd, extent in zip(size_sd, size, strict=True)]
    if any(not (math.isfinite(r) and r >= 0) for r in relative):
        raise InvalidInput("squeeze: size_sd [m]", size_sd, "three finite numbers >= 0")
    # A modulus is F L / A: the area of a whole pad is known, that of a face is the product of its sides.
    sizes = relative[:1] if whole_pad else relative
    return math.hypot(gripper.force_per_ampere_sd / gripper.force_per_ampere, *sizes)
