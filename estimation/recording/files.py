"""Whole files or none: text that is written atomically, JSON and TOML as runs keep them."""

from __future__ import annotations

import json
import math
import os
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from dynamics.errors import InvalidInput, PalpateError

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
_ESCAPES = {"\\": "\\\\", '"': '\\"', "\n": "\\n", "\t": "\\t", "\r": "\\r", "\b": "\\b", "\f": "\\f"}


class CannotRecord(PalpateError):
    """What happens can not be kept on disk, so nothing more may happen."""


def write_atomically(path: Path, text: str) -> None:
    """Write a text file so that a crash leaves either the old file or the new one.

    The text goes to a temporary file beside it, which is synchronised and then renamed.

    Raises:
        CannotRecord: if the disk is full, the folder read-only, or the like.
    """
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        with open(temporary, "w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
        sync_folder(path.parent)
    except OSError as error:
        temporary.unlink(missing_ok=True)
        raise CannotRecord(f"{path}: {error.strerror or error}; nothing was written there") from error


def sync_folder(folder: Path) -> None:
    """Make the names in a folder as lasting as the files they name."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def to_json(where: str, data: Any, indent: int | None = None) -> str:
    """Return data as strict JSON; numpy's numbers and arrays become plain ones.

    Raises:
        InvalidInput: for a number that is not finite, or a value that JSON has no form for.
    """
    try:
        return json.dumps(plain(data), indent=indent, allow_nan=False, ensure_ascii=False)
    except (ValueError, TypeError, RecursionError) as error:
        raise InvalidInput(where, str(error), "finite numbers, text, lists and mappings with text keys") from None


def plain(data: Any) -> Any:
    """Return data built of Python's own mappings, lists, text and numbers."""
    if isinstance(data, Mapping):
        return {_key(key): plain(value) for key, value in data.items()}
    if isinstance(data, np.ndarray):
        return data.tolist()
    if isinstance(data, np.generic):
        return data.item()
    if isinstance(data, str | bool | int | float | None):
        return data
    if isinstance(data, Path):
        return str(data)
    if isinstance(data, Sequence | set | frozenset):
        return [plain(value) for value in (sorted(data) if isinstance(data, set | frozenset) else data)]
    raise TypeError(f"{type(data).__name__} has no JSON form")


def to_toml(where: str, data: Mapping[str, Any]) -> str:
    """Return a mapping as TOML; keys without a value (None) are left out.

    Raises:
        InvalidInput: for a value that TOML has no form for.
    """
    try:
        lines = _table(plain(data), ())
    except TypeError as error:
        raise InvalidInput(where, str(error), "text, numbers, lists and mappings with text keys") from None
    return "\n".join(lines).strip("\n") + "\n" if lines else ""


def _key(key: object) -> str:
    if not isinstance(key, str):
        raise TypeError(f"the key {key!r} is no text")
    return key


def _table(table: Mapping[str, Any], path: tuple[str, ...]) -> list[str]:
    values = [
        f"{_name(key)} = {_value(item)}" for key, item in table.items() if not isinstance(item, Mapping | None)
    ]
    lines = [f"[{'.'.join(map(_name, path))}]", *values, ""] if path else [*values, ""]
    for key, item in table.items():
        if isinstance(item, Mapping):
            lines += _table(item, (*path, key))
    return lines


def _name(key: str) -> str:
    return key if _BARE_KEY.fullmatch(key) else _text(key)


def _value(item: Any) -> str:
    if isinstance(item, bool):
        return "true" if item else "false"
    if isinstance(item, str):
        return _text(item)
    if isinstance(item, float) and not math.isfinite(item):
        return "nan" if math.isnan(item) else ("inf" if item > 0 else "-inf")
    if isinstance(item, int | float):
        return repr(item)
    if isinstance(item, Mapping):
        pairs = (f"{_name(key)} = {_value(value)}" for key, value in item.items() if value is not None)
        return "{" + ", ".join(pairs) + "}"
    if isinstance(item, list):
        return "[" + ", ".join(_value(value) for value in item if value is not None) + "]"
    raise TypeError(f"{type(item).__name__} has no TOML form")


def _text(text: str) -> str:
    return '"' + "".join(_ESCAPES.get(c, c if c.isprintable() else f"\\U{ord(c):08X}") for c in text) + '"'
