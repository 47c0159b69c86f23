"""One look for every figure: sheets with axes placed in inches, written as SVG whose colours a page can change."""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any
from xml.etree import ElementTree

from selection.reporting.document import Figure
from selection.reporting.palette import LIGHT

WIDTH = 5.0  # inches, 360 units: a phone's width, so that letters stay as large as the text around
SIZE, SMALL = 10.5, 9.5  # points
_SVG = "{http://www.w3.org/2000/svg}"
_LINK = "{http://www.w3.org/1999/xlink}href"
_FAMILY = re.compile(r"font-family: [^;]*")
_FONT = re.compile(r"font: ((?:\w+ )*)([\d.]+px) [^;]*")
_NUMBER = re.compile(r"-?\d+\.\d{3,}(?:e-?\d+)?")
_TARGET = re.compile(r"url\(#([^)]+)\)")


def look() -> dict[str, Any]:
    """Return matplotlib's settings for figures of this house, to be used in `matplotlib.rc_context`."""
    from cycler import cycler

    ink, soft, line = LIGHT["ink"], LIGHT["soft"], LIGHT["line"]
    return {
        "axes.axisbelow": True,
        "axes.edgecolor": soft,
        "axes.facecolor": "none",
        "axes.grid": False,
        "axes.labelcolor": soft,
        "axes.labelsize": SIZE,
        "axes.linewidth": 0.8,
        "axes.prop_cycle": cycler(color=[LIGHT[f"c{i}"] for i in range(1, 7)]),
        "axes.spines.right": False,
        "axes.spines.top": False,
        "axes.unicode_minus": True,
        "figure.facecolor": "none",
        "savefig.facecolor": "none",
        "font.family": ["DejaVu Sans"],
        "font.size": SIZE,
        "grid.color": line,
        "grid.linewidth": 0.8,
        "legend.fontsize": SMALL,
        "legend.frameon": False,
        "legend.handlelength": 1.2,
        "legend.labelcolor": ink,
        "lines.linewidth": 1.6,
        "lines.solid_capstyle": "round",
        "path.simplify": True,
        "path.simplify_threshold": 0.3,
        "svg.fonttype": "none",
        "svg.hashsalt": "palpate",
        "text.color": ink,
        "text.parse_math": False,
        "xtick.color": soft,
        "ytick.color": soft,
        "xtick.labelsize": SMALL,
        "ytick.labelsize": SMALL,
        "xtick.major.size": 3.0,
        "ytick.major.size": 3.0,
        "xtick.major.width": 0.8,
        "ytick.major.width": 0.8,
        "xtick.minor.size": 0.0,
        "ytick.minor.size": 0.0,
    }


class Sheet:
    """A figure to be drawn on.

    Args:
        height: of the sheet [inches].
        width: of the sheet [inches].

    Attributes:
        figure: matplotlib's.
    """

    def __init__(self, height: float, width: float = WIDTH) -> None:
        from matplotlib.figure import Figure as Canvas

        self.height, self.width = height, width
        self.figure = Canvas(figsize=(width, height))

    def axes(
        self, left: float = 0.0, bottom: float = 0.0, right: float = 0.0, top: float = 0.0, **options: Any
    ) -> Any:
        """Return axes with these margins to the sheet's edges [inches]."""
        w, h = self.width, self.height
        box = (left / w, bottom / h, max(w - left - right, 0.1) / w, max(h - bottom - top, 0.1) / h)
        return self.figure.add_axes(box, **options)

    def finish(self, name: str, title: str, caption: str, alt: str, wide: bool = False) -> Figure:
        """Return what was drawn as a figure of a page."""
        out = io.StringIO()
        self.figure.savefig(out, format="svg", metadata={"Date": None, "Creator": None})
        file, inline = _both(out.getvalue(), name)
        return Figure(name, title, caption, alt, file, inline, wide)


@contextmanager
def drawing() -> Iterator[None]:
    """Draw with the look of this house; letters that the measuring font lacks are drawn by the reader's fonts."""
    import matplotlib

    with matplotlib.rc_context(look()), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing from", category=UserWarning)
        yield


