"""What joint readings must satisfy before a payload is estimated from them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from dynamics.arm import Arm
from dynamics.errors import InvalidInput
from estimation.payload.graph import Design
from estimation.payload.holds import StaticReadings

Array = NDArray[np.float64]

LIMIT_MARGIN = 0.3  # rad beyond a joint's limit that calibration and rounding explain
BIAS_SHARE = 0.05  # of what the joints are built for: more than the bias of any sensor that works
FASTEST = 0.5  # rad/s up to which a reading counts as one of an arm at rest
TURNS = 4 * np.pi  # rad beyond which a joint without limits is more likely in degrees


def check_readings(arm: Arm, readings: StaticReadings, name: str) -> None:
    """Refuse readings that cannot be this arm's.

    Raises:
        InvalidInput: for a wrong number of joints, angles out of range, or an arm in motion.
    """
    if not np.linalg.norm(arm.model.gravity.linear) > 0:
        raise InvalidInput(f"{arm.name}: gravity", 0.0, "an arm that knows gravity: without it nothing weighs")
    joints = readings.q.shape[1]
    if joints != arm.nv:
        raise InvalidInput(f"{name}: joints", joints, f"{arm.nv}: {', '.join(arm.joint_names)}")
    low = np.where(np.isfinite(arm.lower), arm.lower - LIMIT_MARGIN, -TURNS)
    high = np.where(np.isfinite(arm.upper), arm.upper + LIMIT_MARGIN, TURNS)
    outside = (readings.q < low) | (readings.q > high)
    if outside.any():
        row, joint = (int(i) for i in np.argwhere(outside)[0])
        raise InvalidInput(
            f"{name}: angle of {arm.joint_names[joint]} in reading {row}",
            f"{readings.q[row, joint]:g} rad",
            f"[{low[joint]:.2f}, {high[joint]:.2f}] rad; degrees given as radians, or joints in another order?",
        )
    if readings.dq is not None and np.abs(readings.dq).max(initial=0.0) > FASTEST:
        speed = f"{np.abs(readings.dq).max():.2f} rad/s"
        raise InvalidInput(f"{name}: speed", speed, f"<= {FASTEST} rad/s; estimate_payload_motion takes motions")


def check_gravity(design: Design, tare: int) -> None:
    """Refuse tares that do not carry the arm's own weight.

    Raises:
        InvalidInput: if torques have the reversed sign, or hardly resemble the arm's gravity.
    """
    measured = design.total[:tare]
    gravity = measured - design.torque[:tare]
    # medians: a bias is there in any case, single outliers may be
    agree = np.median(np.abs(measured - gravity), axis=0).sum()
    oppose = np.median(np.abs(measured + gravity), axis=0).sum()
    weight = np.median(np.abs(gravity), axis=0).sum()
    if weight < BIAS_SHARE * design.scale.sum():
        return  # at such poses a bias may well be larger
    if oppose < 0.5 * agree:
        raise InvalidInput(
            "tare: sign of the torques",
            "opposite to the arm's gravity",
            "torques that the arm exerts on its links; pass torque_sign=-1 for sensors that read the reaction",
        )
    if agree > 0.7 * weight:
        raise InvalidInput(
            "tare: torques",
            f"{agree:.1f} N m away from the arm's gravity, which is {weight:.1f} N m (sums over joints)",
            "the unloaded arm's weight; joints in another order, another arm, or other units?",
        )
