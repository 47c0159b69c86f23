"""``python -m estimation.reestimate``: recordings through the current estimators, and what changes by it."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

WRONG_INPUT = 2

USAGE = """examples:
  python -m estimation.reestimate runs/ --compare
  python -m estimation.reestimate pick.bag --tare empty.bag --robot gen3 --json
  python -m estimation.reestimate log.csv --map columns.toml --robot arm.urdf --tool-frame flange"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return its exit code."""
    parser = _parser()
    given = parser.parse_args(arguments)
    from dynamics.command_line import interrupted
    from dynamics.errors import PalpateError
    from estimation.reestimation.batch import Request, estimate_all, run_directories
    from estimation.reestimation.report import lines

    request = Request(
        given.map, given.robot, given.tool_frame, tuple(given.tare), given.drives, given.reference, given.object
    )
    try:
        logs = run_directories(given.log)
        with _progress(len(logs), given.quiet or given.json) as told:
            reports = estimate_all(logs, request, given.workers, given.scheduler, told)
    except PalpateError as error:
        print(f"{parser.prog}: {error}", file=sys.stderr)
        return WRONG_INPUT
    except KeyboardInterrupt:
        return interrupted(parser.prog)
    bad = [report for report in reports if "error" in report]
    for report in bad:
        print(f"{parser.prog}: {report['log']}: {report['error']}", file=sys.stderr)
    try:
        if given.json:
            print(json.dumps(reports, indent=2))
        else:
            for report in reports:
                if "error" not in report:
                    print("\n".join(lines(report, given.compare)))
    except BrokenPipeError:
        return 0
    return WRONG_INPUT if bad else 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m estimation.reestimate",
        description="Run recordings through the current estimators again.",
        epilog=USAGE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("log", nargs="+", type=Path, help="run, folder of runs, bag, MCAP, CSV, NPZ, Parquet")
    parser.add_argument("--map", default="", metavar="FILE", help="what the columns of a log mean (TOML)")
    parser.add_argument("--robot", default="", metavar="NAME|URDF", help="the arm (default: as recorded, or gen3)")
    parser.add_argument("--tool-frame", default="", metavar="NAME", help="frame of a URDF that holds the payload")
    parser.add_argument(
        "--tare", action="append", default=[], metavar="LOG", help="the empty arm: the same poses, or any motion"
    )
    parser.add_argument("--drives", default="", metavar="FILE", help="made by python -m estimation.calibrate")
    parser.add_argument("--object", default="", metavar="NAME|FILE", help="shape and size (default: as recorded)")
    parser.add_argument("--reference", default="", metavar="NAME|FILE", help="materials (default: as recorded)")
    parser.add_argument("--compare", action="store_true", help="show what changed against the recorded values")
    parser.add_argument("--json", action="store_true", help="everything as JSON")
    parser.add_argument("--workers", type=int, default=0, metavar="N", help="processes (default: one a core)")
    parser.add_argument("--scheduler", default="", metavar="ADDRESS", help="of a Dask scheduler, instead")
    parser.add_argument("--quiet", action="store_true", help="no progress bar")
    return parser


@contextmanager
def _progress(total: int, quiet: bool) -> Iterator[Callable[[int], None]]:
    """Show a bar on a terminal when there is more than one log."""
    if quiet or total < 2 or not sys.stderr.isatty():
        yield lambda count: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeRemainingColumn

    columns = ("re-estimating", BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True)) as progress:
        task = progress.add_task("", total=total)
        yield lambda count: progress.update(task, completed=count)


if __name__ == "__main__":
    sys.exit(main())
