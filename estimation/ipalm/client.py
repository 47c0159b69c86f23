"""Measurements to and from an IPALM object database, with what its server needs to be told twice.

The server drops the sensor series of a device it has not met before, knows no identity of an upload, and answers
before it is known what was kept. So devices are registered first, every upload bears an identity in a sensor's
parameters, and what was stored is read back and compared. Nothing is ever deleted.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from dynamics.errors import InvalidInput
from estimation.ipalm.checks import problems
from estimation.ipalm.documents import Document, Entry, ObjectInstance, Pose, Value, to_json
from estimation.ipalm.http import Connection, Part, ServerFailed

IDENTITY = "palpate_upload"
"""Name of the identity among a sensor's parameters."""


@dataclass(frozen=True)
class Stored:
    """What the server keeps of an upload.

    Attributes:
        url: where.
        differences: between what was sent and what is there; empty if nothing was lost.
    """

    url: str
    differences: tuple[str, ...] = ()


class Client:
    """An object database, as its users see it.

    Args:
        connection: to the server.
    """

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._known: dict[str, Any] = {}

    def upload(self, document: Document, identity: str, parts: Sequence[Part] = ()) -> Stored:
        """Store a document.

        Args:
            document: must be free of :func:`~estimation.ipalm.checks.problems`.
            identity: by which it can be found again.
            parts: images and files.

        Raises:
            InvalidInput: before anything is sent.
            ServerUnreachable, ServerRefused, ServerFailed: after that.
        """
        check(document, parts)
        if not self._connection.can_upload:
            raise InvalidInput("database: user", "none", "a user and password, to upload")
        self.register(document)
        marked = with_identity(document, identity)
        answer = self._connection.post("measurements/", {"measurement": to_json(marked, allow_nan=False)}, parts)
        url = answer.get("url") if isinstance(answer, Mapping) else None
        if not isinstance(url, str):
            found = self.find(identity)
            if found is None:
                raise ServerFailed("the server said that it stored the upload, but it can not be found")
            url = found
        return self.compare(url, marked)

    def register(self, document: Document) -> bool:
        """Make the devices of a document known, by an upload without data; return whether that was needed."""
        devices = {str(row.get("name")) for row in self._connection.pages("setup_elements")}
        if set(document.setup.values()) <= devices:
            return False
        plain = Document(document.object_instance, document.setup, method="registration of devices")
        self._connection.post("measurements/", {"measurement": to_json(plain, allow_nan=False)})
        return True

    def find(self, identity: str, since: str = "") -> str | None:
        """Return the address of the upload with an identity, newest first, or None.

        Args:
            identity: as it was uploaded.
            since: look no further back than this time, such as ``2026-11-22T09:00``.
        """
        for row in self._connection.pages("measurements", newest_first=True):
            if since and str(row.get("created", "")) < since:
                return None
            for output in row.get("sensor_outputs") or ():
                if isinstance(output, Mapping) and _parameters(output).get(IDENTITY) == identity:
                    return str(row["url"])
        return None

    def compare(self, url: str, sent: Document) -> Stored:
        """Read an upload back and tell how it differs from what was sent."""
        row = self._connection.get(url)
        if not isinstance(row, Mapping):
            raise ServerFailed(f"{url}: no measurement")
        found = []
        outputs = self._outputs(row)
        for name, series in sent.sensor_outputs.items():
            if name not in outputs:
                found.append(f"the series of {name} were dropped")
            elif json.loads(json.dumps(dict(series))) != outputs[name]:
                found.append(f"the series of {name} differ")
        stored = [_read_entry(entry) for entry in row.get("entries") or ()]
        if len(stored) != len(sent.entries):
            found.append(f"{len(stored)} entries are there, {len(sent.entries)} were sent")
        for entry in sent.entries:
            if not any(_same(entry, other) for other in stored):
                found.append(f"entry {entry.name!r} is missing or differs")
        for key in ("grasp", "gripper_pose", "object_pose"):
            if getattr(sent, key) is not None and not row.get(key):
                found.append(f"{key} was dropped")
        return Stored(url, tuple(found))

    def documents(self, series: bool = False) -> Iterator[Document]:
        """Yield every measurement of the database.

        Args:
            series: whether to fetch the sensors' series too.
        """
        for row in self._connection.pages("measurements"):
            yield self._document(row, series)

    def _document(self, row: Mapping[str, Any], series: bool) -> Document:
        instance = self._fetch(row.get("object_instance"))
        setup = self._fetch(row.get("setup"))
        elements = setup.get("setup_elements") or ()
        names = {key: _text(instance.get(key)) for key in ("dataset", "dataset_id", "maker", "common_name")}
        other = instance.get("other")
        return Document(
            object_instance=ObjectInstance(**names, other=other if isinstance(other, Mapping) else {}),
            setup={str(e.get("type")): str(e.get("name")) for e in elements if isinstance(e, Mapping)},
            sensor_outputs=self._outputs(row) if series else {},
            entries=tuple(_read_entry(entry) for entry in row.get("entries") or () if isinstance(entry, Mapping)),
            grasp=_read_pose(row.get("grasp")),
            gripper_pose=_read_pose(row.get("gripper_pose")),
            object_pose=_read_pose(row.get("object_pose")),
            method=_text(row.get("method")),
            ground_truth=bool(row.get("consider_this_ground_truth")),
        )

    def _outputs(self, row: Mapping[str, Any]) -> dict[str, Any]:
        """Return the series of a measurement by the names of their devices; they are files of their own."""
        outputs = {}
        for output in row.get("sensor_outputs") or ():
            if not isinstance(output, Mapping):
                raise ServerFailed("a sensor output that is none")
            device = self._fetch(output.get("sensor"))
            large = output.get("sensor_output_large")
            content = self._connection.get(str(large)) if large else output.get("sensor_output") or {}
            outputs[str(device.get("name"))] = content
        return outputs

    def _fetch(self, url: object) -> Mapping[str, Any]:
        """Return a row that others refer to; asked for once."""
        if not isinstance(url, str):
            return {}
        if url not in self._known:
            row = self._connection.get(url)
            self._known[url] = row if isinstance(row, Mapping) else {}
        found: Mapping[str, Any] = self._known[url]
        return found


