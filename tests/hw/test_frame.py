"""Frames on the wire: bytes built by hand from the protocol's description, and whatever else may arrive."""

import contextlib
import itertools
import struct
import tracemalloc

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hw.kortex.errors import FrameError
from hw.kortex.frame import MARK, Frame, FrameType, StreamDecoder, decode, encode, encode_stream

FRAMES = st.builds(
    Frame,
    type=st.sampled_from(FrameType),
    method=st.integers(0, 2**28 - 1),
    message=st.integers(0, 2**16 - 1),
    session=st.integers(0, 2**16 - 1),
    device=st.integers(0, 255),
    error_code=st.integers(0, 15),
    error_sub_code=st.integers(0, 4095),
    payload=st.binary(max_size=300),
)


def by_hand(version=1, kind=1, method=0x30003, message=7, session=5, payload=b"", length=None):
    """A frame of four little-endian fixed32 and a payload, without a protobuf library."""
    words = (
        version << 28 | kind << 24,
        session << 16 | message,
        1 << 28 | method,
        len(payload) if length is None else length,
    )
    header = b"".join(bytes([number << 3 | 5]) + struct.pack("<I", w) for number, w in enumerate(words, 1) if w)
    body = bytes([payload and 0x12, len(payload)]) + payload if payload else b""
    return bytes([0x0A, len(header)]) + header + body


def test_request_on_the_wire_is_as_described():
    frame = Frame(FrameType.REQUEST, 0x30003, 7, session=5, payload=b"abc")
    assert encode(frame) == by_hand(payload=b"abc")
    assert encode_stream(frame) == b"\x07xEtRoK\x07" + struct.pack(">I", len(encode(frame))) + encode(frame)


def test_error_code_and_device_are_where_they_belong():
    frame = Frame(FrameType.RESPONSE, 0x10001, 1, device=3, error_code=3, error_sub_code=141)
    (info,) = struct.unpack("<I", encode(frame)[3:7])
    assert info == 1 << 28 | 3 << 24 | 3 << 16 | 3 << 12 | 141


@given(FRAMES)
def test_round_trip(frame):
    assert decode(encode(frame)) == frame


@given(st.lists(FRAMES, max_size=5), st.lists(st.integers(1, 40), min_size=1, max_size=50))
def test_stream_in_any_pieces(frames, sizes):
    stream = b"".join(map(encode_stream, frames))
    decoder, found, at = StreamDecoder(), [], 0
    for size in [*sizes, len(stream) + 1]:
        found += decoder.feed(stream[at : at + size])
        at += size
    assert found == frames


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (by_hand(version=2), "version 2"),
        (by_hand(kind=4), "unknown type 4"),
        (by_hand(payload=b"abc", length=4), "states 4 bytes"),
        (b"\xff" * 9, "no frame"),
        (b"", "version 0"),
    ],
)
def test_what_is_no_frame_says_why(content, words):
    with pytest.raises(FrameError, match=words):
        decode(content)


def test_a_stream_without_the_mark_stays_broken():
    decoder = StreamDecoder()
    with pytest.raises(FrameError, match="without the mark"):
        list(decoder.feed(b"HTTP/1.1 200 OK"))
    with pytest.raises(FrameError, match="without the mark"):
        list(decoder.feed(encode_stream(Frame(FrameType.PING, 0, 1))))


def test_an_enormous_length_is_refused_before_anything_is_kept():
    decoder = StreamDecoder()
    with pytest.raises(FrameError, match="4294967295 bytes; valid: at most"):
        list(decoder.feed(MARK + b"\xff\xff\xff\xff"))


def test_fuzz():
    """1e5 random and mutated inputs: a frame or a FrameError, nothing else, and no memory kept."""
    rng = np.random.default_rng(1)
    seeds = [
        encode_stream(Frame(FrameType.RESPONSE, 0x30003, n, 5, payload=rng.bytes(80 * n))) for n in range(1, 6)
    ]
    outcomes = {"frame": 0, "error": 0, "more": 0}
    for number in range(100_000):
        if number % 4 == 0:
            data = bytearray(rng.bytes(int(rng.integers(0, 120))))
        else:
            data = bytearray(seeds[number % len(seeds)])
            for _ in range(int(rng.integers(0, 4))):
                at = int(rng.integers(len(data)))
                action = rng.integers(4)
                if action == 0:
                    data[at] = rng.integers(256)
                elif action == 1:
                    del data[at : at + int(rng.integers(1, 9))]
                elif action == 2:
                    data[at:at] = rng.bytes(int(rng.integers(1, 9)))
                else:
                    data[at] ^= 1 << int(rng.integers(8))
                data = data or bytearray(1)
        decoder = StreamDecoder(max_frame=4096)
        try:
            found = list(decoder.feed(bytes(data)))
            outcomes["frame" if found else "more"] += 1
        except FrameError:
            outcomes["error"] += 1
        with contextlib.suppress(FrameError):
            decode(bytes(data[12:]))
        assert decoder.held <= 4096 + 12
    assert min(outcomes.values()) > 1000, outcomes


def test_memory_stays_bounded():
    """A stream that never ends a frame, and one of many frames, hold no more than the largest frame."""
    unfinished = MARK + struct.pack(">I", 60_000)
    whole = encode_stream(Frame(FrameType.RESPONSE, 0x30003, 1, payload=bytes(1000)))
    tracemalloc.start()
    for stream in (
        itertools.chain([unfinished], itertools.repeat(bytes(1000), 59)),
        itertools.repeat(whole, 2000),
    ):
        decoder = StreamDecoder(max_frame=64_000)
        for piece in stream:
            for _ in decoder.feed(piece):
                pass
            assert decoder.held <= 64_000 + 12
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 1 << 20
