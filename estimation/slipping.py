"""Slip onset as a second way to friction: a held object whose grip is loosened, off a robot's own signals.

What the arm carries is the object's weight as long as the pads hold it. From the onset of slip on it is 2 mu F and
falls with the force F. A gripper that opens does not tell its force, so F comes from the opening, by the force
over opening when it closed on the same object. That was read off a motor that the hanging weight helps to close.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from dynamics.arm import Arm
from dynamics.errors import InvalidInput
from dynamics.gripper import ParallelGripper
from dynamics.signals import JointReadings, Phase
from estimation.carried import pull_of_weight
from estimation.friction import GRAVITY, FrictionEstimate, estimate_friction_at_slip
from estimation.measurement import Measurement
from estimation.squeezing import air_current, closing_readings, opening_grid
from estimation.stiffness.noise import quantum_of

Array = NDArray[np.float64]

HELD_SHARE = 0.15  # of the loosening, its start: the object is still held, and its weight is read
FALLEN = 0.3  # share of the weight, by which the load has fallen when the object slips for sure: it may land next
EXTRAPOLATED = 0.05  # of the least force of the closing, by which the line errs below it
SPEED, SURE = 5, 15  # readings of a running mean of the load, to follow it and to be sure of it


def measure_slip(
    arm: Arm, gripper: ParallelGripper, phases: Sequence[Phase]
) -> tuple[FrictionEstimate, Measurement]:
    """Estimate friction from a grip that is loosened until the object slips.

    Args:
        arm, gripper: their descriptions.
        phases: ``air`` (the gripper closes in air), ``tare`` (the empty arm stands where it will loosen the grip),
            ``compress`` (it closes on the object, in the air) and ``loosen`` (it opens, slowly or by small steps,
            while the arm stands).

    Raises:
        InvalidInput: if phases are missing, the object weighs nothing, or never slips.
    """
    missing = [name for name in ("air", "tare", "compress", "loosen") if not _named(phases, name)]
    if missing:
        raise InvalidInput("slip: phases", sorted({p.name for p in phases}), f"phases named {', '.join(missing)}")
    tare = np.concatenate([_residual(arm, phase.joints()) for phase in _named(phases, "tare")]).mean(axis=0)
    loosening = _named(phases, "loosen")
    joints = [phase.joints() for phase in loosening]
    load = np.concatenate([_load(arm, one, tare) for one in joints])
    time = np.concatenate([np.array([s.time for s in phase.samples]) for phase in loosening])
    opening = np.concatenate([phase.gripper().opening for phase in loosening])
    held = max(round(HELD_SHARE * len(load)), 3)
    if len(load) <= 2 * held:
        raise InvalidInput("slip: loosen", f"{len(load)} readings", "10 or more")
    weight = float(load[:held].mean())
    if not weight > 0:
        raise InvalidInput("slip: weight of the object [N]", round(weight, 3), "a number > 0")
    weight_sd = max(float(load[:held].std()) / np.sqrt(held), arm.torque_gain_sd * weight)
    force, force_sd = _force_at(gripper, phases, opening, weight)
    smooth = np.convolve(load, np.ones(SPEED) / SPEED, "valid")
    smooth = smooth[: _slipped(load, weight)]
    middle = slice(SPEED // 2, SPEED // 2 + len(smooth))
    found = estimate_friction_at_slip(
        time[middle],
        weight - smooth,
        force[middle],
        weight / GRAVITY,
        mass_sd=weight_sd / GRAVITY,
        force_sd=force_sd,
    )
    return found, found.measurement()


def _slipped(load: Array, weight: float) -> int:
    """Return how many readings there are until the object has slipped."""
    sure = np.convolve(load, np.ones(SURE) / SURE, "valid")
    gone = np.flatnonzero(sure < (1 - FALLEN) * weight)
    return int(gone[0]) + SURE if len(gone) else len(load)


def _force_at(
    gripper: ParallelGripper, phases: Sequence[Phase], opening: Array, weight: float
) -> tuple[Array, float]:
    """Return the force at openings by a line through that of the closing, and the sd of its calibration [N]."""
    air, _ = air_current([phase.gripper() for phase in _named(phases, "air")], gripper)
    closing = [phase.gripper() for phase in _named(phases, "compress")]
    at, effort, _ = closing_readings(closing, quantum_of(opening_grid(phases)))
    pressed = gripper.force_per_ampere * (effort - air) + gripper.friction_force
    pressed = pressed + pull_of_weight(gripper, weight, at)
    slope, level = np.polyfit(at, pressed, 1)
    if not slope < 0:
        raise InvalidInput("slip: compress", f"{slope:.3g} N/m", "a force that rises as the gripper closes")
    force = np.maximum(slope * opening + level, 0.0)
    scatter = float(np.std(pressed - slope * at - level)) / math.sqrt(len(at))
    step = -slope * quantum_of(opening_grid(phases)) / math.sqrt(12.0)
    calibration = float(gripper.force_sd(np.array([float(np.median(force))]))[0])
    return force, math.hypot(calibration, scatter, step, EXTRAPOLATED * max(float(pressed.min()), 0.0))


def _load(arm: Arm, readings: JointReadings, tare: Array) -> Array:
    """Return what the arm carries, by gravity's direction on all joints [N], (N,)."""
    residual = _residual(arm, readings) - tare
    load = np.empty(len(readings))
    for k, q in enumerate(readings.q):
        up = arm.tool_pose(q)[:3, :3].T @ np.array([0.0, 0.0, 1.0])
        lever = arm.tool_jacobian(q)[:3].T @ up
        load[k] = lever @ residual[k] / (lever @ lever)
    return load


def _residual(arm: Arm, readings: JointReadings) -> Array:
    return np.array([tau - arm.gravity(q) for q, tau in zip(readings.q, readings.tau, strict=True)])


def _named(phases: Sequence[Phase], name: str) -> list[Phase]:
    return [phase for phase in phases if phase.name == name and phase.samples]
