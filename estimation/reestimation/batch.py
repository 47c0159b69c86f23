"""Many logs, each by itself, on all cores or on a Dask cluster."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from dynamics.errors import InvalidInput, PalpateError
from estimation.parallel import in_parallel


@dataclass(frozen=True)
class Request:
    """How logs are to be read and estimated.

    Attributes:
        mapping: file of the column map, or empty.
        robot, tool_frame: name or file of the robot, and its tool frame in a file; empty for what a log says.
        tares: logs of the empty arm.
        drives: file of a calibration, or empty.
        reference, object_file: names or files; empty for what a log says.
    """

    mapping: str = ""
    robot: str = ""
    tool_frame: str = ""
    tares: tuple[str, ...] = ()
    drives: str = ""
    reference: str = ""
    object_file: str = ""


def run_directories(paths: Sequence[Path]) -> list[Path]:
    """Return logs, with directories of runs replaced by the runs in them.

    Raises:
        InvalidInput: if one does not exist.
    """
    found: list[Path] = []
    for path in paths:
        if not path.exists():
            raise InvalidInput("log", str(path), "an existing file or folder")
        inner = sorted(p.parent for p in path.glob("*/run.mcap")) if path.is_dir() else []
        is_log = (path / "run.mcap").exists() or (path / "metadata.yaml").exists()
        found += inner if inner and not is_log else [path]
    return found


def estimate_all(
    logs: Sequence[Path],
    request: Request,
    workers: int = 0,
    scheduler: str = "",
    told: Callable[[int], None] = lambda count: None,
) -> list[Mapping[str, Any]]:
    """Return a report for every log, in their order.

    Args:
        logs: to be estimated, each by itself.
        request: how.
        workers: processes; 0 for one a core.
        scheduler: address of a Dask scheduler, instead.
        told: called with the number that is done.
    """
    reports: dict[int, Mapping[str, Any]] = {}
    for number, report in in_parallel(partial(estimate_one, request=request), logs, workers, scheduler):
        reports[number] = report
        told(len(reports))
    return [reports[number] for number in range(len(logs))]


def estimate_one(log: Path, request: Request) -> Mapping[str, Any]:
    """Return the report of one log; what is wrong with it is in the report."""
    from estimation.reestimation.report import report_of

    try:
        return report_of(log, request)
    except PalpateError as error:
        return {"log": str(log), "error": str(error)}
