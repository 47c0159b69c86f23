"""ROS 2 logs in MCAP, also cut off ones: the joint states of a file, read without ROS and without its index."""

from __future__ import annotations

import struct
from pathlib import Path

from dynamics.arm import Arm
from dynamics.errors import InvalidInput
from estimation.readers.mapping import LogMap
from estimation.readers.rows import Rows
from estimation.readers.signals import to_recording
from estimation.recording.cdr import SCHEMA_NAME, decode
from estimation.recording.chunks import read_records
from estimation.recording.data import Recording
from estimation.recording.reader import read_recording
from estimation.recording.stream import LIBRARY

_CHANNEL, _MESSAGE, _SCHEMA, _HEADER = 0x04, 0x05, 0x03, 0x01


def read_mcap(path: Path, mapping: LogMap, arm: Arm | None = None) -> Recording:
    """Return the recording of an MCAP file: a run of Palpate, or joint states of ROS 2.

    Raises:
        InvalidInput: if it is no MCAP file or holds no joint states.
    """
    rows = Rows(path, mapping)
    notes: list[str] = []
    schemas: dict[int, str] = {}
    topics: dict[int, str] = {}
    try:
        for opcode, body in read_records(path):
            if opcode == _HEADER and _text(body, 4 + struct.unpack_from("<I", body)[0]) == LIBRARY:
                return read_recording(path)
            if opcode == _SCHEMA:
                schemas[struct.unpack_from("<H", body)[0]] = _text(body, 2)
            elif opcode == _CHANNEL:
                number, schema = struct.unpack_from("<HH", body)
                if schemas.get(schema) == SCHEMA_NAME:
                    topics[number] = _text(body, 4)
            elif opcode == _MESSAGE:
                channel, _, logged = struct.unpack_from("<HIQ", body)
                wanted = mapping.topic or next(iter(topics.values()), "")
                if topics.get(channel, "") == wanted != "":
                    _add(rows, body[22:], logged)
    except (ValueError, struct.error) as error:
        notes.append(f"cut off or damaged: {error}; everything before it was kept")
    if mapping.topic and mapping.topic not in topics.values():
        raise InvalidInput(
            f"{path}: topic", mapping.topic, ", ".join(topics.values()) or "no joint states are in it"
        )
    return to_recording(path, rows.signals(notes), mapping, arm)


def _add(rows: Rows, message: bytes, logged: int) -> None:
    try:
        rows.add_joint_state(decode(message), logged)
    except ValueError as error:
        rows.skip(str(error))


def _text(body: bytes, at: int) -> str:
    (length,) = struct.unpack_from("<I", body, at)
    return body[at + 4 : at + 4 + length].decode("utf-8", "replace")
