"""The directory of one run, written as it happens."""

from __future__ import annotations

import contextlib
import shutil
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from dynamics.errors import InvalidInput
from dynamics.signals import Sample
from estimation import ipalm
from estimation.measurement import Measurement
from estimation.observation import Observation
from estimation.recording import stream as topics
from estimation.recording.data import Observed, Recorded
from estimation.recording.files import CannotRecord, sync_folder, to_json, to_toml, write_atomically
from estimation.recording.reader import read_recording
from estimation.recording.stream import MessageStream

SPACE = 64 * 2**20  # bytes that must be free before a robot moves: hours of a run

CONFIG, RESULT, MEASUREMENTS, STREAM = "config.toml", "result.json", "measurements", "run.mcap"


class RunWriter:
    """Keeps a run on disk while it happens.

    Samples and phases are written behind the robot's back, at the latest after a quarter of a second; decisions,
    measurements and beliefs are on disk when the call returns. Every call raises CannotRecord once the disk has
    failed: the robot must be stopped then. Begin with :meth:`create` or :meth:`resume`; close it, or use ``with``.

    Attributes:
        directory: where the run is kept.
    """

    def __init__(self, directory: Path, object_name: str, stream: MessageStream, count: int) -> None:
        self.directory = directory
        self._object = object_name
        self._stream = stream
        self._count = count

    @classmethod
    def create(
        cls,
        directory: Path,
        config: Mapping[str, Any],
        object_name: str,
        joint_names: Sequence[str] = (),
        space: int = SPACE,
    ) -> Self:
        """Begin a run in a new or empty directory.

        Args:
            directory: made if need be, with its parents.
            config: what the run was asked for, with seed and versions; kept as ``config.toml``.
            object_name: what is explored.
            joint_names: in the order of the samples.
            space: free bytes that the disk must have.

        Raises:
            InvalidInput: if the directory holds something, or the configuration can not be kept.
            CannotRecord: if the directory can not be written or the disk is nearly full; nothing is left behind.
        """
        directory = Path(directory)
        text = to_toml("run: config", config)
        opening = to_json("run: config", {"object_name": object_name, "config": config, "started": _now()})
        made = _make_empty(directory)
        stream = None
        try:
            _check_space(directory, space)
            (directory / MEASUREMENTS).mkdir()
            write_atomically(directory / CONFIG, text)
            stream = MessageStream(directory / STREAM, joint_names)
            stream.put_event(topics.RUN, 0.0, opening)
            stream.commit()
            sync_folder(directory)
        except (CannotRecord, OSError) as error:
            _abandon(directory, stream, made)
            raise (
                error if isinstance(error, CannotRecord) else CannotRecord(f"{directory}: {error.strerror}")
            ) from error
        return cls(directory, object_name, stream, 0)

    @classmethod
    def resume(cls, directory: Path, joint_names: Sequence[str] = (), space: int = SPACE) -> Self:
        """Continue a run that was interrupted, in a further file ``run-N.mcap`` beside the first.

        What the run knows so far stands in ``read_recording(directory)``; measurement files that the interruption
        prevented are written now.

        Raises:
            InvalidInput: if there is no run, or it has ended.
            CannotRecord: as :meth:`create`.
        """
        directory = Path(directory)
        if (directory / RESULT).exists():
            raise InvalidInput(f"run {directory}", RESULT, "a run that has not ended")
        past = read_recording(directory)
        _check_space(directory, space)
        segment = 1 + sum(1 for _ in directory.glob("run*.mcap"))
        file = directory / f"run-{segment}.mcap"
        stream = MessageStream(file, joint_names or past.joint_names)
        name = past.object_name or directory.name
        run = cls(directory, name, stream, len(past.measurements) + len(past.observations))
        opening = {"object_name": name, "config": past.config, "started": _now(), "segment": segment}
        try:
            stream.put_event(topics.RUN, 0.0, to_json("run: config", opening))
            stream.commit()
            (directory / MEASUREMENTS).mkdir(exist_ok=True)
            found: list[Recorded | Observed] = sorted(
                [*past.measurements, *past.observations], key=lambda one: one.time
            )
            for number, one in enumerate(found, 1):
                content = one.measurement if isinstance(one, Recorded) else one.observation
                if not run._file(number, content).exists():
                    run._write(number, content)
        except (CannotRecord, OSError) as error:
            with contextlib.suppress(CannotRecord):
                stream.close()
            file.unlink(missing_ok=True)
            raise CannotRecord(f"{directory}: the run can not be continued: {error}") from error
        return run

    def sample(self, sample: Sample) -> None:
        """Keep a sample; made to be a listener of a robot, it returns at once."""
        self._stream.put_sample(sample)

    def phase(self, action: str, name: str, index: int, time: float) -> None:
        """Mark the start of a phase; samples belong to it until it ends or the next one starts."""
        data = {"action": action, "name": name, "index": index, "time": time, "event": "start"}
        self._stream.put_event(topics.PHASE, time, to_json("phase", data))

    def end_phase(self, time: float) -> None:
        """Mark the end of the phase."""
        self._stream.put_event(topics.PHASE, time, to_json("phase", {"time": time, "event": "end"}))

    def decision(self, time: float, data: Mapping[str, Any]) -> None:
        """Keep a decision; it is on disk on return."""
        self._keep(topics.DECISION, time, {"data": data})

    def belief(self, time: float, data: Mapping[str, Any]) -> None:
        """Keep a belief; it is on disk on return."""
        self._keep(topics.BELIEF, time, {"data": data})

    def measurement(self, time: float, action: str, measurement: Measurement) -> None:
        """Keep a measurement, in the stream and as a file of its own; both are on disk on return."""
        values = {name: getattr(measurement, name) for name in ("property", "mean", "sd", "unit")}
        self._keep_numbered(topics.MEASUREMENT, time, action, values, measurement)

    def observation(self, time: float, action: str, observation: Observation) -> None:
        """Keep an observation of a class, in the stream and as a file of its own; both are on disk on return."""
        values = {"variable": observation.variable, "likelihoods": observation.by_class}
        self._keep_numbered(topics.OBSERVATION, time, action, values, observation)

    def finish(self, result: Mapping[str, Any]) -> None:
        """Keep the result of the run as ``result.json``; equal results give equal bytes.

        Raises:
            InvalidInput: for numbers that are not finite.
        """
        text = to_json("run: result", result, indent=2)
        self._stream.commit()
        write_atomically(self.directory / RESULT, text + "\n")

    def close(self) -> None:
        """Close the recording; safe to call twice."""
        self._stream.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None
    ) -> None:
        try:
            self.close()
        except CannotRecord:
            if error is None:  # else the first error says more
                raise

    def _keep(self, topic: str, time: float, data: Mapping[str, Any]) -> None:
        text = to_json(topic.strip("/"), {"time": time, "wall": _now(), **data})
        self._stream.put_event(topic, time, text)
        self._stream.commit()

    def _keep_numbered(
        self, topic: str, time: float, action: str, values: Mapping[str, Any], content: Measurement | Observation
    ) -> None:
        number = self._count + 1
        self._keep(topic, time, {"action": action, "number": number, **values})
        self._count = number
        self._write(number, content)

    def _write(self, number: int, content: Measurement | Observation) -> None:
        if isinstance(content, Measurement):
            text = ipalm.to_list([ipalm.MeasuredObject(self._object, None, measurements=(content,))])
        else:
            text = ipalm.to_list([ipalm.MeasuredObject(self._object, None, observations=(content,))])
        write_atomically(self._file(number, content), text)

    def _file(self, number: int, content: Measurement | Observation) -> Path:
        spoken = content.property if isinstance(content, Measurement) else content.variable
        name = "".join(c if c.isalnum() or c in "-_" else "_" for c in spoken)
        return self.directory / MEASUREMENTS / f"{number:03d}-{name}.json"


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def _make_empty(directory: Path) -> list[Path]:
    """Make a directory; return the folders that did not exist, innermost first."""
    made = [folder for folder in (directory, *directory.parents) if not folder.exists()]
    try:
        directory.mkdir(parents=True, exist_ok=True)
        holds = next(directory.iterdir(), None)
    except OSError as error:
        raise CannotRecord(f"{directory}: {error.strerror}; no run can be kept there") from error
    if holds is not None:
        raise InvalidInput(
            f"run directory {directory}", f"{holds.name} and perhaps more in it", "an empty directory"
        )
    return made


def _check_space(directory: Path, space: int) -> None:
    free = shutil.disk_usage(directory).free
    if free < space:
        raise CannotRecord(
            f"{directory}: the disk is full, {free >> 20} MiB are left; a run needs {space >> 20} MiB"
        )


def _abandon(directory: Path, stream: MessageStream | None, made: list[Path]) -> None:
    """Leave no half-made run behind."""
    if stream is not None:
        with contextlib.suppress(CannotRecord):  # the reason is on its way already
            stream.close()
    for item in directory.iterdir():
        if item.is_dir():
            shutil.rmtree(item, ignore_errors=True)
        else:
            item.unlink(missing_ok=True)
    for folder in made:
        try:
            folder.rmdir()
        except OSError:
            break
