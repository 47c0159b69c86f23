"""Pictures of the scene that a run left, made small enough for a page."""

from __future__ import annotations

import io
import re
import warnings
from pathlib import Path

from selection.reporting.document import Picture
from selection.reporting.text import title_of

FOLDER = "pictures"
MOST = 24
WIDEST = 900  # pixels
LARGEST_FILE = 20 << 20
MOST_PIXELS = 50_000_000
QUALITY = 82


def pictures_of(directory: Path) -> tuple[Picture, ...]:
    """Return the pictures ``pictures/NN-what.png`` of a run in their order; unusable files are passed over."""
    found = []
    for path in sorted((directory / FOLDER).glob("*.png"))[:MOST]:
        data = _small(path)
        if data is not None:
            found.append(Picture(path.stem, _caption(path.stem), data))
    return tuple(found)


def _caption(stem: str) -> str:
    return title_of(re.sub(r"^\d+[-_ ]?", "", stem).replace("-", " ").replace("_", " ")) or "The scene"


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
