"""Read tables of files from outside: every key known, every number finite and in range, or a plain error."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from dynamics.errors import InvalidInput

MAX_BYTES = 1_000_000
_LARGEST = 1e300  # nothing physical is larger; integers may be too large for a float


def read_toml(path: Path) -> dict[str, Any]:
    """Return the tables of a TOML file.

    Raises:
        InvalidInput: if it is missing, too large, not text or not TOML.
    """
    try:
        with path.open("rb") as file:
            content = file.read(MAX_BYTES + 1)  # bounded also for what has no size, such as a device
        if len(content) > MAX_BYTES:
            raise InvalidInput(str(path), f"more than {MAX_BYTES} bytes", f"a TOML file of at most {MAX_BYTES}")
        return tomllib.loads(content.decode("utf-8"))
    except OSError as error:
        raise InvalidInput(str(path), error.strerror or str(error), "a readable TOML file") from None
    except (ValueError, RecursionError) as error:  # not TOML, not text, a number or a nesting without end
        raise InvalidInput(str(path), str(error), "a TOML file") from None


class Table:
    """One table of a file, read key by key; `done` refuses what was not asked for.

    Args:
        where: file and table, for messages.
        content: what was parsed.
    """

    def __init__(self, where: str, content: object) -> None:
        if not isinstance(content, Mapping):
            raise InvalidInput(where, content, "a table")
        self.where = where
        self._content: Mapping[str, Any] = content
        self._asked: set[str] = set()

    def number(
        self,
        key: str,
        default: float | None = None,
        at_least: float = -math.inf,
        above: float = -math.inf,
        at_most: float = math.inf,
        unit: str = "",
    ) -> float:
        """Return a finite number within bounds; a missing key gives the default, or an error without one."""
        value = self._get(key, default)
        return self._checked(key, value, at_least, above, at_most, unit)

    def numbers(
        self,
        key: str,
        count: int,
        default: tuple[float, ...] | None = None,
        at_least: float = -math.inf,
        above: float = -math.inf,
        at_most: float = math.inf,
        unit: str = "",
    ) -> tuple[float, ...]:
        """Return a list of so many finite numbers within bounds."""
        values = self._get(key, default)
        if not isinstance(values, list | tuple) or len(values) != count:
            raise InvalidInput(f"{self.where}: {key}", values, f"a list of {count} numbers{_in(unit)}")
        return tuple(self._checked(key, value, at_least, above, at_most, unit) for value in values)

    def text(self, key: str, default: str | None = None, choices: tuple[str, ...] | None = None) -> str:
        """Return a string, one of the choices if there are any."""
        value = self._get(key, default)
        if not isinstance(value, str) or (choices is not None and value not in choices):
            raise InvalidInput(f"{self.where}: {key}", value, ", ".join(choices) if choices else "a text")
        return value

    def table(self, key: str) -> Table:
        """Return a table within this one."""
        self._asked.add(key)
        if key not in self._content:
            raise InvalidInput(self.where, f"no table [{key}]", f"a table [{key}]")
        return Table(f"{self.where} [{key}]", self._content[key])

    def content(self, key: str) -> object:
        """Return what stands at a key, unchecked; None if nothing does."""
        self._asked.add(key)
        return self._content.get(key)

    def has(self, key: str) -> bool:
        """Tell whether a key is there."""
        self._asked.add(key)
        return key in self._content

    def done(self) -> None:
        """Refuse keys that nobody asked for.

        Raises:
            InvalidInput: naming the first of them and the known ones.
        """
        unknown = sorted(set(self._content) - self._asked)
        if unknown:
            raise InvalidInput(self.where, f"unknown key {unknown[0]}", ", ".join(sorted(self._asked)))

    def _get(self, key: str, default: object) -> object:
        self._asked.add(key)
        if key in self._content:
            return self._content[key]
        if default is None:
            raise InvalidInput(self.where, f"no {key}", f"a value for {key}")
        return default

    def _checked(self, key: str, value: object, at_least: float, above: float, at_most: float, unit: str) -> float:
        if isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < _LARGEST:
            number = float(value)
            if at_least <= number <= at_most and number > above:
                return number
        bounds = [
            f"> {above:g}" if math.isfinite(above) else "",
            f">= {at_least:g}" if math.isfinite(at_least) else "",
            f"<= {at_most:g}" if math.isfinite(at_most) else "",
        ]
        valid = " and ".join(bound for bound in bounds if bound) or "finite"
        raise InvalidInput(f"{self.where}: {key}", value, f"a number {valid}{_in(unit)}")


def _in(unit: str) -> str:
    return f" [{unit}]" if unit else ""
