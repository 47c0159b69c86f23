"""Units and signs that can not be right, found by comparing a log with itself and with gravity."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from dynamics.arm import Arm
from dynamics.errors import InvalidInput

Array = NDArray[np.float64]

STILL = 0.05  # rad/s below which torque is gravity's, up to the sensors' errors
SURE = 0.6  # correlation with gravity from which a sign is believed
_ROWS = 400  # rows compared with gravity at most
_TURNS = 4 * np.pi  # rad; joints that turn further are rare, angles in degrees beyond it are the rule


def check_angles(source: Path, signals: Mapping[str, Array], declared: bool) -> None:
    """Refuse degrees given as radians, unless the unit was declared.

    Two signs of it: angles beyond two turns, and positions that change 180/pi times as fast as the velocities say.

    Raises:
        InvalidInput: naming the option that decides it.
    """
    if declared:
        return
    q = signals["q"]
    farthest = float(np.max(np.abs(q)))
    if farthest > _TURNS:
        raise InvalidInput(
            f"{source}: q", f"angles up to {farthest:.4g}", 'radians; or say [units] q = "deg" or "rad"'
        )
    if "dq" in signals and len(q) > 10:
        ratio = _speed_ratio(signals["time"], q, signals["dq"])
        if ratio is not None and (30 < ratio < 110 or 1 / 110 < ratio < 1 / 30):
            raise InvalidInput(
                f"{source}: q and dq",
                f"positions that change {ratio:.3g} times as fast as the velocities say",
                'one unit of angle; say [units] q and dq = "deg", "rad", "deg/s" or "rad/s"',
            )


def find_torque_sign(
    source: Path,
    signals: Mapping[str, Array],
    arm: Arm | None,
    declared: Literal[1, -1, "auto"] | None,
    default: Literal[1, -1],
) -> Literal[1, -1]:
    """Return 1 if torques are what the arm exerts, -1 if they are its reaction.

    With an arm, torques at rest are compared with its gravity's: a correlation beyond +-SURE tells the sign.

    Raises:
        InvalidInput: if an undeclared sign contradicts the torques, or ``auto`` can not tell.
    """
    if declared in (1, -1):
        return declared
    found = None if arm is None else _sign_by_gravity(signals, arm)
    if declared == "auto":
        if found is None:
            why = "no arm to compare with" if arm is None else "no clear agreement with gravity"
            raise InvalidInput(f"{source}: torque_sign", f'"auto", but {why}', "1 or -1")
        return found
    if found is not None and found != default and arm is not None:
        raise InvalidInput(
            f"{source}: tau",
            f"torques of the sign that {'is opposite to' if found == -1 else 'agrees with'} gravity's",
            f'the other sign, or option torque_sign = {found} (or "auto")',
        )
    return default


def _sign_by_gravity(signals: Mapping[str, Array], arm: Arm) -> Literal[1, -1] | None:
    q, tau = signals["q"], signals["tau"]
    rows = np.arange(len(q))
    if "dq" in signals:
        still = np.flatnonzero(np.all(np.abs(signals["dq"]) < STILL, axis=1))
        rows = still if len(still) > 3 else rows
    rows = rows[:: max(1, len(rows) // _ROWS)]
    gravity = np.array([arm.gravity(q[row]) for row in rows])
    measured = tau[rows]
    size = float(np.linalg.norm(gravity) * np.linalg.norm(measured))
    if size == 0.0 or float(np.max(np.abs(gravity))) < 0.1:
        return None
    correlation = float(np.sum(gravity * measured)) / size
    if abs(correlation) < SURE:
        return None
    return 1 if correlation > 0 else -1


def _speed_ratio(time: Array, q: Array, dq: Array) -> float | None:
    """Return how fast positions change over what the velocities say, or None where nothing moves."""
    step = np.diff(time)
    usable = step > 1e-6
    if np.count_nonzero(usable) < 10:
        return None
    change = np.diff(q, axis=0)[usable]
    said = (0.5 * (dq[1:] + dq[:-1]))[usable] * step[usable, None]
    if float(np.max(np.abs(dq))) < 1e-3 or float(np.sum(said * said)) == 0.0:
        return None
    agreement = float(np.sum(change * said))
    likeness = agreement / (float(np.linalg.norm(change)) * float(np.linalg.norm(said)) + 1e-300)
    return agreement / float(np.sum(said * said)) if likeness > 0.8 else None
