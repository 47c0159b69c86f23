"""What the parts of a run's page share: its story, what was made again, colours, and the truth."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from selection.reporting.analysis import Analysis
from selection.reporting.document import Picture
from selection.reporting.story import Story, as_number

UNKNOWN = "unknown"
REASONS = {
    "confident": "it was sure enough",
    "nothing worth its price": "nothing more was worth its time",
    "budget spent": "the time it was given was spent",
    "all actions failed": "every action had failed",
    "all actions used up": "nothing was left to do",
}


@dataclass(frozen=True)
class RunPage:
    """What the parts of a page share."""

    story: Story
    analyses: Mapping[int, Analysis]
    shades: Mapping[str, Mapping[str, str]]
    truth: Mapping[str, Any]
    pictures: Mapping[int, tuple[Picture, ...]]

    def true_value(self, name: str) -> float | None:
        """Return what a quantity really is [SI unit], if it was told."""
        rows = self.truth.get("properties")
        row = rows.get(name) if isinstance(rows, Mapping) else None
        return as_number(row.get("value")) if isinstance(row, Mapping) else None
