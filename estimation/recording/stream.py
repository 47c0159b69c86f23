"""Samples and events into an MCAP file, by a thread of its own so that the robot's loop never waits for the disk.

What is put in is written in the same order. At most FLUSH_PERIOD of samples is ever in memory only; what was
committed is on disk. The file is a readable prefix at every moment.
"""

from __future__ import annotations

import os
import threading
import time
from collections import deque
from collections.abc import Sequence
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from dynamics.errors import InvalidInput
from dynamics.signals import Sample
from estimation.recording.cdr import SCHEMA, SCHEMA_NAME, Layout
from estimation.recording.files import CannotRecord

JOINTS, GRIPPER = "/joint_states", "/gripper"
RUN, PHASE, DECISION, MEASUREMENT, BELIEF = "/run", "/phase", "/decision", "/measurement", "/belief"
OBSERVATION = "/observation"
LIBRARY = "palpate"  # what the header of the file calls its writer
GRIPPER_NAMES = ("gripper", "robot_clock")  # opening [m] and current [A]; the exact time, for stamps are whole ns

FLUSH_PERIOD = 0.2  # s, of the wall or of the robot's clock, whichever comes first
CAPACITY = 120_000  # samples that may wait for a disk that stalls: 2 minutes at 1 kHz
_PAUSE = 0.01  # s between two looks into the queue
_BATCH = 24  # samples written before other threads get their turn: about 1 ms

_SCHEMAS = {
    RUN: ("palpate.Run", {"object_name": {"type": "string"}, "config": {"type": "object"}}),
    PHASE: (
        "palpate.Phase",
        {"action": {"type": "string"}, "name": {"type": "string"}, "index": {"type": "integer"}},
    ),
    DECISION: ("palpate.Decision", {}),
    MEASUREMENT: (
        "palpate.Measurement",
        {
            "action": {"type": "string"},
            "property": {"type": "string"},
            "mean": {"type": "number"},
            "sd": {"type": "number"},
            "unit": {"type": "string"},
        },
    ),
    OBSERVATION: (
        "palpate.Observation",
        {"action": {"type": "string"}, "variable": {"type": "string"}, "likelihoods": {"type": "object"}},
    ),
    BELIEF: ("palpate.Belief", {}),
}


