"""One file of a run, read as far as it is whole.

The file of a run is regular: joint state, gripper state, joint state ... of one size each, with an event now and
then. Stretches of that form are taken out of a chunk as columns of one array; only what breaks the form is looked
at message by message.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dynamics.errors import InvalidInput
from estimation.measurement import Measurement
from estimation.observation import Observation
from estimation.recording.cdr import Layout, decode
from estimation.recording.chunks import read_chunks
from estimation.recording.data import Entry, Mark, Observed, Recorded
from estimation.recording.stream import (
    BELIEF,
    DECISION,
    GRIPPER,
    GRIPPER_NAMES,
    JOINTS,
    MEASUREMENT,
    OBSERVATION,
    PHASE,
    RUN,
)

Array = NDArray[np.float64]

COLUMNS = ("time", "q", "dq", "tau", "opening", "effort")

_MESSAGE = struct.Struct("<BQHIQQ")
_HEAD = 11  # bytes of a message record that are equal within a channel: opcode, length, channel
_DATA = 31  # where the message stands in its record
_TOPICS = (JOINTS, GRIPPER, RUN, PHASE, DECISION, MEASUREMENT, OBSERVATION, BELIEF)


class _Form:
    """The records of one channel of samples: what they begin with and where their numbers stand."""

    def __init__(self, chunk: bytes, place: int, size: int, is_joints: bool) -> None:
        first = decode(chunk[place + _DATA : place + size])
        layout = Layout(first.names, velocity=is_joints)
        if layout.size != size - _DATA:
            raise ValueError("an unknown layout of joint states")
        if not is_joints and first.names != GRIPPER_NAMES:
            raise ValueError(f"gripper states of {first.names}")
        self.names = first.names
        self.size = size
        self.head = np.frombuffer(chunk, np.uint8, _HEAD, place)
        width = 8 * len(first.names)
        widths = (width, width if is_joints else 0, width)
        self.fields = [slice(_DATA + at, _DATA + at + w) for at, w in zip(layout.fields, widths, strict=True)]


class Segment:
    """The content of one file.

    Attributes:
        names: of the joints.
        marks, decisions, beliefs, measurements, observations: as in a recording.
        config, object_name, started: what the run said of itself.
        note: why the rest could not be read; empty if all could.
        count: number of samples.
        first_time, last_time: of what is in it [s]; None if there is nothing.
    """

    def __init__(self, file: Path) -> None:
        self.file = file
        self.names: tuple[str, ...] = ()
        self.marks: list[Mark] = []
        self.decisions: list[Entry] = []
        self.beliefs: list[Entry] = []
        self.measurements: list[Recorded] = []
        self.observations: list[Observed] = []
        self.config: Mapping[str, Any] = {}
        self.object_name = ""
        self.started = ""
        self.note = ""
        self.count = 0
        self.first_time: float | None = None
        self.last_time = 0.0
        self._topics: dict[int, str] = {}
        self._forms: dict[str, _Form] = {}
        self._blocks: dict[str, list[Array]] = {name: [] for name in COLUMNS}
        self._rows = {JOINTS: 0, GRIPPER: 0}
        self._open: tuple[str, str, int, int] | None = None

    def read(self) -> None:
        """Read the file as far as it is sound."""
        try:
            for chunk in read_chunks(self.file):
                self._add_chunk(chunk)
        except (ValueError, struct.error) as error:
            self.note = f"cut off or damaged: {error}; everything before it was kept"
        self.count = min(self._rows.values())  # the last sample may lack its second half
        self._close_phase(self.count)
        last = self.count
        self.marks = [replace(m, start=min(m.start, last), stop=min(m.stop, last)) for m in self.marks]
        self.decisions = [replace(e, row=min(e.row, last)) for e in self.decisions]
        self.beliefs = [replace(e, row=min(e.row, last)) for e in self.beliefs]
        self.measurements = [replace(m, row=min(m.row, last)) for m in self.measurements]
        self.observations = [replace(o, row=min(o.row, last)) for o in self.observations]

    def blocks(self, name: str) -> list[Array]:
        """Return a column of the samples, in blocks, and forget it."""
        blocks, left = self._blocks.pop(name), self.count
        found = []
        for block in blocks:
            found.append(block[:left])
            left -= len(found[-1])
        return found

    def _add_chunk(self, chunk: bytes) -> None:
        at, end = 0, len(chunk)
        raw = np.frombuffer(chunk, np.uint8)
        while at < end:
            if at + 9 > end:
                raise ValueError("a record runs past its chunk")
            size = 9 + int.from_bytes(chunk[at + 1 : at + 9], "little")
            if at + size > end:
                raise ValueError("a record runs past its chunk")
            opcode = chunk[at]
            if opcode == 0x05 and size >= _DATA:
                _, _, channel, _, log_time, _ = _MESSAGE.unpack_from(chunk, at)
                topic = self._topics.get(channel, "")
                if topic in (JOINTS, GRIPPER):
                    taken = self._add_regular(raw, at) if topic == JOINTS else 0
                    if taken:
                        at += taken
                        continue
                    self._add_single(topic, chunk, raw, at, size)
                elif topic:
                    self._add_event(topic, log_time, chunk[at + _DATA : at + size])
            elif opcode == 0x04:
                self._add_channel(chunk[at + 9 : at + size])
            at += size

    def _add_regular(self, raw: NDArray[np.uint8], at: int) -> int:
        """Take samples in the regular form from here on, both halves of each; return the bytes that they fill."""
        joints, gripper = self._forms.get(JOINTS), self._forms.get(GRIPPER)
        if joints is None or gripper is None or self._rows[JOINTS] != self._rows[GRIPPER]:
            return 0
        stride = joints.size + gripper.size
        count = (len(raw) - at) // stride
        if count == 0:
            return 0
        table = raw[at : at + count * stride].reshape(count, stride)
        regular = np.all(table[:, :_HEAD] == joints.head, axis=1)
        second = table[:, joints.size :]
        regular &= np.all(second[:, :_HEAD] == gripper.head, axis=1)
        count = count if regular.all() else int(np.argmin(regular))
        if count:
            self._take(JOINTS, joints, table[:count])
            self._take(GRIPPER, gripper, second[:count])
        return count * stride

    def _add_single(self, topic: str, chunk: bytes, raw: NDArray[np.uint8], at: int, size: int) -> None:
        form = self._forms.get(topic)
        if form is None:
            form = self._forms[topic] = _Form(chunk, at, size, topic == JOINTS)
            if topic == JOINTS:
                self.names = form.names
        if size != form.size:
            raise ValueError("messages of one channel differ in size")
        self._take(topic, form, raw[None, at : at + size])

    def _take(self, topic: str, form: _Form, table: NDArray[np.uint8]) -> None:
        """Take the numbers out of records of one channel, (n, size) bytes."""
        values = [
            np.ascontiguousarray(table[:, span]).view("<f8").astype(float, copy=False) for span in form.fields
        ]
        if topic == JOINTS:
            for name, column in zip(("q", "dq", "tau"), values, strict=True):
                self._blocks[name].append(column)
        else:
            opening, time = values[0].T.copy()
            self._blocks["opening"].append(opening)
            self._blocks["time"].append(time)
            self._blocks["effort"].append(values[2][:, 0])
            self._see(float(time[0]))
            self._see(float(time[-1]))
        self._rows[topic] += len(table)

    def _see(self, time: float) -> None:
        self.first_time = time if self.first_time is None else self.first_time
        self.last_time = max(self.last_time, time)

    def _add_channel(self, body: bytes) -> None:
        number, _ = struct.unpack_from("<HH", body)
        (length,) = struct.unpack_from("<I", body, 4)
        topic = body[8 : 8 + length].decode("utf-8", "replace")
        if topic in _TOPICS:
            self._topics[number] = topic

    def _add_event(self, topic: str, log_time: int, text: bytes) -> None:
        row = self._rows[JOINTS]
        try:
            data = json.loads(text)
            if not isinstance(data, dict):
                raise ValueError("no JSON object")
            if topic == RUN:
                self.config = dict(data["config"])
                self.object_name = str(data["object_name"])
                self.started = str(data.get("started", ""))
                return
            time = float(data["time"])
            if topic == PHASE:
                self._add_phase(data, row)
            elif topic == DECISION:
                self.decisions.append(Entry(time, data["data"], row))
            elif topic == BELIEF:
                self.beliefs.append(Entry(time, data["data"], row))
            elif topic == OBSERVATION:
                likelihoods = {str(name): float(value) for name, value in data["likelihoods"].items()}
                seen = Observation.of(str(data["variable"]), likelihoods)
                self.observations.append(Observed(time, str(data["action"]), seen, row))
            else:
                value = Measurement(
                    str(data["property"]), float(data["mean"]), float(data["sd"]), str(data["unit"])
                )
                self.measurements.append(Recorded(time, str(data["action"]), value, row))
        except (
            KeyError,
            TypeError,
            ValueError,
            AttributeError,
            OverflowError,
            InvalidInput,
            RecursionError,
        ) as error:
            raise ValueError(f"{topic} at {log_time / 1e9:.3f} s: {error}") from None
        self._see(log_time / 1e9)

    def _add_phase(self, data: Mapping[str, Any], row: int) -> None:
        self._close_phase(row)
        if data["event"] == "start":
            self._open = (str(data["action"]), str(data["name"]), int(data["index"]), row)

    def _close_phase(self, row: int) -> None:
        if self._open is not None:
            self.marks.append(Mark(*self._open, stop=row))
            self._open = None
