"""Find the reference files: what is known beforehand about materials, categories and their properties."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).parent / "references"
MAX_BYTES = 10_000_000


def names() -> tuple[str, ...]:
    """List the names of the shipped reference files, in alphabetical order."""
    return tuple(sorted(path.stem for path in FOLDER.glob("*.json")))


def path(name: str) -> Path:
    """Return the path of a shipped reference file.

    Args:
        name: a name listed by `names`.

    Raises:
        KeyError: if there is no such file.
    """
    found = FOLDER / f"{name}.json"
    if name not in names():
        raise KeyError(f"no reference called {name!r}; there are: {', '.join(names())}")
    return found


def raw(path_or_name: str | Path) -> dict[str, Any]:
    """Read a reference file as it stands, unchecked.

    Args:
        path_or_name: the name of a shipped reference, or the path of any file.

    Raises:
        KeyError: if it is neither a shipped name nor looks like a path.
        FileNotFoundError: if the path leads nowhere.
        ValueError: if the file is not a JSON object.
    """
    source = locate(path_or_name)
    with source.open("rb") as file:  # a device file would never end
        head = file.read(MAX_BYTES + 1)
    if len(head) > MAX_BYTES:
        raise ValueError(f"{source}: a reference file holds at most {MAX_BYTES} bytes")
    content = json.loads(head.decode("utf-8"))
    if not isinstance(content, dict):
        raise ValueError(f"{source}: a reference file holds one JSON object")
    return content


def locate(path_or_name: str | Path) -> Path:
    """Return the path that a shipped name or a path means.

    Raises:
        KeyError: if it is neither a shipped name nor looks like a path.
    """
    text = str(path_or_name)
    if text in names():
        return path(text)
    if isinstance(path_or_name, Path) or text.endswith(".json") or "/" in text:
        return Path(path_or_name)
    return path(text)
