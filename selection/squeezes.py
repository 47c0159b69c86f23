"""Squeezes on a bench: done one after another, recorded as they happen, and measured as an exploration would."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dynamics.bench import SqueezeBench, Stroke
from dynamics.compression import StressStrain, stress_strain
from dynamics.errors import InvalidInput
from dynamics.objects import DeclaredObject
from dynamics.signals import Phase
from estimation.measurement import Measurement
from estimation.recording import RunWriter
from estimation.size import SizeEstimate
from estimation.squeezing import air_current, measure_squeeze
from estimation.stiffness import StiffnessEstimate
from estimation.stiffness.cycle import Hysteresis, RateDependence, hysteresis, rate_dependence

Array = NDArray[np.float64]

ACTION = "squeeze"
CONTACT_AIR = 0.1  # of the strain that was reached
SAME_RATE = 1.2  # factor by which two strain rates must differ for a dependence to be asked for


@dataclass(frozen=True)
class Modulus:
    """One of the moduli of a curve.

    Attributes:
        name: such as ``tangent at 5.0 %``.
        value, sd: [Pa]; the sd is NaN where it has none.
    """

    name: str
    value: float
    sd: float


@dataclass(frozen=True)
class Squeezed:
    """One squeeze and what it told.

    Attributes:
        stroke: how it was done.
        time, opening, force: what was read, the current's value in air taken off [s, m, N], (N,).
        estimate: of the stiffness; None if there is none.
        curve: stress over strain of all of it; None without an estimate.
        moduli: of its loading.
        hysteresis: between loading and unloading; None where it cannot be told.
        rate: strain rate while it was compressed [1/s]; NaN without an estimate.
        measurements: what a belief would take from it.
        note: why there is no estimate, or what kind of one there is; empty for a modulus.
    """

    stroke: Stroke
    time: Array
    opening: Array
    force: Array
    estimate: StiffnessEstimate | None
    curve: StressStrain | None
    moduli: tuple[Modulus, ...]
    hysteresis: Hysteresis | None
    rate: float
    measurements: tuple[Measurement, ...]
    note: str


def squeeze_all(
    bench: SqueezeBench, declared: DeclaredObject, strokes: Sequence[Stroke], run: RunWriter | None = None
) -> Iterator[Squeezed]:
    """Do strokes and yield what each told.

    What one squeeze tells of the object's width is known in the next.

    Args:
        bench: squeezes.
        declared: what is known of the object.
        strokes: to be done.
        run: keeps everything.
    """
    size = SizeEstimate.declared(declared)
    for stroke in strokes:
        phases = bench.squeeze(stroke)
        if run is not None:
            record(run, stroke, phases)
        found = _measured(bench, declared, size, stroke, phases)
        for measurement in found.measurements:
            if run is not None:
                run.measurement(phases[-1].samples[-1].time, ACTION, measurement)
            if measurement.property == "width":
                size = size.with_edge(bench.edge, measurement)
        yield found


def record(run: RunWriter, stroke: Stroke, phases: Sequence[Phase]) -> None:
    """Keep a squeeze in a run, as the exploration would: a decision, then samples in marked phases."""
    decision = {"target": "elasticity", "price": 0.0, "actions": {}, "choice": ACTION, "stop": None}
    run.decision(phases[0].samples[0].time, {**decision, "stroke": stroke_table(stroke)})
    for phase in phases:
        run.phase(phase.action, phase.name, phase.index, phase.samples[0].time)
        for sample in phase.samples:
            run.sample(sample)
        run.end_phase(phase.samples[-1].time)


def stroke_table(stroke: Stroke) -> dict[str, float]:
    """Return a stroke as it stands in recordings; what does not apply is left out."""
    table = {"speed_m_s": stroke.speed, "target_m": stroke.target, "dwell_s": stroke.dwell}
    if stroke.stiffness is not None:
        table["drive_n_m"] = stroke.stiffness
    if math.isfinite(stroke.max_force):
        table["max_force_n"] = stroke.max_force
    return table


def rate_term(squeezes: Sequence[Squeezed]) -> RateDependence | None:
    """Return how the modulus depends on the strain rate, or None if the squeezes were all about as fast."""
    known = [s for s in squeezes if s.estimate is not None and s.estimate.bound is None]
    rates = [s.rate for s in known]
    if len(known) < 2 or max(rates) < SAME_RATE * min(rates):
        return None
    return rate_dependence([s.estimate for s in known if s.estimate is not None], rates)


def moduli_of(estimate: StiffnessEstimate) -> tuple[Modulus, ...]:
    """Return the moduli of an estimate over the strains that were reached."""
    end = estimate.max_strain
    if estimate.bound is not None or not end > 0:
        return ()
    low, middle, high = 0.2 * end, 0.5 * end, 0.8 * end
    return (
        Modulus("Young's modulus", estimate.young_modulus, estimate.sd),
        Modulus(f"tangent at {_percent(middle)}", estimate.tangent(middle), estimate.tangent_sd(middle)),
        Modulus(
            f"chord {_percent(low)} to {_percent(high)}", estimate.chord(low, high), estimate.chord_sd(low, high)
        ),
        Modulus(f"secant to {_percent(end)}", estimate.secant(end), estimate.chord_sd(0.0, end)),
        Modulus("largest slope", estimate.max_slope, math.nan),
    )


def _measured(
    bench: SqueezeBench, declared: DeclaredObject, size: SizeEstimate, stroke: Stroke, phases: Sequence[Phase]
) -> Squeezed:
    gripper, edge = bench.gripper, bench.edge
    air, _ = air_current([phase.gripper() for phase in phases if phase.name == "air"], gripper)
    readings = [phase.gripper() for phase in phases]
    time, opening, effort = (
        np.concatenate([getattr(r, name) for r in readings]) for name in ("time", "opening", "effort")
    )
    force = gripper.force_per_ampere * (effort - air)
    lengths, sds = ((v[edge], v[1 - edge], v[2]) for v in (size.mean, size.sd))
    try:
        estimate, measurements = measure_squeeze(
            gripper, declared.shape, lengths, phases, size_sd=sds, fill=size.fill
        )
    except InvalidInput as error:
        nothing = (None, None, (), None, math.nan, (), str(error))
        return Squeezed(stroke, time, opening, force, *nothing)
    curve = stress_strain(force, opening, estimate.geometry)
    note = "" if estimate.bound is None else f"stiffer than can be told: at least {estimate.bound:.3g} Pa"
    rate = _strain_rate(phases, estimate)
    cycle = _cycle(curve, [phase.name for phase in phases for _ in phase.samples], estimate)
    return Squeezed(
        stroke, time, opening, force, estimate, curve, moduli_of(estimate), cycle, rate, measurements, note
    )


def _cycle(curve: StressStrain, names: Sequence[str], estimate: StiffnessEstimate) -> Hysteresis | None:
    """Return the hysteresis over the strains in contact and a little air, without the dwell."""
    onset = 1 - estimate.onset / estimate.geometry.width
    near = curve.strain > onset - CONTACT_AIR * estimate.max_strain
    near &= np.array(names) != "dwell"
    loading = int(np.sum(near & (np.array(names) != "release")))
    try:
        return hysteresis(StressStrain(curve.strain[near], curve.stress[near], curve.geometry), loading)
    except InvalidInput:  # no way back, or too few readings of it
        return None


def _strain_rate(phases: Sequence[Phase], estimate: StiffnessEstimate) -> float:
    """Return the strain rate between a tenth and nine tenths of the compression [1/s]."""
    loading = next(phase.gripper() for phase in phases if phase.name == "compress")
    compression = estimate.onset - loading.opening
    most = float(np.max(compression))
    low, high = (int(np.argmax(compression >= share * most)) for share in (0.1, 0.9))
    if not (most > 0 and high > low):
        return math.nan
    way = compression[high] - compression[low]
    return float(way / (loading.time[high] - loading.time[low]) / estimate.geometry.width)


def _percent(strain: float) -> str:
    return f"{100 * strain:.1f} %"
