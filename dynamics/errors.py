"""What can go wrong, told to people: each error says what was found, where, and what is valid."""

from __future__ import annotations

from collections.abc import Iterable


class PalpateError(Exception):
    """Base class of every error that Palpate raises on purpose."""


class InvalidInput(PalpateError):
    """A value from outside is unusable.

    Attributes:
        where: the place the value came from, such as ``file.toml: mass``.
        found: what was found there.
        valid: what would have been valid.
    """

    def __init__(self, where: str, found: object, valid: str) -> None:
        self.where, self.found, self.valid = where, found, valid
        super().__init__(f"{where}: found {_short(found)}; valid: {valid}")


class UnknownName(InvalidInput):
    """A name is not among the known ones.

    Attributes:
        known: the valid names.
    """

    def __init__(self, where: str, found: object, known: Iterable[str]) -> None:
        self.known = tuple(known)
        super().__init__(where, found, ", ".join(self.known) or "none (there are no names here)")


class NoRobot(PalpateError):
    """A robot could not be opened: it is not there, does not let one in, or is another one."""


class MotionRefused(PalpateError):
    """A motion is impossible or unsafe and was refused before anything moved."""


class ActionFailed(PalpateError):
    """An action could not be completed on the object; the exploration can go on.

    Attributes:
        reason: a short name for the cause, such as ``dropped`` or ``slipped``.
    """

    def __init__(self, reason: str, message: str) -> None:
        self.reason = reason
        super().__init__(f"{reason}: {message}")


def _short(value: object, limit: int = 120) -> str:
    """Return the representation of a value on one line of bounded length."""
    text = " ".join(repr(value).split())
    return text if len(text) <= limit else text[: limit - 3] + "..."
