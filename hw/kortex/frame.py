"""Frames: the envelope of every Kortex message, on TCP and on UDP.

A frame is a protobuf message of a header (four 32-bit words of packed fields) and a payload. On UDP one
datagram is one frame; on TCP each frame follows a mark of eight bytes and its length, big-endian.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum

from google.protobuf.message import DecodeError

from hw.kortex import messages_pb2 as pb
from hw.kortex.errors import FrameError

VERSION = 1
MARK = b"\x07xEtRoK\x07"
PREFIX = struct.Struct(">8sI")
MAX_DATAGRAM = 65507  # bytes, what UDP over IPv4 carries
MAX_FRAME = 1 << 20  # bytes accepted from a stream; the largest answer used here has a few thousand


class FrameType(IntEnum):
    """What a frame is."""

    REQUEST = 1
    RAW = 2
    RESPONSE = 3
    NOTIFICATION = 5
    PING = 7
    PONG = 8


@dataclass(frozen=True)
class Frame:
    """One frame.

    Attributes:
        type: what it is.
        method: service << 16 | number of the method within the service.
        message: counter of the request, echoed by the answer; of a notification, the subscription.
        session: the session it belongs to, 0 before there is one.
        device: 0 for the base, otherwise the device it is routed to.
        error_code, error_sub_code: of an answer that is an error; 0 otherwise.
        payload: the serialized message.
    """

    type: FrameType
    method: int
    message: int
    session: int = 0
    device: int = 0
    error_code: int = 0
    error_sub_code: int = 0
    payload: bytes = b""


def encode(frame: Frame) -> bytes:
    """Return a frame as one datagram, or as the content behind a stream's prefix."""
    header = pb.Header(
        frame_info=VERSION << 28
        | frame.type << 24
        | (frame.device & 0xFF) << 16
        | (frame.error_code & 0xF) << 12
        | (frame.error_sub_code & 0xFFF),
        message_info=(frame.session & 0xFFFF) << 16 | (frame.message & 0xFFFF),
        service_info=VERSION << 28 | (frame.method & 0xFFFFFFF),
        payload_info=len(frame.payload),
    )
    return pb.Frame(header=header, payload=frame.payload).SerializeToString()


def encode_stream(frame: Frame) -> bytes:
    """Return a frame as it travels on a stream."""
    content = encode(frame)
    return PREFIX.pack(MARK, len(content)) + content


def decode(content: bytes) -> Frame:
    """Return the frame of a datagram.

    Raises:
        FrameError: if the bytes are no frame, of another version, or contradict their own length.
    """
    try:
        message = pb.Frame.FromString(content)
    except DecodeError:
        raise FrameError(f"{len(content)} bytes that are no frame: {_preview(content)}") from None
    header = message.header
    info = header.frame_info
    if info >> 28 != VERSION:
        raise FrameError(f"a frame of version {info >> 28}; valid: {VERSION}")
    try:
        kind = FrameType(info >> 24 & 0xF)
    except ValueError:
        raise FrameError(f"a frame of unknown type {info >> 24 & 0xF}") from None
    if header.payload_info & 0xFFFFFF != len(message.payload):
        stated = header.payload_info & 0xFFFFFF
        raise FrameError(f"a frame that states {stated} bytes of payload and has {len(message.payload)}")
    return Frame(
        type=kind,
        method=header.service_info & 0xFFFFFFF,
        message=header.message_info & 0xFFFF,
        session=header.message_info >> 16,
        device=info >> 16 & 0xFF,
        error_code=info >> 12 & 0xF,
        error_sub_code=info & 0xFFF,
        payload=message.payload,
    )


class StreamDecoder:
    """Cut a stream of bytes into frames, whatever pieces it arrives in.

    Holds at most one unfinished frame of ``max_frame`` bytes. A stream that has lost its mark cannot be
    trusted again: every further call repeats the error.
    """

    def __init__(self, max_frame: int = MAX_FRAME) -> None:
        self.max_frame = max_frame
        self._buffer = bytearray()
        self._error: FrameError | None = None

    @property
    def held(self) -> int:
        """Bytes of the unfinished frame that are kept."""
        return len(self._buffer)

    def feed(self, data: bytes) -> Iterator[Frame]:
        """Yield the frames that are complete with these further bytes.

        Raises:
            FrameError: at the first byte that cannot belong to a stream of frames.
        """
        if self._error is not None:
            raise self._error
        self._buffer += data
        try:
            while (content := self._cut()) is not None:
                yield decode(content)
        except FrameError as error:
            self._error = error
            self._buffer.clear()
            raise

    def _cut(self) -> bytes | None:
        """Return the content of the first frame, None if it is not complete yet."""
        head = bytes(self._buffer[: len(MARK)])
        if head != MARK[: len(head)]:
            raise FrameError(f"a stream without the mark of a frame: {_preview(head)}")
        if len(self._buffer) < PREFIX.size:
            return None
        _, length = PREFIX.unpack_from(self._buffer)
        if length > self.max_frame:
            raise FrameError(f"a frame of {length} bytes; valid: at most {self.max_frame}")
        end = PREFIX.size + length
        if len(self._buffer) < end:
            return None
        content = bytes(self._buffer[PREFIX.size : end])
        del self._buffer[:end]
        return content


def _preview(content: bytes) -> str:
    return content[:16].hex(" ") + (" ..." if len(content) > 16 else "")
