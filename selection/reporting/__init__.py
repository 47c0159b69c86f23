"""What a run or an experiment came to, as a page that needs nothing but itself to be read."""

from __future__ import annotations

from pathlib import Path

from dynamics.errors import InvalidInput
from selection.reporting.experiment_page import write_experiment_report, write_stored_experiment_report
from selection.reporting.run_page import write_run_report

__all__ = ["write_experiment_report", "write_report", "write_run_report"]


def write_report(directory: Path, out: Path | None = None) -> Path:
    """Write the page of a run or an experiment from what it left on disk; return its path.

    Args:
        directory: of the run, or of the experiment.
        out: the page; ``report.html`` in the directory if None.

    Raises:
        InvalidInput: if it is neither.
        CannotRecord: if the files cannot be written.
    """
    if not directory.is_dir():
        raise InvalidInput("report", str(directory), "the directory of a run or of an experiment")
    if any(directory.glob("run*.mcap")):
        return write_run_report(directory, out)
    return write_stored_experiment_report(directory, out)
