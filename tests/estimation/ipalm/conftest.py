"""A stub of the object database's server, with the real one's habits, traps included.

It prefixes every address it returns with ``/ipalm/``; drops the series of a device it has not met; knows no
identity of an upload; keeps parameters as JSON text; breaks, after saving, on a file without an entry and on an
anonymous upload; and can be told to lose connections.
"""

import base64
import json
import threading
from collections.abc import Iterator
from datetime import UTC, datetime
from email.message import Message
from email.parser import BytesParser
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

import pytest

PAGE = 5
USER, PASSWORD = "ada", "lovelace"
ROWS = ("measurements", "setup_elements", "setups", "object_instances", "sensor_outputs")


class Database:
    """What the stub keeps, and how it misbehaves.

    Attributes:
        lose: for the next uploads, ``before`` or ``after`` storing: the connection is cut; ``break``: error 500.
    """

    def __init__(self) -> None:
        self.rows: dict[str, list[dict[str, Any]]] = {kind: [] for kind in ROWS}
        self.media: dict[str, Any] = {}
        self.files: list[tuple[str, int]] = []
        self.lose: list[str] = []
        self.posts = 0
        self.url = ""
        self.lock = threading.Lock()

    def link(self, kind: str, number: int) -> str:
        return f"{self.url}/ipalm/rest/{kind}/{number}/"

    def add(self, kind: str, row: dict[str, Any]) -> dict[str, Any]:
        row["url"] = self.link(kind, len(self.rows[kind]) + 1)
        self.rows[kind].append(row)
        return row

    def uploads(self) -> list[dict[str, Any]]:
        return [row for row in self.rows["measurements"] if row["method"] != "registration of devices"]

    def store(self, text: str, files: dict[str, bytes], user: str | None) -> dict[str, Any]:
        """Do what the server does with an upload; any exception is its error 500."""
        data = json.loads(text)
        measurement = data["measurement"]
        if (
            "sensor_outputs" not in measurement
            or "setup" not in measurement
            or "object_instance" not in measurement
        ):
            raise KeyError("400")
        outputs = measurement["sensor_outputs"]
        names = list(measurement["setup"].values())
        known = {row["name"]: row for row in self.rows["setup_elements"]}
        kept = []
        for kind, name in measurement["setup"].items():
            if name in known and name in outputs:
                row = self.add("sensor_outputs", {"sensor": known[name]["url"], "sensor_output": None})
                series = outputs[name]
                row["parameters"] = json.dumps(next((series[key] for key in series if "param" in key), {}))
                media = f"output{len(self.rows['sensor_outputs'])}.json"
                self.media[media] = series
                row["sensor_output_large"] = f"{self.url}/ipalm/media/{media}"
                kept.append(row)
            elif name not in known:
                self.add("setup_elements", {"type": kind, "name": name})
        elements = [row for row in self.rows["setup_elements"] if row["name"] in names]
        setup = self.add("setups", {"setup_elements": elements})
        listed = data.get("entries", []) + ([data["entry"]] if data.get("entry") else [])
        if user is None:
            raise ValueError("Cannot assign AnonymousUser")
        entries = [self._entry(entry) for entry in listed]
        row = {
            "created": datetime.now(UTC).isoformat(),
            "method": measurement.get("method"),
            "consider_this_ground_truth": measurement.get("consider_this_ground_truth"),
            "object_instance": self._instance(measurement["object_instance"])["url"],
            "setup": setup["url"],
            "sensor_outputs": kept,
            "entries": entries,
        }
        for key in ("grasp", "gripper_pose", "object_pose"):
            pose = measurement.get(key)
            whole = pose and (key == "object_pose" or "grasped" in pose)
            numbers = (
                dict(
                    zip(["tx", "ty", "tz", "rx", "ry", "rz"], pose["translation"] + pose["rotation"], strict=True)
                )
                if whole
                else {}
            )
            row[key] = {**numbers, "grasped": pose.get("grasped")} if whole else None
        self.add("measurements", row)
        if files and not listed:
            raise NameError("property_element_objects")  # after everything was saved
        self.files += [(name, len(content)) for name, content in files.items()]
        return {**row, "sensor_outputs": []}

    def _entry(self, entry: dict[str, Any]) -> dict[str, Any]:
        if not {"type", "name", "repository", "values"} <= set(entry):
            raise KeyError("400")
        elements = []
        for value in entry["values"]:
            number = value.get("probability")
            units = value["name"]
            if number is None:
                number, units = value.get("value", value.get("mean")), value["units"] or "SI"
            elements.append({"name": value["name"], "value": number, "std": value.get("std"), "units": units})
        return {
            "type": entry["type"],
            "name": entry["name"],
            "repository": entry["repository"],
            "ground_truth": entry.get("ground_truth", False),
            "property_element": elements,
        }

    def _instance(self, instance: dict[str, Any]) -> dict[str, Any]:
        keys = ("dataset", "dataset_id", "maker", "common_name")
        for row in self.rows["object_instances"]:
            if all(row[key] == instance.get(key) for key in keys):
                for key, value in instance.get("other", {}).items():
                    row["other"][f"{key}1" if key in row["other"] else key] = value
                return row
        return self.add(
            "object_instances", {key: instance.get(key) for key in keys} | {"other": instance["other"]}
        )


