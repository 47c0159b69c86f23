"""Explore many random objects: ``python -m selection.dataset``."""

from __future__ import annotations

import argparse
import os
import shlex
import sys
from collections.abc import Callable
from pathlib import Path

from dynamics.command_line import ended
from selection.arguments import DEFAULT_REFERENCE, OneLineParser

MOST_OBJECTS = 1_000_000


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return its exit code."""
    command = _parser()
    given = command.parse_args(arguments)
    again = shlex.join([*command.prog.split(), *(sys.argv[1:] if arguments is None else arguments)])
    return ended(command.prog, lambda: _generate(given), f"what is complete is kept, go on with: {again}")


def _parser() -> argparse.ArgumentParser:
    made = OneLineParser(
        prog="python -m selection.dataset",
        description="Explore random objects in simulation, in parallel; keep every recording and a table of truth "
        "and estimates. The same command goes on where it was interrupted.",
    )
    made.add_argument("--objects", type=_whole(1, MOST_OBJECTS), required=True, metavar="N", help="how many")
    made.add_argument("--out", type=Path, required=True, metavar="DIR", help="where to, and what to go on with")
    made.add_argument("--seed", type=_whole(0, 10**18), default=0, metavar="S", help="of everything random (0)")
    made.add_argument(
        "--reference",
        default=DEFAULT_REFERENCE,
        metavar="NAME|FILE.json",
        help="materials to draw from and to tell apart (%(default)s)",
    )
    made.add_argument(
        "--noise", default="default", metavar="default|none|FILE", help="errors of the simulated sensors"
    )
    made.add_argument("--poisson", type=_poisson, default=0.0, metavar="MAX", help="largest Poisson's ratio (0)")
    made.add_argument("--workers", type=_whole(0, 1024), default=0, metavar="N", help="processes (one a core)")
    made.add_argument("--scheduler", default="", metavar="ADDRESS", help="of Dask, to use its workers instead")
    made.add_argument("--quiet", action="store_true", help="print nothing but errors")
    return made


def _generate(given: argparse.Namespace) -> int:
    from selection.dataset.folder import Dataset
    from selection.dataset.one import Setup, check_setup
    from selection.dataset.progress import show_progress
    from selection.dataset.table import TABLE, check_parquet, row_of, write_table

    check_parquet()
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # in the workers: one core each
    noise = str(Path(given.noise).resolve()) if Path(given.noise).is_file() else given.noise
    reference = str(Path(given.reference).resolve()) if Path(given.reference).is_file() else given.reference
    setup = Setup(given.seed, reference, noise, poisson=given.poisson)
    check_setup(setup)
    with Dataset.open(given.out.resolve(), setup) as dataset:
        missing = len(dataset.missing(given.objects))
        outcomes = dataset.explore(given.objects, given.workers, given.scheduler)
        show_progress(outcomes, given.objects, missing, given.quiet)
        rows = [row_of(dataset.job(index).folder) for index in range(given.objects)]
        write_table(given.out / TABLE, rows)
    if not given.quiet:
        failed, steps = (sum(row.get(key, 0) for row in rows) for key in ("failed_steps", "steps"))
        right = sum(row.get("believed_material") == row.get("true_material") for row in rows)
        lost = sum("error" in row for row in rows)
        print(
            f"{len(rows)} objects in {given.out / TABLE}: {right} materials found, "
            f"{failed} of {steps} actions failed, {lost} explorations without a result."
        )
    return 0


def _whole(least: int, most: int) -> Callable[[str], int]:
    def read(text: str) -> int:
        if not text.isascii() or not text.isdigit() or len(text) > 19 or not least <= int(text) <= most:
            raise argparse.ArgumentTypeError(f"{text!r} is not a whole number from {least} to {most}")
        return int(text)

    return read


def _poisson(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0 <= value <= 0.45:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number from 0 to 0.45")
    return value


if __name__ == "__main__":
    sys.exit(main())
