"""Write the page of a run or an experiment from what it left on disk: ``python -m selection.report``."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from dynamics.command_line import ended
from selection.arguments import OneLineParser


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return its exit code."""
    command = _parser()
    given = command.parse_args(arguments)
    return ended(command.prog, lambda: _write(given))


def _write(given: argparse.Namespace) -> int:
    from selection.reporting import write_report

    print(write_report(given.directory, given.out))
    return 0


def _parser() -> argparse.ArgumentParser:
    made = OneLineParser(
        prog="python -m selection.report",
        description="Write a page, its figures and its tables, from what a run or an experiment left on disk.",
    )
    made.add_argument("directory", type=Path, metavar="DIR", help="of a run or of an experiment")
    made.add_argument("--out", type=Path, metavar="FILE.html", help="the page (default: report.html in DIR)")
    return made


if __name__ == "__main__":
    sys.exit(main())
