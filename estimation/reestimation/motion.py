"""Logs of an arm that moves all the time: the payload from its drives, calibrated by a log without a payload."""

from __future__ import annotations

import tomllib
from pathlib import Path

from dynamics.arm import Arm
from dynamics.errors import InvalidInput
from estimation.readers import LogMap
from estimation.readers.csv import ColumnMap, JointLog, read_csv
from estimation.recording import Recording, Rejections
from estimation.reestimation.again import Redone

LEAST_HOLDS = 2  # stands from which a log is weighed by them and not by its motion
SHOWN = 5  # reasons told of the rejected lines


def read_map(path: str) -> LogMap | ColumnMap:
    """Return the column map of a file, of either form: in tables, or flat with numbers of columns.

    Raises:
        InvalidInput: if it is neither.
    """
    try:
        table = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise InvalidInput(f"column map {path}", str(error), "a TOML file") from None
    if table and not {"columns", "units", "options"} & set(table):
        return ColumnMap.from_table(table, f"column map {path}")
    return LogMap.from_tables(table, f"column map {path}")


def read_motion(path: Path, columns: ColumnMap) -> tuple[JointLog, Rejections]:
    """Read a log by a flat map; return it, and what was rejected."""
    log = read_csv(path, columns)
    told = tuple(f"line {number}: {why}" for number, why in log.rejected[:SHOWN])
    return log, Rejections(len(log.rejected), told)


def as_joint_log(recording: Recording) -> JointLog:
    """Return a recording's joint signals; its torques are torques."""
    s = recording.samples
    return JointLog(s.time, s.q, s.tau, "torque", s.dq)


def weigh_motion(arm: Arm, log: JointLog, tares: list[JointLog], drives: str = "") -> Redone:
    """Estimate the payload of a motion.

    Args:
        arm: the arm.
        log: with the payload.
        tares: without one, to calibrate the drives by; not needed with ``drives``.
        drives: file of a calibration (``python -m estimation.calibrate``).

    Raises:
        InvalidInput: if there is neither.
    """
    from estimation.payload.drives import Drives
    from estimation.payload.drives_fit import calibrate_drives
    from estimation.payload.motion import estimate_payload_motion
    from estimation.payload.motion_rows import motion_rows

    if drives:
        calibrated = Drives.from_file(drives)
    elif tares:
        calibrated = calibrate_drives(arm, [motion_rows(arm, tare) for tare in tares])
    else:
        found = f"an arm that moves, {log.effort_kind} and no calibration"
        raise InvalidInput("log", found, "options --drives FILE, or --tare LOG without a payload")
    payload = estimate_payload_motion(motion_rows(arm, log), calibrated)
    low, high = payload.mass_interval
    notes = (payload.verdict, f"95 % interval of the mass: {low:.4g} to {high:.4g} kg")
    return Redone("weigh", (payload.measurement(),), (), notes)
