"""Logs as text with a column a signal (CSV, TSV): one bad line costs that line, and is told by its number."""

from __future__ import annotations

from array import array
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from dynamics.arm import Arm
from dynamics.errors import InvalidInput
from estimation.readers.mapping import LogMap
from estimation.readers.signals import SHOWN, RawSignals, pick_columns, to_recording
from estimation.recording.data import Recording, Rejections

LONGEST_LINE = 65_536  # characters
MAX_COLUMNS = 4096
MAX_NUMBERS = 200_000_000  # 1.6 GB
DELIMITERS = (",", ";", "\t", " ")


def read_text(path: Path, mapping: LogMap, arm: Arm | None = None) -> Recording:
    """Return the recording of a text file; its columns go by their names in the first line, or by number from 0.

    Raises:
        InvalidInput: if it is no table of numbers, or columns are missing.
    """
    try:
        with open(path, encoding="utf-8-sig", errors="replace", newline=None) as file:
            lines = _lines(iter(lambda: file.readline(LONGEST_LINE), ""))
            raw = _read(path, lines, mapping)
    except OSError as error:
        raise InvalidInput(f"{path}", error.strerror or str(error), "a text file") from None
    return to_recording(path, raw, mapping, arm)


def _lines(lines: Iterator[str]) -> Iterator[tuple[int, str]]:
    """Yield the lines that hold something, with their numbers from 1."""
    for number, line in enumerate(lines, 1):
        text = line.strip("\r\n")
        if text.strip() and not text.lstrip().startswith("#"):
            yield number, text


def _read(path: Path, lines: Iterator[tuple[int, str]], mapping: LogMap) -> RawSignals:
    first = next(lines, None)
    if first is None:
        raise InvalidInput(f"{path}", "no lines", "a table of numbers")
    delimiter = mapping.delimiter or max(DELIMITERS, key=lambda one: (first[1].count(one), one == ","))
    cells = _split(first[1], delimiter)
    headed = not all(_is_number(cell) for cell in cells)
    if len(cells) > MAX_COLUMNS:
        raise InvalidInput(f"{path}", f"{len(cells)} columns", f"{MAX_COLUMNS} at most")
    names = _distinct(cells) if headed else [str(n) for n in range(len(cells))]
    mapping = mapping.named(names, f"{path}")
    phase = mapping.column("phase")
    label_at = names.index(phase) if isinstance(phase, str) and phase in names else -1
    wanted = [n for n, name in enumerate(names) if n != label_at and mapping.wants(name)]
    numbers, places = array("d"), array("q")
    labels: list[str] = []
    rejected = 0
    reasons: list[str] = []

    def reject(number: int, why: str) -> None:
        nonlocal rejected
        rejected += 1
        if len(reasons) < SHOWN:
            reasons.append(f"line {number}: {why}")

    rows = lines if headed else _again(first, lines)
    for number, line in rows:
        parts = _split(line, delimiter)
        if len(parts) != len(names):
            reject(number, f"{len(parts)} columns instead of {len(names)}")
            continue
        try:
            row = [float(parts[n]) for n in wanted]
        except ValueError:
            reject(number, "a cell that is no number")
            continue
        if len(numbers) > MAX_NUMBERS:
            raise InvalidInput(f"{path}", "more rows than fit in memory", f"{MAX_NUMBERS} numbers at most")
        numbers.extend(row)
        places.append(number)
        if label_at >= 0:
            labels.append(parts[label_at])
    table = np.frombuffer(numbers).reshape(len(places), -1) if numbers else np.empty((len(places), len(wanted)))
    columns = {names[n]: table[:, at] for at, n in enumerate(wanted)}
    return RawSignals(
        pick_columns(path, columns, mapping, names),
        labels=labels if label_at >= 0 else None,
        places=np.array(places, np.int64),
        rejections=Rejections(rejected, tuple(reasons)),
    )


def _again(first: tuple[int, str], rest: Iterator[tuple[int, str]]) -> Iterator[tuple[int, str]]:
    yield first
    yield from rest


def _split(line: str, delimiter: str) -> list[str]:
    cells = line.split() if delimiter == " " else line.split(delimiter)
    return [cell.strip().strip('"') for cell in cells]


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _distinct(names: list[str]) -> list[str]:
    """Return names of columns of which none stands twice: the later ones bear their number."""
    seen: set[str] = set()
    distinct = []
    for n, name in enumerate(names):
        distinct.append(f"{name} (column {n})" if name in seen else name)
        seen.add(name)
    return distinct
