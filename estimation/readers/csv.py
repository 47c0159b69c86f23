"""Joint logs as CSV: a TOML file says which column is what; corrupt lines are rejected by number.

The column map (numbers count from 0; names refer to a header line)::

    delimiter = ","
    time = 0                         # s
    q = [1, 2, 3]                    # joint positions
    dq = [4, 5, 6]                   # velocities, optional
    torque = [7, 8, 9]               # or: current = [...]
    angle_unit = "rad"               # or "deg", for q and dq
    torque_sign = 1                  # -1 for sensors that read the reaction
"""

from __future__ import annotations

import logging
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from dynamics.errors import InvalidInput

Array = NDArray[np.float64]
Column = int | str

LARGEST = 1e6  # beyond which no time [s], angle [rad], speed, torque or current of a robot lies
AHEAD = 3  # lines that decide whether a leap of the clock is a leap or a corrupt number

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class ColumnMap:
    """Which column of a log is what.

    Attributes:
        time: column of the time [s].
        q, effort: columns of joint positions, and of torques or motor currents, one a joint.
        effort_kind: ``torque`` [N m] or ``current`` [A].
        dq: columns of velocities, or None.
        delimiter: between the columns.
        angle_unit: of q and dq.
        torque_sign: 1, or -1 for sensors that read the reaction.
    """

    time: Column
    q: tuple[Column, ...]
    effort: tuple[Column, ...]
    effort_kind: Literal["torque", "current"]
    dq: tuple[Column, ...] | None = None
    delimiter: str = ","
    angle_unit: Literal["rad", "deg"] = "rad"
    torque_sign: int = 1

    @classmethod
    def from_file(cls, path: str | Path) -> ColumnMap:
        """Read a column map.

        Raises:
            InvalidInput: if the file is not a column map; the message names what is wrong.
        """
        try:
            table = tomllib.loads(Path(path).read_text())
        except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
            raise InvalidInput(f"column map {path}", str(error), "a readable TOML file") from None
        return cls.from_table(table, str(path))

    @classmethod
    def from_table(cls, table: dict[str, Any], where: str = "column map") -> ColumnMap:
        """Build a column map of a parsed table."""
        known = {"time", "q", "dq", "torque", "current", "delimiter", "angle_unit", "torque_sign"}
        for name in table.keys() - known:
            raise InvalidInput(where, f"unknown entry {name}", ", ".join(sorted(known)))
        kinds = [kind for kind in ("torque", "current") if kind in table]
        if len(kinds) != 1:
            raise InvalidInput(where, f"entries {kinds}", "exactly one of torque, current")
        effort = _columns(table, kinds[0], where)
        q = _columns(table, "q", where)
        dq = _columns(table, "dq", where) if "dq" in table else None
        for name, columns in ((kinds[0], effort), ("dq", dq)):
            if columns is not None and len(columns) != len(q):
                raise InvalidInput(f"{where}: {name}", f"{len(columns)} columns", f"{len(q)}, as for q")
        unit, sign = table.get("angle_unit", "rad"), table.get("torque_sign", 1)
        if unit not in ("rad", "deg"):
            raise InvalidInput(f"{where}: angle_unit", unit, "rad, deg")
        if sign not in (-1, 1):
            raise InvalidInput(f"{where}: torque_sign", sign, "1 or -1")
        delimiter = table.get("delimiter", ",")
        if not (isinstance(delimiter, str) and len(delimiter) == 1):
            raise InvalidInput(f"{where}: delimiter", delimiter, "one character")
        time = _columns({"time": [table.get("time")]}, "time", where)[0]
        return cls(time, q, effort, "torque" if kinds[0] == "torque" else "current", dq, delimiter, unit, sign)


@dataclass(frozen=True)
class JointLog:
    """A recorded run.

    Attributes:
        time: [s], increasing, (N,).
        q: joint positions [rad], (N, nv).
        effort: torque [N m] or motor current [A], (N, nv).
        effort_kind: which of the two.
        dq: velocities where recorded [rad/s], (N, nv).
        rejected: numbers of the lines that were corrupt, from 1, with the reason.
    """

    time: Array
    q: Array
    effort: Array
    effort_kind: Literal["torque", "current"]
    dq: Array | None = None
    rejected: tuple[tuple[int, str], ...] = ()

    def __len__(self) -> int:
        return len(self.time)


