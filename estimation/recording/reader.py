"""Read a run back, whole or cut off anywhere: everything that reached the disk before the cut is there."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dynamics.errors import InvalidInput
from estimation.recording.data import Entry, Mark, Observed, Recorded, Recording, Samples, no_samples
from estimation.recording.segment import COLUMNS, Segment

SEGMENT_GAP = 1.0  # s put between two parts of a run whose clocks do not fit


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
        clock=builder.clock(),
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
        observations=tuple(builder.observations),
    )


class _Builder:
    """Collects the content of the files of a run."""

    def __init__(self) -> None:
        self.marks: list[Mark] = []
        self.decisions: list[Entry] = []
        self.measurements: list[Recorded] = []
        self.beliefs: list[Entry] = []
        self.observations: list[Observed] = []
        self.config: Mapping[str, Any] = {}
        self.object_name = ""
        self.started = ""
        self.joint_names: tuple[str, ...] = ()
        self.complete = True
        self.notes: list[str] = []
        self._parts: dict[str, list[NDArray[np.float64]]] = {}
        self._clock: list[NDArray[np.float64]] = []
        self._shifted = False
        self._count = 0
        self._end = 0.0

    def samples(self) -> Samples:
        """Return the samples; the parts are given up column by column, to need little memory."""
        if not self._parts:
            return no_samples(len(self.joint_names))
        return Samples(*(np.concatenate(self._parts.pop(name)) for name in COLUMNS))

    def clock(self) -> NDArray[np.float64] | None:
        """Return the robot's own times, if they are others than the samples'."""
        return np.concatenate(self._clock) if self._shifted and self._clock else None

    def add_segment(self, file: Path) -> None:
        """Add one file."""
        part = Segment(file)
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
        for name in COLUMNS if part.count else ():
            blocks = part.blocks(name)
            if name == "time":
                self._clock += blocks
                blocks = [block + shift for block in blocks] if shift else blocks
            self._parts.setdefault(name, []).extend(blocks)
        self._shifted |= shift != 0.0
        base = self._count
        self.marks += [Mark(m.action, m.name, m.index, m.start + base, m.stop + base) for m in part.marks]
        self._count += part.count
        self.decisions += [Entry(e.time + shift, e.data, e.row + base) for e in part.decisions]
        self.beliefs += [Entry(e.time + shift, e.data, e.row + base) for e in part.beliefs]
        self.measurements += [replace(m, time=m.time + shift, row=m.row + base) for m in part.measurements]
        self.observations += [replace(o, time=o.time + shift, row=o.row + base) for o in part.observations]
        self._end = max(self._end, part.last_time + shift)


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