def check(document: Document, parts: Sequence[Part] = ()) -> None:
    """Refuse what the server would spoil.

    Raises:
        InvalidInput: naming everything that is wrong.
    """
    found = list(problems(document))
    names = {value.name for entry in document.entries for value in entry.values}
    if parts and not document.entries:
        found.append("files without an entry: the server would store half of it")
    for part in parts:
        words = part.field.split(" ")
        image = words in (["measurement", "png"], ["png"])
        sensor = len(words) == 2 and words[0] == "measurement" and words[1] in document.sensor_outputs
        value = len(words) == 3 and words[:2] == ["entry", "values"] and words[2] in names
        whole = words == ["measurement", "object_instance"]
        output = len(words) == 3 and words[0] == "measurement" and words[1] in document.sensor_outputs
        if not (image or sensor or value or whole or output):
            found.append(f"file {part.name}: field {part.field!r} names nothing in the document")
        if image and not part.content.startswith((b"\x89PNG\r\n", b"\xff\xd8\xff")):
            found.append(f"file {part.name}: neither PNG nor JPEG")
    if found:
        raise InvalidInput("upload", "; ".join(found), "a document without these")


def with_identity(document: Document, identity: str) -> Document:
    """Return a document that bears its identity in the parameters of one of its sensors."""
    name = next(iter(document.sensor_outputs), next(iter(document.setup.values())))
    series = dict(document.sensor_outputs.get(name, {}))
    key = next((key for key in series if "param" in key), "parameters")
    known = series.get(key)
    series[key] = {**(known if isinstance(known, Mapping) else {}), IDENTITY: identity}
    return replace(document, sensor_outputs={**document.sensor_outputs, name: series})


def _parameters(output: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the parameters of a sensor output, which the server keeps as text within JSON."""
    parameters = output.get("parameters")
    for _ in range(2):
        if isinstance(parameters, str):
            try:
                parameters = json.loads(parameters)
            except (ValueError, RecursionError):
                return {}
    return parameters if isinstance(parameters, Mapping) else {}


def _read_entry(row: Mapping[str, Any]) -> Entry:
    kind = str(row.get("type"))
    values = []
    for one in row.get("property_element") or ():
        name, number, units = str(one.get("name")), one.get("value"), _text(one.get("units"))
        if kind == "categorical":
            values.append(Value(name, probability=number))
        else:
            values.append(Value(name, number, one.get("std"), None if units == "SI" else units))
    return Entry(
        kind, str(row.get("name")), tuple(values), _text(row.get("repository")), bool(row.get("ground_truth"))
    )


def _same(sent: Entry, stored: Entry) -> bool:
    def numbers(entry: Entry) -> list[tuple[Any, ...]]:
        return [(v.name, v.mean, v.std, v.units, v.probability) for v in entry.values]

    return (sent.kind, sent.name, numbers(sent)) == (stored.kind, stored.name, numbers(stored))


def _read_pose(row: object) -> Pose | None:
    if not isinstance(row, Mapping):
        return None
    try:
        numbers = [float(row[key]) for key in ("tx", "ty", "tz", "rx", "ry", "rz")]
    except (KeyError, TypeError, ValueError):
        return None
    grasped = row.get("grasped")
    return Pose((numbers[0], numbers[1], numbers[2]), (numbers[3], numbers[4], numbers[5]), grasped)


def _text(item: object) -> str | None:
    return item if isinstance(item, str) else None