class MessageStream:
    """An MCAP file that grows while a robot moves.

    Args:
        path: the file, which must not exist.
        joint_names: in the order of the samples; ``joint_1`` ... if none are given.

    Raises:
        CannotRecord: now if the file can not be written, later from any call once writing has failed.
    """

    def __init__(self, path: Path, joint_names: Sequence[str] = ()) -> None:
        self.path = path
        self._names = tuple(joint_names)
        self._queue: deque[Any] = deque()
        self._wake = threading.Event()
        self._error: Exception | None = None
        self._closing = False
        self._file: BinaryIO
        try:
            self._file = open(path, "xb")  # noqa: SIM115 - open as long as the stream
            self._writer = _writer(self._file)
            self._channels = {topic: self._json_channel(topic) for topic in _SCHEMAS}
        except OSError as error:
            raise CannotRecord(f"{path}: {error.strerror or error}") from error
        self._layouts: tuple[Layout, Layout] | None = None
        self._newest = 0
        self._thread = threading.Thread(target=self._run, name=f"recorder of {path.name}", daemon=True)
        self._thread.start()

    def put_sample(self, sample: Sample) -> None:
        """Add a sample; never waits longer than a millisecond."""
        waiting = len(self._queue)
        if self._error is not None or waiting > CAPACITY:
            self._fail(waiting)
        if waiting > CAPACITY // 2:
            time.sleep(0.001)
        self._queue.append(sample)

    def put_event(self, topic: str, at: float, text: str) -> None:
        """Add an event as JSON."""
        self._fail_if_broken()
        self._queue.append((topic, _nanoseconds(at), text.encode()))

    def commit(self) -> None:
        """Wait until everything added so far is on disk."""
        self._fail_if_broken()
        done = threading.Event()
        self._queue.append(done)
        self._wake.set()
        while not done.wait(0.1):
            if not self._thread.is_alive():
                break
        self._fail_if_broken()

    def close(self) -> None:
        """Write what is left and the index of the file; safe to call twice."""
        if self._closing:
            return
        self._closing = True
        self._wake.set()
        self._thread.join()
        try:
            if self._error is None:
                self._writer.finish()
                self._sync()
        except OSError as error:
            self._error = error
        finally:
            try:
                self._file.close()
            except OSError as error:  # the unwritten rest of a full disk
                self._error = self._error or error
        self._fail_if_broken()

    def _run(self) -> None:
        flushed = time.monotonic()
        flushed_at = self._newest
        try:
            while True:
                self._wake.wait(_PAUSE)
                self._wake.clear()
                closing = self._closing
                while self._queue:
                    committed = self._write_batch()
                    overdue = self._newest - flushed_at > FLUSH_PERIOD * 1e9
                    if committed or overdue or time.monotonic() - flushed > FLUSH_PERIOD:
                        self._writer.flush()
                        flushed, flushed_at = time.monotonic(), self._newest
                    if committed:
                        self._sync()
                        committed.set()
                    time.sleep(0)  # let the robot's thread have the interpreter
                if time.monotonic() - flushed > FLUSH_PERIOD:
                    self._writer.flush()
                    flushed, flushed_at = time.monotonic(), self._newest
                if closing and not self._queue:
                    return
        except Exception as error:  # told to the robot's thread, which must stop the robot
            self._error = error
            for item in tuple(self._queue):
                if isinstance(item, threading.Event):
                    item.set()

    def _write_batch(self) -> threading.Event | None:
        """Write the oldest items; return the commit that is due after them."""
        for _ in range(min(_BATCH, len(self._queue))):
            item = self._queue.popleft()
            if isinstance(item, Sample):
                self._write_sample(item)
            elif isinstance(item, threading.Event):
                return item
            else:
                topic, at, data = item
                self._writer.add_message(self._channels[topic], at, data, at)
        return None

    def _write_sample(self, sample: Sample) -> None:
        if self._layouts is None:
            self._layouts = self._open_sample_channels(len(sample.q))
        joints, gripper = self._layouts
        at = self._newest = _nanoseconds(sample.time)
        q, dq, tau = (np.asarray(part, float).tolist() for part in (sample.q, sample.dq, sample.tau))
        add = self._writer.add_message
        add(self._channels[JOINTS], at, joints.encode(at, q, dq, tau), at)
        opening, effort = [float(sample.opening), float(sample.time)], [float(sample.effort), 0.0]
        add(self._channels[GRIPPER], at, gripper.encode(at, opening, [], effort), at)

    def _open_sample_channels(self, count: int) -> tuple[Layout, Layout]:
        names = self._names or tuple(f"joint_{n}" for n in range(1, count + 1))
        if len(names) != count:
            raise InvalidInput("recording: joint names", names, f"{count} names, as a sample has joints")
        schema = self._writer.register_schema(SCHEMA_NAME, "ros2msg", SCHEMA.encode())
        for topic in (JOINTS, GRIPPER):
            self._channels[topic] = self._writer.register_channel(topic, "cdr", schema)
        return Layout(names), Layout(GRIPPER_NAMES, velocity=False)

    def _json_channel(self, topic: str) -> int:
        import json

        name, properties = _SCHEMAS[topic]
        schema = {"type": "object", "properties": {"time": {"type": "number"}, **properties}}
        known: int = self._writer.register_schema(name, "jsonschema", json.dumps(schema).encode())
        channel: int = self._writer.register_channel(topic, "json", known)
        return channel

    def _sync(self) -> None:
        self._file.flush()
        os.fsync(self._file.fileno())

    def _fail_if_broken(self) -> None:
        if self._error is not None:
            self._fail(0)

    def _fail(self, waiting: int) -> None:
        if isinstance(self._error, InvalidInput):
            raise self._error
        if self._error is not None:
            reason = getattr(self._error, "strerror", None) or self._error
            raise CannotRecord(f"{self.path}: recording failed: {reason}") from self._error
        raise CannotRecord(f"{self.path}: the disk can not keep up; {waiting} samples are waiting to be written")


def _writer(file: BinaryIO) -> Any:
    from mcap.writer import CompressionType, Writer

    writer = Writer(file, compression=CompressionType.ZSTD)
    writer.start(profile="", library=LIBRARY)
    return writer


def _nanoseconds(at: float) -> int:
    if not 0 <= at < 1e10:
        raise InvalidInput("recording: time", at, "seconds of the robot's clock, from 0 to 1e10")
    return round(at * 1e9)
