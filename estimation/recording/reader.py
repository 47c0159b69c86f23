"""Read a run back, whole or cut off anywhere: everything that reached the disk before the cut is there."""

from __future__ import annotations

import json
import struct
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dynamics.errors import InvalidInput
from estimation.measurement import Measurement
from estimation.recording.cdr import Layout, decode
from estimation.recording.chunks import read_chunks
from estimation.recording.data import Entry, Mark, Recorded, Recording, Samples, no_samples
from estimation.recording.stream import BELIEF, DECISION, GRIPPER, JOINTS, MEASUREMENT, PHASE, RUN

SEGMENT_GAP = 1.0  # s put between two parts of a run whose clocks do not fit

_MESSAGE = struct.Struct("<BQHIQQ")
_TOPICS = (JOINTS, GRIPPER, RUN, PHASE, DECISION, MEASUREMENT, BELIEF)


def read_recording(path: Path) -> Recording:
    """Return the recording of a run directory, or of one MCAP file of Palpate.

    A run that was resumed has several files; their times are made to run on.

    Raises:
        InvalidInput: if there is no recording at this place, or the file is no MCAP file.
    """
    path = Path(path)
    files = _segments(path)
    builder = _Builder()
    for file in files:
        builder.add_segment(file)
    config = builder.config
    toml = path / "config.toml"
    if not config and path.is_dir() and toml.is_file():
        config = _read_toml(toml)
    return Recording(
        source=path,
        samples=builder.samples(),
        marks=tuple(builder.marks),
        decisions=tuple(builder.decisions),
        measurements=tuple(builder.measurements),
        beliefs=tuple(builder.beliefs),
        config=config,
        object_name=builder.object_name,
        started=builder.started,
        joint_names=builder.joint_names,
        complete=builder.complete,
        notes=tuple(builder.notes),
    )


@dataclass
class _Columns:
    """Rows of one kind of message, in blocks."""

    blocks: list[NDArray[np.float64]] = field(default_factory=list)
    count: int = 0

    def add(self, block: NDArray[np.float64]) -> None:
        self.blocks.append(block)
        self.count += len(block)


class _Builder:
    """Collects the content of the files of a run."""

    def __init__(self) -> None:
        self.marks: list[Mark] = []
        self.decisions: list[Entry] = []
        self.measurements: list[Recorded] = []
        self.beliefs: list[Entry] = []
        self.config: Mapping[str, Any] = {}
        self.object_name = ""
        self.started = ""
        self.joint_names: tuple[str, ...] = ()
        self.complete = True
        self.notes: list[str] = []
        self._parts: dict[str, list[NDArray[np.float64]]] = {}
        self._count = 0
        self._end = 0.0

    def samples(self) -> Samples:
        """Return the samples; the parts are given up column by column, to need little memory."""
        if not self._parts:
            return no_samples(len(self.joint_names))
        order = ("time", "q", "dq", "tau", "opening", "effort")
        return Samples(*(np.concatenate(self._parts.pop(name)) for name in order))

    def add_segment(self, file: Path) -> None:
        """Add one file."""
        part = _Segment(file)
        part.read()
        shift = 0.0
        if self._end and part.first_time is not None and part.first_time < self._end:
            shift = self._end + SEGMENT_GAP - part.first_time
            self.notes.append(f"{file.name}: its clock starts anew; {shift:.3f} s were added to its times")
        if part.note:
            self.complete = False
            self.notes.append(f"{file.name}: {part.note}")
        if part.names and self.joint_names and part.names != self.joint_names:
            raise InvalidInput(f"{file}: joint names", part.names, ", ".join(self.joint_names))
        self.joint_names = self.joint_names or part.names
        self.config = self.config or part.config
        self.object_name = self.object_name or part.object_name
        self.started = self.started or part.started
        for name, blocks in part.columns(shift).items():
            self._parts.setdefault(name, []).extend(blocks)
        base = self._count
        self.marks += [Mark(m.action, m.name, m.index, m.start + base, m.stop + base) for m in part.marks]
        self._count += part.count
        self.decisions += [Entry(e.time + shift, e.data, e.row + base) for e in part.decisions]
        self.beliefs += [Entry(e.time + shift, e.data, e.row + base) for e in part.beliefs]
        self.measurements += [replace(m, time=m.time + shift, row=m.row + base) for m in part.measurements]
        self._end = max(self._end, part.last_time + shift)


