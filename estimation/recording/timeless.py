"""A recording without the time of day: the same run gives the same bytes, whenever it was made."""

from __future__ import annotations

import json
import os
import struct
from pathlib import Path
from typing import Any

from estimation.recording.chunks import read_records
from estimation.recording.stream import LIBRARY

_SCHEMA, _CHANNEL, _MESSAGE = 0x03, 0x04, 0x05
_HEAD = struct.Struct("<HIQQ")
_WALL_KEYS = ("wall", "started")


def forget_wall_clock(path: Path) -> None:
    """Rewrite a finished recording: times of day are left out, chunks are cut by size instead of by time.

    What the robot's clock says stays, and so does the order of everything.

    Raises:
        InvalidInput: if it is no MCAP file.
        ValueError: if it is cut off or damaged.
    """
    from mcap.writer import CompressionType, Writer

    temporary = path.with_name(f".{path.name}.tmp")
    with open(temporary, "wb") as file:
        writer = Writer(file, compression=CompressionType.ZSTD)
        writer.start(profile="", library=LIBRARY)
        schemas: dict[int, int] = {0: 0}
        channels: dict[int, tuple[int, bool]] = {}
        for opcode, body in read_records(path):
            if opcode == _SCHEMA:
                number, name, encoding, at = _schema(body)
                if number not in schemas:
                    schemas[number] = writer.register_schema(name, encoding, body[at + 4 :])
            elif opcode == _CHANNEL:
                number, schema = struct.unpack_from("<HH", body)
                topic, at = _text(body, 4)
                encoding, _ = _text(body, at)
                if number not in channels:
                    known = writer.register_channel(topic, encoding, schemas[schema])
                    channels[number] = known, encoding == "json"
            elif opcode == _MESSAGE:
                number, sequence, log_time, publish_time = _HEAD.unpack_from(body)
                known, is_event = channels[number]
                data = body[_HEAD.size :]
                writer.add_message(known, log_time, _timeless(data) if is_event else data, publish_time, sequence)
        writer.finish()
        file.flush()
        os.fsync(file.fileno())
    os.replace(temporary, path)


def _timeless(text: bytes) -> bytes:
    data: dict[str, Any] = json.loads(text)
    kept = {key: value for key, value in data.items() if key not in _WALL_KEYS}
    return json.dumps(kept, ensure_ascii=False).encode()


def _schema(body: bytes) -> tuple[int, str, str, int]:
    (number,) = struct.unpack_from("<H", body)
    name, at = _text(body, 2)
    encoding, at = _text(body, at)
    return number, name, encoding, at


def _text(body: bytes, at: int) -> tuple[str, int]:
    (length,) = struct.unpack_from("<I", body, at)
    return body[at + 4 : at + 4 + length].decode("utf-8"), at + 4 + length
