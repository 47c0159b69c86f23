"""What the columns of a log mean: names, units, the sign of torques and the order of joints, from a TOML file.

[columns]                 # a name, a list of names (one a joint), or a stem: q means q1, q2 ... or a 2-D array
time = "t"
q = ["q1", "q2", "q3"]
tau = "torque"
[units]                   # SI where nothing is said
q = "deg"
opening = "mm"
[options]
torque_sign = -1          # raw sign of Kortex arms; "auto" compares with gravity
joints = ["joint_1", "joint_2", "joint_3"]
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from dynamics.errors import InvalidInput, UnknownName
from estimation.foreign_units import factor_to

SI = {"time": "s", "q": "rad", "dq": "rad/s", "tau": "N m", "opening": "m", "effort": "A"}
JOINT_SIGNALS = ("q", "dq", "tau")
COLUMNS = (*SI, "phase")
OPTIONS = ("torque_sign", "joints", "topic", "max_opening", "gripper_joint", "gripper_closed")


@dataclass(frozen=True)
class LogMap:
    """How a log is to be understood.

    Attributes:
        columns: for each of ``COLUMNS`` the column, or the columns of its joints; a missing one has its own name.
        units: unit of a signal where it is not SI.
        torque_sign: 1 if torque is what the arm exerts, so that at rest it equals gravity's; -1 if it is the
            reaction, as Kortex arms report it; ``auto`` to find out; None for 1, or -1 in logs of Kortex drivers.
        joints: which joints of the log to take, in the arm's order; empty for all, in the log's order.
        topic: the topic of a bag to read; empty to find it.
        max_opening: opening of the gripper at 0 % [m].
        gripper_joint, gripper_closed: joint of the gripper in a bag, and its position when closed [rad].
    """

    columns: Mapping[str, str | tuple[str, ...]] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    torque_sign: Literal[1, -1, "auto"] | None = None
    joints: tuple[str, ...] = ()
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
                factor_to(SI[name], unit, f"{where}: units: {name}")
        sign = options.get("torque_sign")
        if sign not in (1, -1, "auto", None) or isinstance(sign, bool):
            raise InvalidInput(f"{where}: options: torque_sign", sign, '1, -1 or "auto"')
        joints = options.get("joints", [])
        if not isinstance(joints, list) or not all(isinstance(name, str) for name in joints):
            raise InvalidInput(f"{where}: options: joints", joints, "a list of joint names")
        for name in ("topic", "gripper_joint"):
            if not isinstance(options.get(name, ""), str):
                raise InvalidInput(f"{where}: options: {name}", options[name], "text")
        closed = options.get("gripper_closed")
        return cls(
            columns={name: tuple(c) if isinstance(c, list) else c for name, c in columns.items()},
            units=dict(units),
            torque_sign=sign,
            joints=tuple(joints),
            topic=options.get("topic", ""),
            max_opening=_positive(options.get("max_opening", 0.085), f"{where}: options: max_opening"),
            gripper_joint=options.get("gripper_joint", ""),
            gripper_closed=None if closed is None else _positive(closed, f"{where}: options: gripper_closed"),
        )

    def column(self, signal: str) -> str | tuple[str, ...]:
        """Return the column, or the columns, of a signal."""
        return self.columns.get(signal, signal)

    def scale(self, signal: str) -> tuple[float, float]:
        """Return factor and offset that turn a signal's numbers into SI."""
        unit = self.units.get(signal, SI[signal])
        if signal == "opening" and unit in CLOSING_UNITS:
            return -self.max_opening * CLOSING_UNITS[unit], self.max_opening
        return factor_to(SI[signal], unit, f"unit of {signal}"), 0.0


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
    several = isinstance(column, list) and column and all(isinstance(one, str) for one in column)
    if not isinstance(column, str) and not (several and name in JOINT_SIGNALS):
        raise InvalidInput(where, column, "a column" + (", or a list of columns" if name in JOINT_SIGNALS else ""))


def _positive(value: Any, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value < 1e6:
        raise InvalidInput(where, value, "a number > 0")
    return float(value)
