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


def read_chunks(path: Path) -> Iterator[bytes]:
    """Yield the uncompressed chunks of an MCAP file in order, as far as they are whole and sound.

    Returns when the data end; raises ValueError, with what was wrong, when the file is cut off or damaged.
    """
    with open(path, "rb") as file:
        if file.read(8) != _MAGIC:
            raise InvalidInput(f"{path}", "another kind of file", "an MCAP file")
        while True:
            opcode, body = _record(file)
            if opcode == 0x0F:  # data end: what follows is the index
                return
            if opcode == 0x06:
                yield _unpack_chunk(body)


def _record(file: BinaryIO) -> tuple[int, bytes]:
    """Return the next record of a file: its opcode and content; only chunks are read."""
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
    elif compression == b"":
        data = packed
    else:
        raise ValueError(f"compression {compression!r}, which Palpate does not write")
    if len(data) != size or (crc and zlib.crc32(data) != crc):
        raise ValueError("a chunk whose checksum is wrong")
    return data
