"""From the columns of any log to a recording: units, row checks, time, joint order, torque signs, phases."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from dynamics.arm import Arm
from dynamics.errors import InvalidInput, UnknownName
from estimation.readers.detect import check_angles, find_torque_sign
from estimation.readers.mapping import DECLARED_ONLY, JOINT_SIGNALS, SI, LogMap
from estimation.recording.data import Mark, Recording, Rejections, Samples

Array = NDArray[np.float64]

# What no arm or gripper of this size reports: beyond it a number is damage, not a reading.
LIMITS = {"time": 1e11, "q": 1e4, "dq": 1e3, "tau": 1e4, "current": 1e3, "opening": 10.0, "effort": 1e3}
SHOWN = 5  # reasons kept of the rejected rows


@dataclass
class RawSignals:
    """Signals as a log has them.

    Attributes:
        signals: by the names of ``mapping.SI``, (N,) or, of joints, (N, nv); absent ones are missing.
        units_are_si: whether the reader has converted them already.
        labels: a phase label for every row, or None.
        places: what to call a row in messages: the number of its line or message; row numbers if None.
        place: what these numbers count.
        joint_names: of the columns of the joint signals, if known.
        kortex: whether a Kortex driver wrote the log, whose torques have the raw sign.
        rejections: rows that were unusable already.
        notes: what a reader should know.
    """

    signals: dict[str, Array]
    units_are_si: bool = False
    labels: Sequence[str] | None = None
    places: NDArray[np.int64] | None = None
    place: str = "line"
    joint_names: tuple[str, ...] = ()
    kortex: bool = False
    rejections: Rejections = field(default_factory=Rejections)
    notes: list[str] = field(default_factory=list)


def to_recording(source: Path, raw: RawSignals, mapping: LogMap, arm: Arm | None = None) -> Recording:
    """Return a recording of a log's signals.

    Args:
        source: named in messages.
        raw: the signals.
        mapping: how they are to be understood.
        arm: if given, joints and the sign of torques are checked against it.

    Raises:
        InvalidInput: if a signal that is needed is missing, or all rows are unusable, or units, signs or joints
            can not be right; the option that decides it is named.
    """
    signals = raw.signals if raw.units_are_si else _to_si(raw.signals, mapping)
    for name in ("time", "q"):
        if name not in signals:
            raise InvalidInput(
                f"{source}: {name}", "no such signal", f"a log with {name}, or a column map that names it"
            )
    signals, names = _choose_joints(source, signals, raw, mapping, arm)
    keep, rejections = _check_rows(signals, raw)
    signals = {name: values[keep] for name, values in signals.items()}
    count, nv = signals["q"].shape
    if count == 0:
        first = f" (first: {rejections.reasons[0]})" if rejections.reasons else ""
        raise InvalidInput(f"{source}", f"no usable row{first}", "a log with at least one")
    notes = list(raw.notes)
    check_angles(source, signals, declared="q" in mapping.units or raw.units_are_si)
    currents = signals.pop("current", None)
    if currents is not None:
        signals["tau"] = currents * (-1 if mapping.torque_sign == -1 else 1)
        notes.append("joint torques are not known, but motor currents [A]")
    elif "tau" in signals:
        sign = find_torque_sign(source, signals, arm, mapping.torque_sign, -1 if raw.kortex else 1)
        if sign == -1:
            signals["tau"] = -signals["tau"]
            notes.append("the sign of the torques was reversed: the log holds reactions (torque_sign = -1)")
    has_velocities = "dq" in signals
    if not has_velocities:
        signals["dq"] = _differences(signals["time"], signals["q"])
        notes.append("velocities were derived from positions")
    missing = np.full(count, np.nan)
    samples = Samples(
        signals["time"],
        signals["q"],
        signals["dq"],
        signals.get("tau", np.full((count, nv), np.nan)),
        signals.get("opening", missing),
        signals.get("effort", missing),
    )
    labels = None if raw.labels is None else [raw.labels[row] for row in np.flatnonzero(keep).tolist()]
    return Recording(
        source=source,
        samples=samples,
        marks=() if labels is None else _marks(labels),
        joint_names=names,
        drive_effort="torque" if currents is None else "current",
        has_velocities=has_velocities,
        rejections=rejections,
        notes=tuple(notes),
    )


def pick_columns(
    source: Path, columns: Mapping[str, Array], mapping: LogMap, names: Sequence[str] = ()
) -> dict[str, Array]:
    """Return the signals of a table by the column map; a stem takes its numbered columns.

    Args:
        source: named in messages.
        columns: those that may be wanted.
        mapping: which is what.
        names: of all columns there are, for messages.

    Raises:
        UnknownName: if the map names a column that is not there.
    """
    signals = {}
    for signal in SI:
        if signal in DECLARED_ONLY and signal not in mapping.columns:
            continue
        if signal == "tau" and "current" in mapping.columns:
            continue
        wanted = mapping.column(signal)
        if isinstance(wanted, str) and wanted in columns:
            values = columns[wanted]
            signals[signal] = values[:, None] if signal in JOINT_SIGNALS and values.ndim == 1 else values
            continue
        listed = list(wanted) if isinstance(wanted, tuple) else _numbered(wanted, columns)
        if signal in JOINT_SIGNALS and listed and all(name in columns for name in listed):
            signals[signal] = np.column_stack([columns[name] for name in listed])
        elif signal in mapping.columns:
            lost = [name for name in listed if name not in columns] or [str(wanted)]
            raise UnknownName(f"{source}: column of {signal}", lost[0], list(names or columns)[:40])
    return signals


def _numbered(stem: str, columns: Mapping[str, Array]) -> list[str]:
    for pattern in ("{}{}", "{}_{}", "{}[{}]", "{}.{}"):
        for first in (1, 0):
            names: list[str] = []
            while (name := pattern.format(stem, first + len(names))) in columns:
                names.append(name)
            if names:
                return names
    return []


def _to_si(signals: Mapping[str, Array], mapping: LogMap) -> dict[str, Array]:
    converted = {}
    for name, values in signals.items():
        factor, offset = mapping.scale(name)
        with np.errstate(over="ignore", invalid="ignore"):
            converted[name] = values if (factor, offset) == (1.0, 0.0) else values * factor + offset
    return converted


def _choose_joints(
    source: Path, signals: dict[str, Array], raw: RawSignals, mapping: LogMap, arm: Arm | None
) -> tuple[dict[str, Array], tuple[str, ...]]:
    """Take the joints in the arm's order: as told, or by name, or as they stand."""
    names = raw.joint_names
    shapes = {name: np.shape(signals[name]) for name in JOINT_SIGNALS if name in signals}
    if len(set(shapes.values())) != 1 or len(shapes["q"]) != 2:
        raise InvalidInput(f"{source}: joints", f"shapes {shapes}", "one column a joint, as many for each signal")
    count = shapes["q"][1]
    if not names and len(mapping.joints) == count:
        names = mapping.joints  # the map tells what the columns are
    wanted = mapping.joints
    if not wanted and arm is not None and set(arm.joint_names) <= set(names):
        wanted = arm.joint_names
    for name in wanted:
        if name not in names:
            raise UnknownName(f"{source}: joint", name, names)
    if wanted:
        order = [names.index(name) for name in wanted]
        signals = {n: values[:, order] if n in JOINT_SIGNALS else values for n, values in signals.items()}
        names, count = tuple(wanted), len(wanted)
    if arm is not None and count != arm.nv:
        raise InvalidInput(
            f"{source}: joints",
            f"{count}: {', '.join(names) or 'unnamed'}",
            f"{arm.nv} of {arm.name}; option joints",
        )
    return signals, names


