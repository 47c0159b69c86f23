"""A page as one HTML file that is well-formed XML and refers to nothing outside itself."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path

from selection.reporting.document import (
    Block,
    Code,
    Document,
    Fact,
    Facts,
    Figure,
    Folded,
    Gallery,
    Paragraph,
    Picture,
    Section,
    Strong,
    Table,
    Words,
)
from selection.reporting.palette import DARK, LIGHT, variables
from selection.reporting.text import clean

STYLE = Path(__file__).with_name("style.css")
LONG = 32  # letters of a cell from which it is broken into lines
MOST_ROWS = 400  # of a table on the page; its CSV has them all
_POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"


def html_of(document: Document) -> str:
    """Return a page as HTML."""
    dark = f"@media screen and (prefers-color-scheme:dark){{:root{{{variables(DARK)}}}}}"
    style = f":root{{{variables(LIGHT)}}}\n{dark}\n{STYLE.read_text(encoding='utf-8')}"
    title, label = _text(document.title), _text(document.label)
    head = (
        '<meta charset="utf-8"/>'
        '<meta name="viewport" content="width=device-width, initial-scale=1"/>'
        '<meta name="color-scheme" content="light dark"/>'
        f'<meta http-equiv="Content-Security-Policy" content="{_text(_POLICY)}"/>'
        f"<title>{title} – {label}</title><style>\n{style}</style>"
    )
    header = f'<header><p class="label">{label}</p><h1>{title}</h1></header>'
    footer = f"<footer><p>{_text(document.end)}</p></footer>" if document.end else ""
    body = f"<main>{header}\n{_blocks(document.blocks, 2)}\n{footer}</main>"
    return f'<!DOCTYPE html>\n<html lang="en"><head>{head}</head>\n<body>{body}</body></html>\n'


def _blocks(blocks: Iterable[Block], level: int) -> str:
    return "\n".join(_block(block, level) for block in blocks)


def _block(block: Block, level: int) -> str:
    match block:
        case Paragraph():
            kind = f' class="{block.kind}"' if block.kind else ""
            return f"<p{kind}>{''.join(_word(word) for word in block.words)}</p>"
        case Facts():
            return f'<dl class="facts">{"".join(_fact(fact) for fact in block.facts)}</dl>'
        case Figure():
            return _figure(block)
        case Picture():
            data = base64.b64encode(block.jpeg).decode("ascii")
            words = _text(block.caption)
            return (
                f'<figure><img alt="{words}" src="data:image/jpeg;base64,{data}"/>'
                f"<figcaption>{words}</figcaption></figure>"
            )
        case Table():
            return _table(block)
        case Code():
            return f'<pre tabindex="0">{_text(block.text)}</pre>'
        case Gallery():
            return f'<div class="{f"gallery {block.kind}".strip()}">{_blocks(block.blocks, level)}</div>'
        case Folded():
            return f"<details><summary>{_text(block.summary)}</summary>{_blocks(block.blocks, level)}</details>"
        case Section():
            label = f'<p class="label">{_text(block.label)}</p>' if block.label else ""
            deeper = _blocks(block.blocks, min(level + 1, 6))
            return f"<section>{label}<h{level}>{_text(block.title)}</h{level}>\n{deeper}</section>"


def _word(word: Words) -> str:
    return f"<strong>{_text(word.text)}</strong>" if isinstance(word, Strong) else _text(word)


def _fact(fact: Fact) -> str:
    remark = f'<dd class="remark">{_text(fact.remark)}</dd>' if fact.remark else ""
    return f"<div><dt>{_text(fact.label)}</dt><dd>{_text(fact.value)}</dd>{remark}</div>"


def _figure(figure: Figure) -> str:
    kind = ' class="wide"' if figure.wide else ""
    caption = f" <span>{_text(figure.caption)}</span>" if figure.caption else ""
    drawing = figure.inline.replace("<svg", f'<svg role="img" aria-label="{_text(figure.alt)}"', 1)
    return f"<figure{kind}><figcaption><b>{_text(figure.title)}</b>{caption}</figcaption>{drawing}</figure>"


def _table(table: Table) -> str:
    texts = table.result.texts() if table.texts is None else table.texts
    columns = table.result.columns if table.columns is None else table.columns
    right = [not table.pairs and _is_numeric([row[i] for row in texts]) for i in range(len(columns))]
    kinds = [' class="number"' if is_number else "" for is_number in right]
    head = "".join(f'<th scope="col"{kind}>{_text(name)}</th>' for name, kind in zip(columns, kinds, strict=True))
    body = "".join(f"<tr>{_cells(row, kinds)}</tr>" for row in texts[:MOST_ROWS])
    title = _text(table.result.title)
    caption = "" if table.quiet else f"<caption>{title}</caption>"
    kind = ' class="pairs"' if table.pairs else ""
    left_out = len(texts) - MOST_ROWS
    notes = [table.result.note] if table.result.note else []
    if left_out > 0:
        notes.append(f"{left_out} more rows are in {table.result.name}.csv.")
    note = f'<p class="note">{_text(" ".join(notes))}</p>' if notes else ""
    return (
        f'<div class="table"><div class="scroll" tabindex="0" role="region" aria-label="{title}">'
        f"<table{kind}>{caption}<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>{note}</div>"
    )


def _cells(row: Sequence[str], kinds: Sequence[str]) -> str:
    parts = []
    for i, (cell, kind) in enumerate(zip(row, kinds, strict=True)):
        own = ' class="long"' if len(cell) > LONG else kind
        parts.append(f"<td{own}>{_text(cell)}</td>" if i else f'<th scope="row"{own}>{_text(cell)}</th>')
    return "".join(parts)


def _is_numeric(cells: Sequence[str]) -> bool:
    """Tell whether most of a column begins with a digit."""
    said = [cell.lstrip("−-+<> ") for cell in cells if cell not in ("", "–", "-")]
    return bool(said) and sum(cell[:1].isdigit() for cell in said) > len(said) / 2


def _text(text: str) -> str:
    return escape(clean(text), quote=True)
