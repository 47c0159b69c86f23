"""Pictures of the scene that a run left, made small enough for a page."""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Sequence
from pathlib import Path

from selection.reporting.document import Picture
from selection.reporting.text import title_of

FOLDER = "pictures"
BEFORE = 0
MOST, MOST_A_STEP = 24, 3
WIDEST = 720  # pixels
LARGEST_FILE = 20 << 20
MOST_PIXELS = 50_000_000
QUALITY = 82
_LAST = ("done", "failed")
_NUMBER = re.compile(r"^\d+[-_ ]?")
_SPOKEN = {
    "begin": "before the start",
    "done": "afterwards",
    "failed": "after it failed",
    "tightest": "at its tightest",
    "overview": "from afar",
    "close": "close up",
    "wrist": "from the wrist",
}


def pictures_of(directory: Path, acts: Sequence[tuple[int, str]]) -> dict[int, tuple[Picture, ...]]:
    """Return a run's pictures ``pictures/NN-what.png`` by the number of their step; `BEFORE` for all others.

    A picture ``NN-action-what-camera`` belongs to a step of that action, later ones to later steps; a step ends
    with what is ``done`` or ``failed``. Unusable files are passed over, and so are more than fit on a page.

    Args:
        directory: of the run.
        acts: number and action of every step.
    """
    found: dict[int, list[Picture]] = {}
    left, ended = list(acts), False
    for path in sorted((directory / FOLDER).glob("*.png")):
        parts = _NUMBER.sub("", path.stem).split("-")
        last = len(parts) > 1 and parts[1] in _LAST
        if left and ended and not (last and parts[0] == left[0][1]):
            left.pop(0)
        ended = last
        while left and any(action == parts[0] for _, action in left) and left[0][1] != parts[0]:
            left.pop(0)
        place = left[0][0] if left and left[0][1] == parts[0] else BEFORE
        shown = found.setdefault(place, [])
        if sum(map(len, found.values())) >= MOST or len(shown) >= MOST_A_STEP:
            continue
        data = _small(path)
        if data is not None:
            said = parts[1:] if place != BEFORE and len(parts) > 1 else parts
            words = ", ".join(_SPOKEN.get(part, part) for part in said)
            shown.append(Picture(path.stem, title_of(words) or "The scene", data))
    return {place: tuple(pictures) for place, pictures in found.items()}


def _small(path: Path) -> bytes | None:
    """Return a picture as JPEG of bounded size; None if it is no picture."""
    from PIL import Image, UnidentifiedImageError

    try:
        if path.stat().st_size > LARGEST_FILE:
            return None
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            with Image.open(path, formats=["PNG"]) as picture:
                if picture.width * picture.height > MOST_PIXELS:
                    return None
                small = picture.convert("RGB")
                small.thumbnail((WIDEST, WIDEST))
                out = io.BytesIO()
                small.save(out, format="JPEG", quality=QUALITY)
                return out.getvalue()
    except (OSError, UnidentifiedImageError, ValueError, SyntaxError):
        return None