def read_csv(path: str | Path, columns: ColumnMap) -> JointLog:
    """Read a joint log; lines that are corrupt are left out and listed.

    Raises:
        InvalidInput: if the file cannot be read, lacks a column, or hardly a line of it is good.
    """
    try:
        lines = Path(path).read_text(errors="replace").splitlines()
    except OSError as error:
        raise InvalidInput(f"log {path}", str(error), "a readable file") from None
    named = [c for c in _flat(columns) if isinstance(c, str)]
    header = [cell.strip() for cell in lines[0].split(columns.delimiter)] if named and lines else []
    for name in named:
        if name not in header:
            raise InvalidInput(f"log {path}: columns", name, ", ".join(header) or "a header line")
    index = [header.index(c) if isinstance(c, str) else c for c in _flat(columns)]
    rows, numbers, rejected = _parse(lines, 1 if header else 0, columns.delimiter, index)
    rows, numbers, late = _in_order(rows, numbers)
    rejected = sorted(rejected + late)
    if len(rows) < 2 or len(rows) < len(rejected):
        raise InvalidInput(f"log {path}", f"{len(rows)} good lines, {len(rejected)} corrupt", "a log of that form")
    if rejected:
        some = ", ".join(str(n) for n, _ in rejected[:10]) + (", ..." if len(rejected) > 10 else "")
        log.warning("%s: %d corrupt lines left out: %s", path, len(rejected), some)
    joints = len(columns.q)
    angle = np.pi / 180 if columns.angle_unit == "deg" else 1.0
    effort = rows[:, 1 + joints : 1 + 2 * joints] * columns.torque_sign
    dq = rows[:, 1 + 2 * joints :] * angle if columns.dq is not None else None
    return JointLog(rows[:, 0], rows[:, 1 : 1 + joints] * angle, effort, columns.effort_kind, dq, tuple(rejected))


def _parse(
    lines: list[str], start: int, delimiter: str, index: list[int]
) -> tuple[Array, list[int], list[tuple[int, str]]]:
    """Return the wanted numbers of the good lines, those lines' numbers, and the rejected ones."""
    counts = [line.count(delimiter) + 1 for line in lines[start:] if line.strip()]
    width = int(np.median(counts)) if counts else 0
    if max(index) >= width:
        raise InvalidInput("log: columns", f"{width} columns", f"at least {max(index) + 1}, which the map names")
    rows, numbers, rejected = [], [], []
    for number, line in enumerate(lines[start:], start + 1):
        cells = line.split(delimiter)
        if not line.strip():
            continue
        if len(cells) != width:
            rejected.append((number, f"{len(cells)} columns instead of {width}"))
            continue
        try:
            values = [float(cells[i]) for i in index]
        except ValueError:
            rejected.append((number, "not a number"))
            continue
        if not np.all(np.isfinite(values)) or max(values[1:], key=abs) > LARGEST or min(values[1:]) < -LARGEST:
            rejected.append((number, "a number out of all range"))
            continue
        rows.append(values)
        numbers.append(number)
    return np.array(rows, float).reshape(len(rows), len(index)), numbers, rejected


def _in_order(rows: Array, numbers: list[int]) -> tuple[Array, list[int], list[tuple[int, str]]]:
    """Leave out the lines whose time is behind the last good one, or ahead of those that follow."""
    keep, rejected, last = [], [], -np.inf
    for i, time in enumerate(rows[:, 0] if len(rows) else []):
        following = rows[i + 1 : i + 1 + AHEAD, 0]
        if time <= last or (len(following) and time > np.median(following)):
            rejected.append((numbers[i], "time out of order"))
        else:
            keep.append(i)
            last = time
    return rows[keep], [numbers[i] for i in keep], rejected


def _flat(columns: ColumnMap) -> list[Column]:
    return [columns.time, *columns.q, *columns.effort, *(columns.dq or ())]


def _columns(table: dict[str, Any], name: str, where: str) -> tuple[Column, ...]:
    values: Any = table.get(name)
    if not isinstance(values, Iterable) or isinstance(values, str):
        raise InvalidInput(f"{where}: {name}", values, "a list of columns")
    listed = tuple(values)
    for value in listed:
        if isinstance(value, bool) or not isinstance(value, int | str) or (isinstance(value, int) and value < 0):
            raise InvalidInput(f"{where}: {name}", value, "column numbers from 0, or names of the header")
    if not listed:
        raise InvalidInput(f"{where}: {name}", "no column", "at least one")
    return listed
