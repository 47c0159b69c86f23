"""One ROS 2 message, sensor_msgs/msg/JointState, in the CDR encoding that ROS tools read.

All messages of one channel have the same names and the same number of joints, hence one fixed layout: it is
worked out once and a message is one call of ``struct``. Encapsulation and alignment: OMG DDSI-RTPS 2.3, 10.2.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

SCHEMA_NAME = "sensor_msgs/msg/JointState"
SCHEMA = """\
std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
_HEADER = b"\x00\x01\x00\x00"  # little-endian plain CDR


class Layout:
    """Where the fields of a JointState message stand when its names are given.

    Attributes:
        names: the joints, in order.
        size: length of a message [bytes].
        fields: byte positions of the numbers of position, velocity and effort.
    """

    def __init__(self, names: Sequence[str], velocity: bool = True) -> None:
        self.names = tuple(names)
        count = len(names)
        parts: list[bytes] = [struct.pack("<I", 1) + b"\0"]  # empty frame_id
        at = 8 + 5
        at = self._align(parts, at, 4)
        parts.append(struct.pack("<I", count))
        at += 4
        for name in self.names:
            at = self._align(parts, at, 4)
            text = name.encode() + b"\0"
            parts.append(struct.pack("<I", len(text)) + text)
            at += 4 + len(text)
        prefix = b"".join(parts)
        self._constants: list[bytes] = [prefix]
        pattern = f"<4sII{len(prefix)}s"
        self.fields: list[int] = []
        for present in (True, velocity, True):
            gap: list[bytes] = []
            at = self._align(gap, at, 4)
            gap.append(struct.pack("<I", count if present else 0))
            at += 4
            if present:
                at = self._align(gap, at, 8)
            constant = b"".join(gap)
            self._constants.append(constant)
            self.fields.append(4 + at)
            pattern += f"{len(constant)}s{count if present else 0}d"
            at += 8 * count if present else 0
        self._struct = struct.Struct(pattern)
        self.size = self._struct.size
        self._velocity = velocity

    def encode(self, nanoseconds: int, position: list[float], velocity: list[float], effort: list[float]) -> bytes:
        """Return the message of one instant."""
        names, before_position, before_velocity, before_effort = self._constants
        seconds, rest = divmod(nanoseconds, 1_000_000_000)
        return self._struct.pack(
            _HEADER, seconds & 0xFFFFFFFF, rest, names, before_position, *position, before_velocity, *velocity,
            before_effort, *effort,
        )  # fmt: skip

    @staticmethod
    def _align(parts: list[bytes], at: int, size: int) -> int:
        gap = -at % size
        parts.append(b"\0" * gap)
        return at + gap


class JointState(NamedTuple):
    """A decoded message: time stamp [ns], names, and arrays that are empty when absent."""

    nanoseconds: int
    names: tuple[str, ...]
    position: NDArray[np.float64]
    velocity: NDArray[np.float64]
    effort: NDArray[np.float64]


def decode(message: bytes | memoryview) -> JointState:
    """Return the content of a JointState message.

    Raises:
        ValueError: if the bytes are no such message.
    """
    view = memoryview(message)
    if len(view) < 12 or bytes(view[:2]) not in (b"\x00\x01", b"\x00\x00"):
        raise ValueError("no CDR message")
    order = "<" if view[1] == 1 else ">"
    body = view[4:]
    try:
        seconds, rest = struct.unpack_from(order + "iI", body, 0)
        at, _ = _string(order, body, 8)
        (count,) = struct.unpack_from(order + "I", body, _up(at, 4))
        at = _up(at, 4) + 4
        if count > len(body):
            raise ValueError(f"{count} names in {len(body)} bytes")
        names = []
        for _ in range(count):
            at, name = _string(order, body, _up(at, 4))
            names.append(name)
        arrays = []
        for _ in range(3):
            (count,) = struct.unpack_from(order + "I", body, _up(at, 4))
            at = _up(at, 4) + 4
            if count:
                at = _up(at, 8)
            if at + 8 * count > len(body):
                raise ValueError("an array runs past the end")
            arrays.append(np.frombuffer(body, order + "f8", count, at).astype(float) if count else np.empty(0))
            at += 8 * count
    except struct.error as error:
        raise ValueError(str(error)) from None
    return JointState(seconds * 1_000_000_000 + rest, tuple(names), arrays[0], arrays[1], arrays[2])


def _up(at: int, size: int) -> int:
    return at + -at % size


def _string(order: str, body: memoryview, at: int) -> tuple[int, str]:
    (length,) = struct.unpack_from(order + "I", body, at)
    if at + 4 + length > len(body):
        raise ValueError("a string runs past the end")
    text = bytes(body[at + 4 : at + 4 + length]).rstrip(b"\0")
    return at + 4 + length, text.decode("utf-8", "replace")
