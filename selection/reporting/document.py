"""A page built of sections, paragraphs, tables and figures."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from selection.trials.result_tables import ResultTable


@dataclass(frozen=True)
class Strong:
    """Words that matter in a paragraph."""

    text: str


Words = str | Strong


@dataclass(frozen=True)
class Paragraph:
    """A paragraph.

    Attributes:
        words: its parts.
        kind: a class of the style sheet, such as ``lead`` or ``note``.
    """

    words: tuple[Words, ...]
    kind: str = ""


@dataclass(frozen=True)
class Fact:
    """A figure that heads a page: ``94.8 %``, of what, and a remark."""

    value: str
    label: str
    remark: str = ""


@dataclass(frozen=True)
class Facts:
    """A row of them."""

    facts: tuple[Fact, ...]


@dataclass(frozen=True)
class Figure:
    """A drawing.

    Attributes:
        name: fit for a file name.
        title: what it shows, in a few words.
        caption: how to read it; may be empty.
        alt: what a person who cannot see it should know.
        svg: the drawing as a file of its own.
        inline: the drawing for the page, its colours given by variables.
        wide: whether it takes the width of two.
    """

    name: str
    title: str
    caption: str
    alt: str
    svg: str
    inline: str
    wide: bool = False


@dataclass(frozen=True)
class Picture:
    """A picture of the scene, as a JPEG file's bytes."""

    name: str
    caption: str
    jpeg: bytes


@dataclass(frozen=True)
class Table:
    """A table.

    Attributes:
        result: its values in full, written as CSV.
        texts: its cells as they are read; the values' own texts if None.
        columns: headings as they are read; the values' own if None.
        quiet: without a title on the page.
        pairs: whether its cells may be long, for settings and their values.
    """

    result: ResultTable
    texts: tuple[tuple[str, ...], ...] | None = None
    columns: tuple[str, ...] | None = None
    quiet: bool = False
    pairs: bool = False


@dataclass(frozen=True)
class Code:
    """Text that is shown as it stands in a file."""

    text: str


@dataclass(frozen=True)
class Gallery:
    """Figures, pictures and tables side by side where there is room.

    Attributes:
        blocks: what is shown.
        kind: a class of the style sheet besides, such as ``pictures``.
    """

    blocks: tuple[Block, ...]
    kind: str = ""


@dataclass(frozen=True)
class Folded:
    """Blocks that are opened on demand, and always open on paper."""

    summary: str
    blocks: tuple[Block, ...]


@dataclass(frozen=True)
class Section:
    """A headed part.

    Attributes:
        title: its heading.
        blocks: its content.
        label: a few words above the heading, such as ``Step 2``.
    """

    title: str
    blocks: tuple[Block, ...]
    label: str = ""


Block = Paragraph | Facts | Figure | Picture | Table | Code | Gallery | Folded | Section


@dataclass(frozen=True)
class Document:
    """A page.

    Attributes:
        title: its heading.
        label: a few words above the heading.
        blocks: its content.
        end: the last line.
    """

    title: str
    label: str
    blocks: tuple[Block, ...]
    end: str = ""

    def figures(self) -> tuple[Figure, ...]:
        """Return every figure of the page."""
        return tuple(block for block in _all(self.blocks) if isinstance(block, Figure))

    def tables(self) -> tuple[ResultTable, ...]:
        """Return every table of the page."""
        return tuple(block.result for block in _all(self.blocks) if isinstance(block, Table))


def paragraph(*words: Words, kind: str = "") -> Paragraph:
    """Return a paragraph of words."""
    return Paragraph(words, kind)


def _all(blocks: Iterable[Block]) -> Iterable[Block]:
    for block in blocks:
        yield block
        if isinstance(block, Section | Gallery | Folded):
            yield from _all(block.blocks)
