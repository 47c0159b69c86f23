"""Run the experiments: ``python -m selection.experiments virtual|simulation|emulator|all``."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from dynamics.command_line import ended
from selection.arguments import OneLineParser, seed

if TYPE_CHECKING:
    from selection.trials.studies import Request
    from selection.trials.sweep import Progress

STUDIES = ("virtual", "simulation", "emulator")


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return its exit code."""
    command = _parser()
    given = command.parse_args(arguments)
    return ended(command.prog, lambda: _run(given), "the same --out takes it up")


def _run(given: argparse.Namespace) -> int:
    from selection.trials.output import say, write
    from selection.trials.studies import run_studies

    names = STUDIES if given.study == "all" else (given.study,)
    outcome = run_studies(names, _request(given), _progress(given.quiet))
    write(outcome, given.out, given.json, not given.no_page)
    if not given.quiet:
        say(outcome, given.out, sys.stdout, not given.no_page)
    return 0


def _request(given: argparse.Namespace) -> Request:
    from selection.trials.studies import Request
    from selection.trials.sweep import Machines

    return Request(
        given.out,
        given.repetitions,
        given.objects,
        given.readings,
        given.seed,
        Machines(given.workers, given.scheduler),
    )


def _progress(quiet: bool) -> Progress:
    from selection.trials.progress import Bar, Log
    from selection.trials.sweep import Quiet

    if quiet:
        return Quiet()
    return Bar() if sys.stderr.isatty() else Log()


def _parser() -> argparse.ArgumentParser:
    made = OneLineParser(
        prog="python -m selection.experiments",
        description="Run the thesis' experiments, with statistics, beside the exact criterion and baselines.",
    )
    made.add_argument("study", choices=(*STUDIES, "all"), help="which experiments")
    made.add_argument(
        "--repetitions", type=_count, metavar="N", help="trials of a cell: 400 virtual, 20 otherwise"
    )
    made.add_argument(
        "--objects",
        type=_count,
        default=1000,
        metavar="N",
        help="virtual: objects of the harder worlds (%(default)s)",
    )
    made.add_argument(
        "--readings",
        type=_count,
        default=6,
        metavar="N",
        help="simulation: readings of every action on every object, simulated once and replayed (%(default)s)",
    )
    made.add_argument("--seed", type=seed, default=0, metavar="N", help="of everything random (%(default)s)")
    made.add_argument("--workers", type=_whole, default=0, metavar="N", help="processes; 0 for one a core")
    made.add_argument("--scheduler", default="", metavar="ADDRESS", help="of a Dask cluster, instead of processes")
    made.add_argument(
        "--out",
        type=Path,
        default=Path("experiments"),
        metavar="DIR",
        help="tables, and finished chunks: an interrupted sweep goes on there (%(default)s)",
    )
    made.add_argument("--json", type=Path, metavar="FILE", help="write every cell and table")
    made.add_argument("--no-page", action="store_true", help="write no report.html")
    made.add_argument("--quiet", action="store_true", help="print nothing but errors")
    return made


def _count(text: str) -> int:
    value = _whole(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of at least one")
    return value


def _whole(text: str) -> int:
    if not text.isascii() or not text.isdigit() or len(text) > 9:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number from 0 to 10^9")
    return int(text)


if __name__ == "__main__":
    sys.exit(main())
