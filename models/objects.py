"""Find the object files: what is known of an object, and for the simulator what it really is."""

from __future__ import annotations

import tomllib
from pathlib import Path

FOLDER = Path(__file__).parent / "objects"


def names() -> tuple[str, ...]:
    """List the names of the shipped object files, in alphabetical order."""
    return tuple(sorted(path.stem for path in FOLDER.glob("*.toml")))


def locate(path_or_name: str | Path) -> Path:
    """Return the path that a shipped name or a path means.

    Raises:
        KeyError: if it is neither a shipped name nor looks like a path.
    """
    text = str(path_or_name)
    if text in names():
        return FOLDER / f"{text}.toml"
    if isinstance(path_or_name, Path) or text.endswith(".toml") or "/" in text:
        return Path(path_or_name)
    raise KeyError(text)


def about(name: str) -> str:
    """Return the line that a shipped object file says of itself."""
    text = tomllib.loads((FOLDER / f"{name}.toml").read_text(encoding="utf-8")).get("about", "")
    return str(text)