class Handler(BaseHTTPRequestHandler):
    database: Database

    def log_message(self, *_: object) -> None:
        pass

    def do_GET(self) -> None:
        path, _, query = self.path.partition("?")
        parts = path.strip("/").split("/")
        if parts[0] == "media":
            return self._answer(200, self.database.media[parts[1]])
        rows = self.database.rows.get(parts[1])
        if rows is None:
            return self._answer(404, {"detail": "Not found."})
        if len(parts) > 2:
            return self._answer(200, rows[int(parts[2]) - 1])
        page = int(dict(item.split("=") for item in query.split("&") if item).get("page", 1))
        shown = rows[(page - 1) * PAGE : page * PAGE]
        if not shown and page > 1:
            return self._answer(404, {"detail": "Invalid page."})
        more = f"{self.database.url}/ipalm/rest/{parts[1]}/?page={page + 1}" if page * PAGE < len(rows) else None
        return self._answer(200, {"count": len(rows), "next": more, "previous": None, "results": shown})

    def do_POST(self) -> None:
        body = self.rfile.read(int(self.headers["Content-Length"]))
        head = f"Content-Type: {self.headers['Content-Type']}\r\n\r\n".encode()
        form: Message = BytesParser().parsebytes(head + body)
        fields: dict[str, bytes] = {}
        for part in form.get_payload():  # type: ignore[union-attr]
            name = part.get_param("name", header="content-disposition")  # type: ignore[union-attr]
            fields[str(name)] = part.get_payload(decode=True)  # type: ignore[union-attr, assignment]
        user = None
        if self.headers.get("Authorization"):
            if base64.b64decode(self.headers["Authorization"].split()[1]).decode() != f"{USER}:{PASSWORD}":
                return self._answer(401, {"detail": "Invalid username/password."})
            user = USER
        text = fields.pop("measurement").decode()
        is_data = json.loads(text)["measurement"].get("method") != "registration of devices"
        with self.database.lock:
            self.database.posts += is_data
            fate = self.database.lose.pop(0) if is_data and self.database.lose else ""
            if fate == "before":
                return self.connection.close()
            if fate == "break":
                return self._answer(500, "<html><title>OperationalError at /rest/measurements/</title></html>")
            try:
                row = self.database.store(text, fields, user)
            except KeyError as error:
                return self._answer(400, {"non_field_errors": [str(error)]})
            except Exception as error:
                return self._answer(
                    500, f"<html><title>{type(error).__name__} at /rest/measurements/</title></html>"
                )
        if fate == "after":
            return self.connection.close()
        return self._answer(201, row)

    def _answer(self, status: int, content: Any) -> None:
        body = (content if isinstance(content, str) else json.dumps(content)).encode()
        self.send_response(status)
        self.send_header("Content-Type", "text/html" if isinstance(content, str) else "application/json")
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)


@pytest.fixture
def database() -> Iterator[Database]:
    """Yield a running stub."""
    kept = Database()
    handler = type("BoundHandler", (Handler,), {"database": kept})
    server = ThreadingHTTPServer(("127.0.0.1", 0), handler)
    server.handle_error = lambda *_: None  # type: ignore[method-assign]
    kept.url = f"http://127.0.0.1:{server.server_address[1]}"
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.02})
    thread.start()
    yield kept
    server.shutdown()
    thread.join()
    server.server_close()
