"""A page on disk: the HTML file, and beside it a file for each figure and each table."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from estimation.recording.files import CannotRecord, write_atomically
from selection.reporting.document import Document
from selection.reporting.html import html_of
from selection.reporting.text import slug

FIGURES, TABLES = "figures", "tables"


def write_document(document: Document, path: Path) -> Path:
    """Write a page, its figures as SVG and its tables as CSV; return the page's path.

    The page is written last: where it stands, everything stands.

    Raises:
        CannotRecord: if something cannot be written.
    """
    figures, tables = document.figures(), document.tables()
    try:
        for folder, files in (
            (path.parent / FIGURES, _named(((figure.name, figure.svg) for figure in figures), "svg")),
            (path.parent / TABLES, _named(((table.name, table.csv()) for table in tables), "csv")),
        ):
            if files:
                folder.mkdir(parents=True, exist_ok=True)
            for name, text in files.items():
                (folder / name).write_text(text, encoding="utf-8")
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise CannotRecord(f"{path.parent}: {error.strerror or error}; there is no report") from error
    write_atomically(path, html_of(document))
    return path


def _named(files: Iterable[tuple[str, str]], kind: str) -> dict[str, str]:
    """Return texts by names that are fit for files, and different."""
    named: dict[str, str] = {}
    for name, text in files:
        stem, number = slug(name), 2
        while f"{stem}.{kind}" in named:
            stem, number = f"{slug(name)}-{number}", number + 1
        named[f"{stem}.{kind}"] = text
    return named