def _check_rows(signals: Mapping[str, Array], raw: RawSignals) -> tuple[NDArray[np.bool_], Rejections]:
    """Find the rows to keep: numbers finite and possible, time in order."""
    count = len(signals["time"])
    reasons: dict[int, str] = {}
    keep = np.ones(count, bool)
    for name, values in signals.items():
        with np.errstate(invalid="ignore"):
            good = np.abs(values) <= LIMITS[name]
        bad = ~good if good.ndim == 1 else ~good.all(axis=1)
        for row in np.flatnonzero(bad & keep)[:SHOWN]:
            found = values[row] if values.ndim == 1 else values[row][~good[row]][0]
            reasons[int(row)] = f"{name} is {found:g}"
        keep &= ~bad
    times = signals["time"]
    late = _out_of_order(times, keep)
    for row in np.flatnonzero(late)[:SHOWN]:
        reasons[int(row)] = f"time {times[row]:.6g} is out of order"
    keep &= ~late
    rows = sorted(reasons)[: max(SHOWN - len(raw.rejections.reasons), 0)]
    told = tuple(f"{_place(raw, row)}: {reasons[row]}" for row in rows)
    rejected = int(count - np.count_nonzero(keep))
    return keep, Rejections(raw.rejections.count + rejected, (*raw.rejections.reasons, *told))


def _place(raw: RawSignals, row: int) -> str:
    return f"row {row + 1}" if raw.places is None else f"{raw.place} {raw.places[row]}"


def _out_of_order(times: Array, keep: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Find rows whose time does not fit: a lone jump ahead is at fault itself, not the rows behind it."""
    late = np.zeros(len(times), bool)
    rows = np.flatnonzero(keep)
    for _ in range(3):
        if len(rows) < 3:
            break
        t = times[rows]
        ahead = np.zeros(len(t), bool)
        ahead[1:-1] = (t[1:-1] > t[2:]) & (t[2:] >= t[:-2])
        ahead[0] = t[0] > t[1] and t[1] <= t[2]
        if not ahead.any():
            break
        late[rows[ahead]] = True
        rows = rows[~ahead]
    if len(rows):
        behind = times[rows] < np.maximum.accumulate(times[rows])
        late[rows[behind]] = True
    return late


def _differences(time: Array, q: Array) -> Array:
    """Return velocities by central differences; zero where there is only one instant."""
    steps = np.concatenate([[True], np.diff(time) > 0])
    if np.count_nonzero(steps) < 2:
        return np.zeros_like(q)
    distinct = np.gradient(q[steps], time[steps], axis=0)
    velocity: Array = distinct[np.cumsum(steps) - 1]
    return velocity


def _marks(labels: Sequence[str]) -> tuple[Mark, ...]:
    """Return the stretches of equal labels: ``name``, ``action/name`` or ``action/name/index``; empty for none."""
    marks: list[Mark] = []
    counts: dict[tuple[str, str], int] = {}
    start = 0
    for row in range(1, len(labels) + 1):
        if row < len(labels) and labels[row] == labels[start]:
            continue
        parts = labels[start].strip().split("/")
        if parts[-1]:
            action, name = (parts[0], parts[1]) if len(parts) > 1 else ("", parts[0])
            index = counts.get((action, name), 0)
            if len(parts) > 2 and parts[2].isdecimal():
                index = int(parts[2][:9])
            counts[action, name] = index + 1
            marks.append(Mark(action, name, index, start, row))
        start = row
    return tuple(marks)
