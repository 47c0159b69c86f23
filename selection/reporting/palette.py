"""The colours of every figure and page: a light and a dark set under the same names.

The six hues of materials were searched for the largest least difference (OKLab) between any two of them, as
seen with full colour vision and without red, green or blue receptors (Machado, Oliveira and Fernandes, IEEE
TVCG 15(6), 2009), at a contrast of at least 3 with the page.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

LIGHT = {
    "page": "#fbfbf9",
    "ink": "#1b2028",
    "soft": "#5a626f",
    "line": "#dcdee2",
    "muted": "#9aa1ac",
    "accent": "#1d6f82",
    "pale": "#b9d4da",
    "alarm": "#b3261e",
    "c1": "#4a64d5",
    "c2": "#a1552a",
    "c3": "#07503a",
    "c4": "#822a78",
    "c5": "#ae8931",
    "c6": "#806fa1",
}
DARK = {
    "page": "#14171c",
    "ink": "#e6e8ec",
    "soft": "#a3abb8",
    "line": "#2f353e",
    "muted": "#6d7683",
    "accent": "#5cb8cc",
    "pale": "#27505b",
    "alarm": "#ff8a80",
    "c1": "#5078f0",
    "c2": "#e98427",
    "c3": "#99deb5",
    "c4": "#b8649f",
    "c5": "#e5d043",
    "c6": "#a593f0",
}
SERIES = ("c1", "c2", "c3", "c4", "c5", "c6")
REST = "muted"


def colours(names: Iterable[str]) -> dict[str, str]:
    """Return a colour for each name in order of importance; from the seventh on all are of the same grey."""
    return {name: LIGHT[SERIES[i]] if i < len(SERIES) else LIGHT[REST] for i, name in enumerate(names)}


def variables(theme: Mapping[str, str]) -> str:
    """Return a set of colours as declarations of CSS variables."""
    return "".join(f"--{name}:{colour};" for name, colour in theme.items())
