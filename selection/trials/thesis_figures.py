"""What the thesis printed in chapter 4, as counts and letters."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Printed:
    """A cell of the thesis.

    Attributes:
        correct, weak, diverged: its C/W/D.
        source: the table.
    """

    correct: int
    weak: int
    diverged: int
    source: str

    @property
    def trials(self) -> int:
        """Number of tests."""
        return self.correct + self.weak + self.diverged

    @property
    def text(self) -> str:
        """As it stands there."""
        return f"{self.correct}/{self.weak}/{self.diverged}"


_ORDER = tuple((m, p) for m in ("proper", "noisy") for p in ("correct", "incorrect", "uniform"))
_COUNTS = {
    ("virtual", 1): ("4.1", "401 203 005 005 005 005"),
    ("virtual", 2): ("4.2", "500 500 500 500 401 500"),
    ("virtual", 3): ("4.3", "500 500 104 500 005 005"),
    ("simulation", 1): ("4.5", "300 300 300 300 300 300"),
    ("simulation", 2): ("4.6", "300 300 201 300 300 300"),
    ("simulation", 3): ("4.7", "300 300 210 300 300 300"),
}
_REAL = {1: "200 200 200", 2: "200 002 011", 3: "200 002 002"}
FIRST_4_4 = {1: "WWWWWW", 2: "WWSWWS", 3: "WWWWWS"}
"""First planned action by mode and context 1 to 6, two simulated materials."""
FIRST_4_10 = {1: "WWW", 2: "WWS", 3: "WWW"}
"""First planned action by mode and prior (correct, incorrect, uniform), the real objects."""
ACCURACY_4_11 = {1: 55.56, 2: 88.89, 3: 64.81}
"""Percent by mode, over all environments."""


def printed(environment: str, mode: int, prior: str, measurement: str = "") -> Printed:
    """Return a cell.

    Args:
        environment: ``virtual``, ``simulation`` or ``real``.
        mode: 1, 2 or 3.
        prior: ``correct``, ``incorrect`` or ``uniform``.
        measurement: ``proper`` or ``noisy``; not used for the real robot.
    """
    if environment == "real":
        text, source = _REAL[mode].split()[("correct", "incorrect", "uniform").index(prior)], "4.9"
    else:
        source, row = _COUNTS[environment, mode]
        text = row.split()[_ORDER.index((measurement, prior))]
    return Printed(int(text[0]), int(text[1]), int(text[2]), f"Table {source}")


def all_printed(mode: int) -> dict[str, tuple[int, int]]:
    """Return by environment how many tests of a mode converged, and how many there were."""
    cells = {
        env: [printed(env, mode, prior, measurement) for measurement, prior in _ORDER]
        for env in ("virtual", "simulation")
    }
    cells["real"] = [printed("real", mode, prior) for prior in ("correct", "incorrect", "uniform")]
    return {env: (sum(c.correct for c in row), sum(c.trials for c in row)) for env, row in cells.items()}
