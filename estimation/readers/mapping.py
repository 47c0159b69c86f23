"""What the columns of a log mean: names, units, the sign of torques and the order of joints, from a TOML file.

[columns]                 # a name, the number of a column from 0, a list of them (one a joint), or a stem: q means
time = "t"                # q1, q2 ... or a 2-D array
q = [1, 2, 3]
tau = "torque"            # or current: of a drive that reports no torque
[units]                   # SI where nothing is said
q = "deg"
opening = "mm"
[options]
torque_sign = -1          # raw sign of Kortex arms; "auto" compares with gravity
joints = ["joint_1", "joint_2", "joint_3"]
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

from dynamics.errors import InvalidInput, UnknownName
from estimation.units import conversion

Column = str | int
SI = {"time": "s", "q": "rad", "dq": "rad/s", "tau": "N m", "current": "A", "opening": "m", "effort": "A"}
JOINT_SIGNALS = ("q", "dq", "tau", "current")
DECLARED_ONLY = ("current",)  # a column of that name may be anything, such as the gripper's
COLUMNS = (*SI, "phase")
OPTIONS = ("torque_sign", "joints", "delimiter", "topic", "max_opening", "gripper_joint", "gripper_closed")


@dataclass(frozen=True)
class LogMap:
    """How a log is to be understood.

    Attributes:
        columns: for each of ``COLUMNS`` the column, or the columns of its joints, by name or number; a missing one
            has its own name. ``current`` are motor currents of the joints, in place of ``tau``.
        units: unit of a signal where it is not SI.
        torque_sign: 1 if torque is what the arm exerts, so that at rest it equals gravity's; -1 if it is the
            reaction, as Kortex arms report it; ``auto`` to find out; None for 1, or -1 in logs of Kortex drivers.
        joints: which joints of the log to take, in the arm's order; empty for all, in the log's order.
        delimiter: between the columns of a text; empty to find it.
        topic: the topic of a bag to read; empty to find it.
        max_opening: opening of the gripper at 0 % [m].
        gripper_joint, gripper_closed: joint of the gripper in a bag, and its position when closed [rad].
    """

    columns: Mapping[str, Column | tuple[Column, ...]] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    torque_sign: Literal[1, -1, "auto"] | None = None
    joints: tuple[str, ...] = ()
    delimiter: str = ""
    topic: str = ""
    max_opening: float = 0.085
    gripper_joint: str = ""
    gripper_closed: float | None = None

    @classmethod
    def from_file(cls, path: str | Path) -> LogMap:
        """Read a map.

        Raises:
            InvalidInput: for a file that is no TOML, an unknown key, or a value of the wrong kind.
        """
        try:
            data = tomllib.loads(Path(path).read_text(encoding="utf-8"))
        except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
            raise InvalidInput(f"column map {path}", str(error), "a TOML file") from None
        return cls.from_tables(data, f"column map {path}")

    @classmethod
    def from_tables(cls, data: Mapping[str, Any], where: str) -> LogMap:
        """Return a map from the tables of a TOML file."""
        _known(data, ("columns", "units", "options"), where)
        columns = _known(_table(data, "columns", where), COLUMNS, f"{where}: columns")
        units = _known(_table(data, "units", where), tuple(SI), f"{where}: units")
        options = _known(_table(data, "options", where), OPTIONS, f"{where}: options")
        for name, column in columns.items():
            _check_column(name, column, f"{where}: columns: {name}")
        for name, unit in units.items():
            if not isinstance(unit, str):
                raise InvalidInput(f"{where}: units: {name}", unit, "a unit, as text")
            if unit not in CLOSING_UNITS or name != "opening":
                conversion(unit, SI[name], f"{where}: units: {name}")
        if {"tau", "current"} <= columns.keys():
            raise InvalidInput(f"{where}: columns", "both tau and current", "one of them")
        if "current" in columns and options.get("torque_sign") == "auto":
            raise InvalidInput(f"{where}: options: torque_sign", "auto, for currents", "1 or -1")
        sign = options.get("torque_sign")
        if sign not in (1, -1, "auto", None) or isinstance(sign, bool):
            raise InvalidInput(f"{where}: options: torque_sign", sign, '1, -1 or "auto"')
        joints = options.get("joints", [])
        if not isinstance(joints, list) or not all(isinstance(name, str) for name in joints):
            raise InvalidInput(f"{where}: options: joints", joints, "a list of joint names")
        for name in ("topic", "gripper_joint"):
            if not isinstance(options.get(name, ""), str):
                raise InvalidInput(f"{where}: options: {name}", options[name], "text")
        delimiter = options.get("delimiter", "")
        if not isinstance(delimiter, str) or len(delimiter) > 1:
            raise InvalidInput(f"{where}: options: delimiter", delimiter, "one character")
        closed = options.get("gripper_closed")
        return cls(
            columns={name: tuple(c) if isinstance(c, list) else c for name, c in columns.items()},
            units=dict(units),
            torque_sign=sign,
            joints=tuple(joints),
            delimiter=delimiter,
            topic=options.get("topic", ""),
            max_opening=_positive(options.get("max_opening", 0.085), f"{where}: options: max_opening"),
            gripper_joint=options.get("gripper_joint", ""),
            gripper_closed=None if closed is None else _positive(closed, f"{where}: options: gripper_closed"),
        )

    def column(self, signal: str) -> str | tuple[str, ...]:
        """Return the column, or the columns, of a signal; a number as text."""
        column = self.columns.get(signal, signal)
        return tuple(map(str, column)) if isinstance(column, tuple) else str(column)

    def wants(self, name: str) -> bool:
        """Tell whether a column may be needed: one that is named, or belongs to a stem that is."""
        for signal in SI:
            column = self.column(signal)
            if name in column if isinstance(column, tuple) else name.startswith(column):
                return True
        return False

    def named(self, names: Sequence[str], where: str) -> LogMap:
        """Return the map with the numbers of columns replaced by their names.

        Raises:
            UnknownName: if there is no column of a number.
        """

        def name_of(column: Column) -> str:
            if isinstance(column, str):
                return column
            if column >= len(names):
                raise UnknownName(f"{where}: column", column, (f"0 to {len(names) - 1}",))
            return names[column]

        columns = {
            signal: tuple(map(name_of, column)) if isinstance(column, tuple) else name_of(column)
            for signal, column in self.columns.items()
        }
        return replace(self, columns=columns)

    def scale(self, signal: str) -> tuple[float, float]:
        """Return factor and offset that turn a signal's numbers into SI."""
        unit = self.units.get(signal, SI[signal])
        if signal == "opening" and unit in CLOSING_UNITS:
            return -self.max_opening * CLOSING_UNITS[unit], self.max_opening
        return conversion(unit, SI[signal], f"unit of {signal}"), 0.0


CLOSING_UNITS = {"closed": 1.0, "% closed": 0.01}
"""Units of a gripper that reports how far it is closed: as a share, or in percent."""


def _table(data: Mapping[str, Any], name: str, where: str) -> Mapping[str, Any]:
    table = data.get(name, {})
    if not isinstance(table, Mapping):
        raise InvalidInput(f"{where}: {name}", table, f"a table [{name}]")
    return table


def _known(table: Mapping[str, Any], known: tuple[str, ...], where: str) -> Mapping[str, Any]:
    for key in table:
        if key not in known:
            raise UnknownName(where, key, known)
    return table


def _check_column(name: str, column: Any, where: str) -> None:
    several = isinstance(column, list) and column and all(_is_column(one) for one in column)
    if not _is_column(column) and not (several and name in JOINT_SIGNALS):
        valid = "a column: its name, or its number from 0" + ("; or a list" if name in JOINT_SIGNALS else "")
        raise InvalidInput(where, column, valid)


def _is_column(value: Any) -> bool:
    return isinstance(value, str) or (isinstance(value, int) and not isinstance(value, bool) and value >= 0)


def _positive(value: Any, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value < 1e6:
        raise InvalidInput(where, value, "a number > 0")
    return float(value)
