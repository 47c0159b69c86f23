"""The chunks of an MCAP file, in order, from a file that may be cut off anywhere.

The ``mcap`` library writes the files; as a reader it makes an object of every message, which is too slow for
minutes of samples at 1 kHz, so the framing is read here. Format: MCAP specification, version 0.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from dynamics.errors import InvalidInput

RECORD_LIMIT = 64 * 2**20  # bytes; nothing that a run writes is larger

_MAGIC = b"\x89MCAP0\r\n"
_CHUNK, _DATA_END = 0x06, 0x0F


def read_chunks(path: Path) -> Iterator[bytes]:
    """Yield the uncompressed chunks of an MCAP file in order, as far as they are whole and sound.

    Returns when the data end.

    Raises:
        InvalidInput: if it is no MCAP file.
        ValueError: with what was wrong, where the file is cut off or damaged.
    """
    for opcode, body in _outer_records(path):
        if opcode == _CHUNK:
            yield _unpack_chunk(body)


def read_records(path: Path) -> Iterator[tuple[int, bytes]]:
    """Yield opcode and content of every record of an MCAP file, those within chunks included.

    Raises:
        InvalidInput, ValueError: as :func:`read_chunks`.
    """
    for opcode, body in _outer_records(path):
        if opcode != _CHUNK:
            yield opcode, body
            continue
        chunk = _unpack_chunk(body)
        at = 0
        while at < len(chunk):
            if at + 9 > len(chunk):
                raise ValueError("a record runs past its chunk")
            end = at + 9 + int.from_bytes(chunk[at + 1 : at + 9], "little")
            if end > len(chunk):
                raise ValueError("a record runs past its chunk")
            yield chunk[at], chunk[at + 9 : end]
            at = end


def _outer_records(path: Path) -> Iterator[tuple[int, bytes]]:
    with open(path, "rb") as file:
        if file.read(8) != _MAGIC:
            raise InvalidInput(f"{path}", "another kind of file", "an MCAP file")
        while True:
            opcode, body = _record(file)
            if opcode == _DATA_END:  # what follows is the index
                return
            yield opcode, body


def _record(file: BinaryIO) -> tuple[int, bytes]:
    """Return the next record of a file: its opcode and content."""
    head = file.read(9)
    if len(head) < 9:
        raise ValueError("the file ends without its index")
    length = int.from_bytes(head[1:], "little")
    if length > RECORD_LIMIT:
        raise ValueError(f"a record of {length} bytes")
    body = file.read(length)
    if len(body) < length:
        raise ValueError("the file ends within a record")
    return head[0], body


def _unpack_chunk(body: bytes) -> bytes:
    """Return the uncompressed content of a chunk record, checked against its checksum."""
    import zstandard

    size, crc, name_length = struct.unpack_from("<QII", body, 16)
    if size > RECORD_LIMIT:
        raise ValueError(f"a chunk of {size} bytes")
    at = 32 + name_length
    compression = body[32:at]
    (length,) = struct.unpack_from("<Q", body, at)
    packed = body[at + 8 : at + 8 + length]
    if compression == b"zstd":
        try:
            data: bytes = zstandard.ZstdDecompressor().decompress(packed, max_output_size=size)
        except zstandard.ZstdError as error:
            raise ValueError(f"a damaged chunk: {error}") from None
    elif compression == b"lz4":
        data = _unpack_lz4(packed, size)
    elif compression == b"":
        data = packed
    else:
        raise ValueError(f"an unknown compression {compression!r}")
    if len(data) != size or (crc and zlib.crc32(data) != crc):
        raise ValueError("a chunk whose checksum is wrong")
    return data


def _unpack_lz4(packed: bytes, size: int) -> bytes:
    import lz4.frame

    try:
        data: bytes = lz4.frame.LZ4FrameDecompressor().decompress(packed, max_length=size)
    except RuntimeError as error:
        raise ValueError(f"a damaged chunk: {error}") from None
    return data
