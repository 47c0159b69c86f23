"""Many logs, each by itself, on all cores or on a Dask cluster."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from dynamics.errors import InvalidInput, PalpateError


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
    if len(logs) == 1 and not scheduler:
        return [estimate_one(logs[0], request)]
    with _executor(workers or os.cpu_count() or 1, scheduler) as executor:
        futures: dict[Future[Mapping[str, Any]], int] = {
            executor.submit(estimate_one, log, request): number for number, log in enumerate(logs)
        }
        for count, _ in enumerate(as_completed(futures), 1):
            told(count)
        ordered = sorted(futures, key=lambda future: futures[future])
        return [future.result() for future in ordered]


def estimate_one(log: Path, request: Request) -> Mapping[str, Any]:
    """Return the report of one log; what is wrong with it is in the report."""
    from estimation.reestimation.report import report_of

    try:
        return report_of(log, request)
    except PalpateError as error:
        return {"log": str(log), "error": str(error)}


@contextmanager
def _executor(workers: int, scheduler: str) -> Iterator[Executor]:
    if not scheduler:
        with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
            yield pool
        return
    try:
        from distributed import Client
    except ImportError:
        raise InvalidInput("--scheduler", scheduler, "an installed Dask: pip install palpate[dask]") from None
    try:
        client = Client(scheduler, timeout=10)
    except (OSError, ValueError) as error:
        raise InvalidInput("--scheduler", scheduler, f"the address of a Dask scheduler ({error})") from None
    with client:
        yield client.get_executor()
