"""Logs of an arm that moves all the time: the payload from its drives, calibrated by a log without a payload."""

from __future__ import annotations

from collections.abc import Sequence

from dynamics.arm import Arm
from dynamics.errors import InvalidInput
from estimation.recording import Recording, Samples
from estimation.reestimation.again import Redone
from estimation.reestimation.episodes import find_holds, find_squeezes

LEAST_HOLDS = 2  # stands from which a log is weighed by them and not by its motion


def is_motion(recording: Recording) -> bool:
    """Tell whether a log can only be weighed by its motion: no marks, no stands, no squeezes."""
    if recording.marks:
        return False
    if recording.drive_effort == "current":
        return True
    return not _stands(recording.samples) and not find_squeezes(recording.samples)


def _stands(samples: Samples) -> bool:
    try:
        return len(find_holds(samples)) >= LEAST_HOLDS
    except InvalidInput:
        return False


def weigh_motion(arm: Arm, recording: Recording, tares: Sequence[Recording], drives: str = "") -> Redone:
    """Estimate the payload of a motion.

    Args:
        arm: the arm.
        recording: with the payload.
        tares: without one, to calibrate the drives by; not needed with ``drives``.
        drives: file of a calibration (``python -m estimation.calibrate``).

    Raises:
        InvalidInput: if there is neither.
    """
    from estimation.payload.drives import Drives
    from estimation.payload.drives_fit import calibrate_drives
    from estimation.payload.motion import estimate_payload_motion
    from estimation.payload.motion_rows import JointLog, motion_rows

    log = JointLog.of(recording)
    if drives:
        calibrated = Drives.from_file(drives)
    elif tares:
        calibrated = calibrate_drives(arm, [motion_rows(arm, JointLog.of(tare)) for tare in tares])
    else:
        found = f"an arm that moves, with a {log.effort_kind} of its joints and no calibration"
        raise InvalidInput(f"{recording.source}", found, "options --drives FILE, or --tare LOG without a payload")
    payload = estimate_payload_motion(motion_rows(arm, log), calibrated)
    low, high = payload.mass_interval
    notes = (payload.verdict, f"95 % interval of the mass: {low:.4g} to {high:.4g} kg")
    return Redone("weigh", (payload.measurement(),), (), notes)
