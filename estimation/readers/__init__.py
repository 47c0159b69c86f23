"""Readers of logs: every format becomes a Recording. A further one needs a function and a line in ``_READERS``."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from dynamics.errors import InvalidInput
from estimation.readers.mapping import LogMap
from estimation.recording import Recording, read_recording

if TYPE_CHECKING:
    from dynamics.arm import Arm

Reader = Callable[[Path, LogMap, "Arm | None"], Recording]

_READERS = {
    ".mcap": "mcap.read_mcap",
    ".bag": "rosbag.read_rosbag",
    ".db3": "rosbag.read_rosbag",
    ".npz": "npz.read_npz",
    ".parquet": "parquet.read_parquet",
    ".csv": "text.read_text",
    ".tsv": "text.read_text",
    ".txt": "text.read_text",
}

__all__ = ["LogMap", "formats", "read_log"]


def formats() -> tuple[str, ...]:
    """Return the endings of the files that can be read."""
    return tuple(_READERS)


def read_log(path: str | Path, mapping: LogMap | None = None, arm: Arm | None = None) -> Recording:
    """Return the recording of a log: a run directory, a ROS 2 bag's folder, or a file of a known ending.

    Args:
        path: the log.
        mapping: what its columns mean, and options.
        arm: if given, the order of joints and the sign of torques are checked against it.

    Raises:
        InvalidInput: if it can not be read, or can not be what it is said to be.
    """
    path = Path(path)
    mapping = LogMap() if mapping is None else mapping
    if not path.exists():
        raise InvalidInput("log", str(path), "an existing file or folder")
    if path.is_dir():
        if (path / "run.mcap").is_file():
            return read_recording(path)
        return _reader("rosbag.read_rosbag")(path, mapping, arm)
    known = _READERS.get(path.suffix.lower())
    if known is None:
        raise InvalidInput(f"log {path}", path.suffix or "no ending", ", ".join([*_READERS, "or a run directory"]))
    return _reader(known)(path, mapping, arm)


def _reader(name: str) -> Reader:
    module, function = name.split(".")
    found: Reader = getattr(import_module(f"estimation.readers.{module}"), function)
    return found
