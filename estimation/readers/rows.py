"""Joint states, one message after another, into columns that grow without a copy of the messages."""

from __future__ import annotations

from array import array
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from dynamics.errors import InvalidInput
from estimation.readers.kortex import GRIPPER_JOINTS, is_kortex
from estimation.readers.mapping import LogMap
from estimation.readers.signals import SHOWN, RawSignals
from estimation.recording.cdr import JointState
from estimation.recording.data import Rejections

MAX_JOINTS = 64
MAX_NUMBERS = 200_000_000  # 1.6 GB: a day of seven joints at 100 Hz


@dataclass
class Rows:
    """Grows row by row; what does not fit the first message is rejected and counted.

    Attributes:
        source: named in messages.
        mapping: names the gripper's joint where it is not a known one.
    """

    source: Path
    mapping: LogMap
    names: tuple[str, ...] = ()
    kortex: bool = False
    _numbers: array[float] = field(default_factory=lambda: array("d"))
    _places: array[int] = field(default_factory=lambda: array("q"))
    _all_names: tuple[str, ...] = ()
    _gripper: int | None = None
    _closed: float = 1.0
    _start: int | None = None
    _seen: int = 0
    _rejected: int = 0
    _reasons: list[str] = field(default_factory=list)
    _has_dq: bool = False
    _has_tau: bool = False

    def add_joint_state(self, state: JointState, logged: int) -> None:
        """Add a message; ``logged`` [ns] is its time where it bears no stamp."""
        self._seen += 1
        if not self.names and not self._set_up(state):
            return self.reject("no joints in it")
        if state.names != self._all_names:
            return self.reject("joints other than the first message's")
        total = len(self._all_names)
        if len(state.position) != total:
            return self.reject(f"{len(state.position)} positions for {total} joints")
        dq = _or_nan(state.velocity, total)
        tau = _or_nan(state.effort, total)
        arm = [n for n in range(total) if n != self._gripper]
        opening = np.nan
        if self._gripper is not None:
            opening = self.mapping.max_opening * (1 - state.position[self._gripper] / self._closed)
        self._has_dq |= len(state.velocity) == total
        self._has_tau |= len(state.effort) == total
        numbers = [*state.position[arm], *dq[arm], *tau[arm], opening, np.nan]
        return self.add(state.nanoseconds or logged, numbers)

    def add(self, nanoseconds: int, numbers: list[float]) -> None:
        """Add a row: q, dq, tau, opening, effort in SI."""
        if self._start is None:
            self._start = nanoseconds
        if len(self._numbers) > MAX_NUMBERS:
            raise InvalidInput(f"{self.source}", "more rows than fit in memory", f"{MAX_NUMBERS} numbers at most")
        self._numbers.append((nanoseconds - self._start) / 1e9)
        self._numbers.extend(numbers)
        self._places.append(self._seen)

    def add_feedback(self, nanoseconds: int, numbers: list[float]) -> None:
        """Add a row of a driver's own message."""
        self._seen += 1
        nv = (len(numbers) - 2) // 3
        if not self.names:
            if not 0 < nv <= MAX_JOINTS:
                return self.reject("no actuators in it")
            self.names = tuple(f"joint_{n}" for n in range(1, nv + 1))
            self._has_dq = self._has_tau = self.kortex = True
        if nv != len(self.names):
            return self.reject(f"{nv} actuators instead of {len(self.names)}")
        return self.add(nanoseconds, numbers)

    def reject(self, reason: str) -> None:
        """Count a message that can not be used."""
        self._rejected += 1
        if len(self._reasons) < SHOWN:
            self._reasons.append(f"message {self._seen}: {reason}")

    def skip(self, reason: str) -> None:
        """Count a message that could not even be decoded."""
        self._seen += 1
        self.reject(reason)

    def signals(self, notes: list[str]) -> RawSignals:
        """Return what was collected.

        Raises:
            InvalidInput: if there is nothing.
        """
        if not len(self._numbers):
            first = f" (first: {self._reasons[0]})" if self._reasons else ""
            raise InvalidInput(
                f"{self.source}", f"no joint states{first}", "a log with joint states, or option topic"
            )
        nv = len(self.names)
        table = np.frombuffer(self._numbers).reshape(len(self._places), 3 + 3 * nv)
        signals = {"time": table[:, 0], "q": table[:, 1 : 1 + nv]}
        if self._has_dq:
            signals["dq"] = table[:, 1 + nv : 1 + 2 * nv]
        if self._has_tau:
            signals["tau"] = table[:, 1 + 2 * nv : 1 + 3 * nv]
        for column, name in ((-2, "opening"), (-1, "effort")):
            if np.isfinite(table[:, column]).any():
                signals[name] = table[:, column]
        return RawSignals(
            signals,
            units_are_si=True,
            places=np.frombuffer(self._places, np.int64),
            place="message",
            joint_names=self.names,
            kortex=self.kortex,
            rejections=Rejections(self._rejected, tuple(self._reasons)),
            notes=[*notes, "times count from the first message"],
        )

    def _set_up(self, state: JointState) -> bool:
        gripper = self.mapping.gripper_joint
        known = [name for name in state.names if (name == gripper if gripper else name in GRIPPER_JOINTS)]
        if not 0 < len(state.names) - len(known) <= MAX_JOINTS:
            return False
        self._all_names = state.names
        if known:
            self._gripper = state.names.index(known[0])
            self._closed = self.mapping.gripper_closed or GRIPPER_JOINTS.get(known[0], 0.8)
        self.names = tuple(name for n, name in enumerate(state.names) if n != self._gripper)
        # Other makers name their joints so, too: only with the gripper's joint it is surely a Kortex driver.
        self.kortex = known != [] and not gripper and is_kortex(tuple(sorted(self.names)))
        return True


def _or_nan(values: np.ndarray, count: int) -> np.ndarray:
    return values if len(values) == count else np.full(count, np.nan)