def only_horizontal_grid(axes: Any) -> None:
    """Leave a grid of levels, and no line at the side."""
    axes.grid(True, axis="y")
    axes.spines["left"].set_visible(False)
    axes.tick_params(axis="y", length=0)


def bare(axes: Any) -> None:
    """Leave neither frame nor ticks."""
    for spine in axes.spines.values():
        spine.set_visible(False)
    axes.set_xticks([])
    axes.set_yticks([])


def _both(text: str, name: str) -> tuple[str, str]:
    """Return a drawing as a file of its own, and as an element of a page with variables for its colours."""
    for prefix, address in (("", _SVG[1:-1]), ("xlink", _LINK[1:].split("}")[0])):
        ElementTree.register_namespace(prefix, address)
    root = ElementTree.fromstring(text)
    for child in list(root):
        if child.tag.endswith("metadata"):
            root.remove(child)
    _tidy(root, name)
    plate = ElementTree.Element(_SVG + "rect", {"width": "100%", "height": "100%", "fill": LIGHT["page"]})
    root.insert(0, plate)
    file = '<?xml version="1.0" encoding="utf-8"?>\n' + _serialised(root) + "\n"
    root.remove(plate)
    for key in ("width", "height", "version"):
        root.attrib.pop(key, None)
    inline = _serialised(root)
    inline = re.sub(r' xmlns(?::\w+)?="[^"]*"', "", inline).replace("xlink:href", "href")
    return file, _coloured(inline)


def _tidy(root: ElementTree.Element, name: str) -> None:
    """Leave only the identifiers that are referred to, made unique by the figure's name; shorten styles."""
    used = set()
    for element in root.iter():
        for key, value in element.attrib.items():
            used.update(_TARGET.findall(value))
            if key == _LINK:
                used.add(value[1:])
    for parent in root.iter():
        parent[:] = [child for child in parent if child.tag != _SVG + "style"]
    for element in root.iter():
        found = element.attrib.pop("id", None)
        if found in used:
            element.set("id", f"{name}-{found}")
        if _LINK in element.attrib:
            element.set(_LINK, f"#{name}-{element.attrib[_LINK][1:]}")
        for key, value in list(element.attrib.items()):
            if "url(#" in value:
                element.set(key, _TARGET.sub(rf"url(#{name}-\1)", value))
        style = element.get("style")
        if style is not None and element.tag == _SVG + "text":
            style = _FAMILY.sub("font-family: sans-serif", style)
            element.set("style", _FONT.sub(r"font: \1\2 sans-serif", style))
        if element.get("d"):
            path = _NUMBER.sub(lambda m: f"{float(m[0]):.2f}".rstrip("0").rstrip("."), element.get("d", ""))
            element.set("d", " ".join(path.split()))
    root.set("style", "stroke-linejoin: round; stroke-linecap: butt")


def _serialised(root: ElementTree.Element) -> str:
    for element in root.iter():
        if element.tag != _SVG + "text" and not (element.text or "").strip():
            element.text = None
        element.tail = None if not (element.tail or "").strip() else element.tail
    return ElementTree.tostring(root, encoding="unicode")


@cache
def _names() -> dict[str, str]:
    return {colour: name for name, colour in LIGHT.items()}


def _coloured(text: str) -> str:
    names = _names()
    text = re.sub(r"font-family: sans-serif;? ?", "", text)
    text = re.sub(r"#[0-9a-f]{6}\b", lambda m: f"var(--{names[m[0]]})" if m[0] in names else m[0], text)
    return re.sub(r"font: ((?:\w+ )*)([\d.]+px) sans-serif", _unfamilied, text)


def _unfamilied(match: re.Match[str]) -> str:
    bold = "font-weight: 700; " if "bold" in match[1] else ""
    slant = "font-style: italic; " if "italic" in match[1] else ""
    return f"{bold}{slant}font-size: {match[2]}"