class _Segment:
    """The content of one file."""

    def __init__(self, file: Path) -> None:
        self.file = file
        self.names: tuple[str, ...] = ()
        self.marks: list[Mark] = []
        self.decisions: list[Entry] = []
        self.beliefs: list[Entry] = []
        self.measurements: list[Recorded] = []
        self.config: Mapping[str, Any] = {}
        self.object_name = ""
        self.started = ""
        self.note = ""
        self.count = 0
        self.first_time: float | None = None
        self.last_time = 0.0
        self._topics: dict[int, str] = {}
        self._joints, self._gripper = _Columns(), _Columns()
        self._layouts: dict[int, tuple[int, NDArray[np.intp]]] = {}
        self._open: tuple[str, str, int, int] | None = None

    def read(self) -> None:
        """Read the file as far as it is sound."""
        try:
            for chunk in read_chunks(self.file):
                self._add_chunk(chunk)
        except (ValueError, struct.error) as error:
            self.note = f"cut off or damaged: {error}; everything before it was kept"
        self.count = min(self._joints.count, self._gripper.count)
        self._close_phase(self.count)
        self.marks = [
            Mark(m.action, m.name, m.index, min(m.start, self.count), min(m.stop, self.count)) for m in self.marks
        ]

    def columns(self, shift: float) -> dict[str, list[NDArray[np.float64]]]:
        """Return the samples' columns, each in blocks, and forget them."""
        joints, gripper = self._joints.blocks, self._gripper.blocks
        self._joints, self._gripper = _Columns(), _Columns()
        if not self.count:
            return {}
        nv = len(self.names)
        parts: dict[str, list[NDArray[np.float64]]] = {
            name: [] for name in ("time", "q", "dq", "tau", "opening", "effort")
        }
        for block in _limited(joints, self.count):
            parts["time"].append(block[:, 0] + shift)
            for number, name in enumerate(("q", "dq", "tau")):
                parts[name].append(block[:, 1 + number * nv : 1 + (number + 1) * nv].copy())
        for block in _limited(gripper, self.count):
            parts["opening"].append(block[:, 1].copy())
            parts["effort"].append(block[:, 2].copy())
        return parts

    def _add_chunk(self, chunk: bytes) -> None:
        at, end = 0, len(chunk)
        rows: dict[int, list[int]] = {}
        size: dict[int, int] = {}
        topics = self._topics
        unpack = _MESSAGE.unpack_from
        while at + 9 <= end:
            opcode = chunk[at]
            if opcode == 0x05 and at + 31 <= end:
                _, length, channel, _, log_time, _ = unpack(chunk, at)
                if at + 9 + length > end:
                    raise ValueError("a message runs past its chunk")
                topic = topics.get(channel, "")
                if topic in (JOINTS, GRIPPER):
                    if size.setdefault(channel, length) != length:
                        raise ValueError("messages of one channel differ in size")
                    rows.setdefault(channel, []).append(at)
                elif topic:
                    self._add_event(topic, log_time, chunk[at + 31 : at + 9 + length], rows)
            else:
                (length,) = struct.unpack_from("<Q", chunk, at + 1)
                if opcode == 0x04 and at + 9 + length <= end:
                    self._add_channel(chunk[at + 9 : at + 9 + length])
            at += 9 + length
        if at != end:
            raise ValueError("a record runs past its chunk")
        for channel, places in rows.items():
            self._add_rows(channel, chunk, places, size[channel] + 9)

    def _add_rows(self, channel: int, chunk: bytes, places: list[int], size: int) -> None:
        """Take the numbers out of messages of one channel, all at once."""
        columns, width = self._layout(channel, chunk[places[0] + 31 : places[0] + size])
        raw = np.frombuffer(chunk, np.uint8)
        stamps = np.array(places)[:, None] + 15 + np.arange(8)
        times = raw[stamps].view("<u8")[:, 0].astype(float) / 1e9
        spans = np.array(places)[:, None] + 31 + width
        values = raw[spans].view("<f8")
        block = np.column_stack([times, values])
        columns.add(block)
        if self.first_time is None:
            self.first_time = float(times[0])
        self.last_time = max(self.last_time, float(times[-1]))

    def _layout(self, channel: int, message: bytes) -> tuple[_Columns, NDArray[np.intp]]:
        is_joints = self._topics[channel] == JOINTS
        if channel not in self._layouts:
            first = decode(message)
            layout = Layout(first.names, velocity=is_joints)
            if layout.size != len(message):
                raise ValueError("an unknown layout of joint states")
            if is_joints:
                self.names = first.names
            count = len(first.names)
            counts = (count, count if is_joints else 0, count)
            spans = [start + np.arange(8 * n) for start, n in zip(layout.fields, counts, strict=True)]
            self._layouts[channel] = (layout.size, np.concatenate(spans))
        size, spans_of = self._layouts[channel]
        if size != len(message):
            raise ValueError("messages of one channel differ in size")
        return (self._joints if is_joints else self._gripper), spans_of

    def _add_channel(self, body: bytes) -> None:
        number, _ = struct.unpack_from("<HH", body)
        (length,) = struct.unpack_from("<I", body, 4)
        topic = body[8 : 8 + length].decode("utf-8", "replace")
        if topic in _TOPICS:
            self._topics[number] = topic

    def _add_event(self, topic: str, log_time: int, text: bytes, rows: Mapping[int, list[int]]) -> None:
        try:
            row = self._so_far(rows)
            data = json.loads(text)
            if not isinstance(data, dict):
                raise ValueError("no JSON object")
            if topic == PHASE:
                self._add_phase(data, row)
            elif topic == DECISION:
                self.decisions.append(Entry(float(data["time"]), data["data"], row))
            elif topic == BELIEF:
                self.beliefs.append(Entry(float(data["time"]), data["data"], row))
            elif topic == MEASUREMENT:
                value = Measurement(
                    str(data["property"]), float(data["mean"]), float(data["sd"]), str(data["unit"])
                )
                self.measurements.append(Recorded(float(data["time"]), str(data["action"]), value, row))
            else:
                self.config = dict(data["config"])
                self.object_name = str(data["object_name"])
                self.started = str(data.get("started", ""))
        except (KeyError, TypeError, ValueError, InvalidInput, RecursionError) as error:
            raise ValueError(f"{topic} at {log_time / 1e9:.3f} s: {error}") from None
        if topic != RUN:
            self.last_time = max(self.last_time, log_time / 1e9)

    def _so_far(self, rows: Mapping[int, list[int]]) -> int:
        here = [len(places) for channel, places in rows.items() if self._topics[channel] == JOINTS]
        return self._joints.count + sum(here)

    def _add_phase(self, data: Mapping[str, Any], row: int) -> None:
        self._close_phase(row)
        if data["event"] == "start":
            self._open = (str(data["action"]), str(data["name"]), int(data["index"]), row)

    def _close_phase(self, row: int) -> None:
        if self._open is not None:
            self.marks.append(Mark(*self._open, stop=row))
            self._open = None


def _limited(blocks: list[NDArray[np.float64]], count: int) -> Iterator[NDArray[np.float64]]:
    for block in blocks:
        if count <= 0:
            return
        yield block[:count]
        count -= len(block)


def _segments(path: Path) -> list[Path]:
    if path.is_file():
        return [path]
    files = sorted(path.glob("run-*.mcap"), key=lambda file: _number(file.stem)) if path.is_dir() else []
    if (path / "run.mcap").is_file():
        files.insert(0, path / "run.mcap")
    if not files:
        raise InvalidInput(f"recording {path}", "no run.mcap", "a run directory or an MCAP file")
    return files


def _number(stem: str) -> int:
    tail = stem.removeprefix("run-")
    return int(tail) if tail.isdecimal() else 0


def _read_toml(path: Path) -> Mapping[str, Any]:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, OSError) as error:
        raise InvalidInput(str(path), str(error), "a TOML file") from None
