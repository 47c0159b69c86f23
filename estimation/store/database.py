"""An SQLite index of the run directories in one folder; it can be deleted and is made anew from the runs."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from dynamics.errors import InvalidInput, PalpateError, UnknownName
from estimation.ipalm import MeasuredObject
from estimation.measurement import Measurement
from estimation.recording import CannotRecord, Recording, read_recording

INDEX = "store.sqlite"
VERSION = 1

_TABLES = """
CREATE TABLE IF NOT EXISTS run (
    name TEXT PRIMARY KEY, stamp TEXT NOT NULL, object TEXT NOT NULL, started TEXT NOT NULL, seconds REAL,
    state TEXT NOT NULL, material TEXT, probability REAL, config TEXT NOT NULL, problem TEXT NOT NULL
);
CREATE TABLE IF NOT EXISTS measurement (
    run TEXT NOT NULL REFERENCES run(name) ON DELETE CASCADE, number INTEGER NOT NULL, source TEXT NOT NULL,
    object TEXT NOT NULL, time REAL NOT NULL, action TEXT NOT NULL,
    property TEXT NOT NULL, mean REAL NOT NULL, sd REAL NOT NULL, unit TEXT NOT NULL,
    PRIMARY KEY (run, number, source)
);
"""


@dataclass(frozen=True)
class Run:
    """A run in the index.

    Attributes:
        name: of its directory, relative to the folder.
        object_name: what was explored.
        started: when, in universal time.
        seconds: how long the robot took, if known [s].
        state: ``finished``, ``interrupted``, or ``unreadable``.
        material, probability: what it most probably is, if the run came to a result.
        config: what it was asked for.
        problem: why it is unreadable, or what is missing.
    """

    name: str
    object_name: str
    started: str
    seconds: float | None
    state: str
    material: str | None
    probability: float | None
    config: Mapping[str, Any]
    problem: str


@dataclass(frozen=True)
class Found:
    """A measurement in the index: the run, the object, when [s], by which action, and its value."""

    run: str
    object_name: str
    time: float
    action: str
    measurement: Measurement


class Store:
    """The index of a folder of runs.

    Args:
        folder: holds the run directories; the index is kept in it.

    Raises:
        InvalidInput: if the folder is missing, or its index is no index.
        CannotRecord: if the index can not be written.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = Path(folder)
        if not self.folder.is_dir():
            raise InvalidInput("store", str(folder), "an existing folder of runs")
        self._path = self.folder / INDEX
        with self._errors():
            self._database = sqlite3.connect(self._path, timeout=30)
            self._database.execute("PRAGMA journal_mode=WAL")
            self._database.execute("PRAGMA foreign_keys=ON")
            (found,) = self._database.execute("PRAGMA user_version").fetchone()
            if found not in (0, VERSION):
                raise InvalidInput(
                    f"store {self._path}: version", found, f"{VERSION}; delete the file to rebuild it"
                )
            self._database.executescript(_TABLES)
            self._database.execute(f"PRAGMA user_version={VERSION}")

    def close(self) -> None:
        """Close the index."""
        self._database.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def refresh(self) -> int:
        """Take in runs that are new or have changed, and forget those that are gone; return how many changed."""
        with self._errors():
            known = dict(self._database.execute("SELECT name, stamp FROM run").fetchall())
        present = {str(path.parent.relative_to(self.folder)): path.parent for path in self._run_files()}
        changed = 0
        for name, directory in present.items():
            stamp = _stamp(directory)
            if known.get(name) != stamp:
                self._index(name, directory, stamp)
                changed += 1
        gone = set(known) - set(present)
        with self._errors(), self._database:
            self._database.executemany("DELETE FROM run WHERE name = ?", [(name,) for name in gone])
        return changed + len(gone)

    def runs(self, text: str = "", object_name: str = "", since: str = "") -> tuple[Run, ...]:
        """Return runs, oldest first.

        Args:
            text: to be found in name, object, material or configuration, whatever the case.
            object_name: exactly this object.
            since: begun at this time or later, such as ``2026-11``.
        """
        query = (
            "SELECT name, object, started, seconds, state, material, probability, config, problem FROM run "
            "WHERE (?1 = '' OR object = ?1) AND started >= ?2 AND (?3 = '' OR "
            "instr(lower(name || ' ' || object || ' ' || ifnull(material, '') || ' ' || config), lower(?3)) > 0) "
            "ORDER BY started, name"
        )
        with self._errors():
            rows = self._database.execute(query, (object_name, since, text)).fetchall()
        return tuple(_run(*row) for row in rows)

    def run(self, name: str) -> Run:
        """Return one run.

        Raises:
            UnknownName: if there is no such run.
        """
        runs = {one.name: one for one in self.runs()}
        if name not in runs:
            raise UnknownName(f"store {self.folder}: run", name, list(runs)[-20:])
        return runs[name]

    def measurements(self, runs: Sequence[str] | None = None, property_name: str = "") -> tuple[Found, ...]:
        """Return measurements, in order of their runs and times.

        Args:
            runs: of these runs; None for all.
            property_name: of this property only.
        """
        query = (
            "SELECT m.run, m.object, m.time, m.action, m.property, m.mean, m.sd, m.unit FROM measurement m "
            "JOIN run r ON r.name = m.run WHERE ?1 = '' OR m.property = ?1 ORDER BY r.started, m.run, m.number"
        )
        with self._errors():
            rows = self._database.execute(query, (property_name,)).fetchall()
        wanted = None if runs is None else set(runs)
        return tuple(_found(*row) for row in rows if wanted is None or row[0] in wanted)

    def objects(self, runs: Sequence[str] | None = None) -> tuple[MeasuredObject, ...]:
        """Return what was measured of every object, for a measurement list."""
        grouped: dict[str, list[Measurement]] = {}
        for found in self.measurements(runs):
            grouped.setdefault(found.object_name, []).append(found.measurement)
        return tuple(MeasuredObject(name, None, tuple(values)) for name, values in grouped.items())

    def _run_files(self) -> list[Path]:
        return sorted(path for path in self.folder.glob("*/run.mcap") if path.is_file())

    def _index(self, name: str, directory: Path, stamp: str) -> None:
        try:
            recording = read_recording(directory)
            problem = "; ".join(recording.notes)
        except PalpateError as error:
            recording, problem = None, str(error)
        result = _result(directory)
        row = _row(name, stamp, recording, result, problem)
        with self._errors(), self._database:
            self._database.execute("DELETE FROM run WHERE name = ?", (name,))
            self._database.execute(f"INSERT INTO run VALUES ({', '.join('?' * len(row))})", row)
            for number, one in enumerate(recording.measurements if recording else (), 1):
                m = one.measurement
                values = (name, number, "run", row[2], one.time, one.action, m.property, m.mean, m.sd, m.unit)
                self._database.execute(f"INSERT INTO measurement VALUES ({', '.join('?' * len(values))})", values)

    @contextmanager
    def _errors(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.OperationalError as error:
            raise CannotRecord(f"store {self._path}: {error}") from error
        except sqlite3.DatabaseError as error:
            raise InvalidInput(
                f"store {self._path}", str(error), "an index of Palpate; delete it to rebuild it"
            ) from None


def _row(
    name: str, stamp: str, recording: Recording | None, result: Mapping[str, Any], problem: str
) -> tuple[Any, ...]:
    materials = result.get("belief", {}).get("material", {}) if isinstance(result.get("belief"), Mapping) else {}
    best = max(materials, key=lambda material: float(materials[material])) if materials else None
    seconds = result.get("seconds")
    if recording is None:
        return name, stamp, "", "", None, "unreadable", None, None, "{}", problem
    if seconds is None and len(recording.samples):
        seconds = float(recording.samples.time[-1] - recording.samples.time[0])
    return (
        name,
        stamp,
        recording.object_name,
        recording.started,
        seconds,
        "finished" if result else "interrupted",
        best,
        None if best is None else float(materials[best]),
        json.dumps(recording.config, default=str),
        problem,
    )


def _result(directory: Path) -> Mapping[str, Any]:
    try:
        result = json.loads((directory / "result.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return result if isinstance(result, Mapping) else {}


def _stamp(directory: Path) -> str:
    """Return what changes when a run does: sizes and times of its files."""
    files = sorted([*directory.glob("run*.mcap"), directory / "result.json"])
    return ";".join(f"{f.name}:{f.stat().st_size}:{f.stat().st_mtime_ns}" for f in files if f.exists())


def _run(*row: Any) -> Run:
    *known, config, problem = row
    name, object_name, started, seconds, state, material, probability = known
    return Run(name, object_name, started, seconds, state, material, probability, json.loads(config), problem)


def _found(*row: Any) -> Found:
    run, object_name, time, action, *value = row
    name, mean, sd, unit = value
    return Found(run, object_name, time, action, Measurement(name, mean, sd, unit))
