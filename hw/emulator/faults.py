"""Faults on demand: what the emulated arm can be made to suffer, and when."""

from __future__ import annotations

import re
from dataclasses import dataclass

from dynamics.errors import InvalidInput, UnknownName

FAULTS = {
    "loss": "=SHARE of the datagrams is lost, each way",
    "delay": "=SECONDS before an answer leaves",
    "drop": "every TCP connection breaks",
    "silence": "no datagram is answered any more",
    "mute": "no request at all is answered any more",
    "fault": "=PLACE:BITS, a fault such as joint2:0x20 or base:0x10",
    "estop": "the emergency stop is pressed",
    "abort": "the running trajectory is given up",
    "stuck-gripper": "the gripper no longer moves",
    "garbage": "bytes that are no frame are sent on TCP",
}
_VALUED = ("loss", "delay", "fault")


@dataclass(frozen=True)
class Fault:
    """One thing that goes wrong.

    Attributes:
        name: one of FAULTS.
        value: what it takes, empty for most.
        after: seconds into the next motion at which it happens [s]; at once if None.
    """

    name: str
    value: str = ""
    after: float | None = None

    def __post_init__(self) -> None:
        if self.name not in FAULTS:
            raise UnknownName("fault", self.name, FAULTS)
        if (self.name in _VALUED) != bool(self.value):
            raise InvalidInput(f"fault {self.name}", self.value, FAULTS[self.name])
        if self.name == "fault":
            self.bits()
        elif self.value:
            self.number()

    @classmethod
    def parse(cls, text: str) -> Fault:
        """Return the fault of ``name[=value][@seconds]``.

        Raises:
            InvalidInput: if the text is no such thing.
        """
        match = re.fullmatch(r"([a-z-]+)(?:=([^@]+))?(?:@(\d+(?:\.\d*)?))?", text)
        if match is None:
            raise InvalidInput("fault", text, "NAME[=VALUE][@SECONDS], such as loss=0.05 or estop@0.5")
        name, value, after = match.groups()
        return cls(name, value or "", None if after is None else float(after))

    def number(self) -> float:
        """Return the value as a number >= 0; of a loss, below 1."""
        try:
            number = float(self.value)
        except ValueError:
            number = -1.0
        if not 0 <= number < (1 if self.name == "loss" else 60):
            raise InvalidInput(f"fault {self.name}", self.value, FAULTS[self.name])
        return number

    def bits(self) -> tuple[int, int]:
        """Return where the fault is, 0 for the base or the number of the joint, and its bits."""
        match = re.fullmatch(r"(base|joint([1-9]))[:=](0x[0-9a-f]+|\d+)", self.value)
        if match is None:
            raise InvalidInput("fault fault", self.value, FAULTS["fault"])
        bits = int(match[3], 0)
        if not 0 < bits < 1 << 32:
            raise InvalidInput("fault fault", self.value, "bits of a bank of 32")
        return int(match[2] or 0), bits
