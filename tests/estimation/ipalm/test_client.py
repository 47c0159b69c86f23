"""The client against a stub of the server: everything arrives once, and what is lost is noticed."""

import shutil
import ssl
import subprocess
import threading
from dataclasses import replace
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import pytest

from dynamics.errors import InvalidInput
from estimation.ipalm import Document, Entry, ObjectInstance, Pose, Value
from estimation.ipalm.client import Client
from estimation.ipalm.documents import entry_of, entry_of_classes, measurements_of
from estimation.ipalm.http import Connection, Part, ServerFailed, ServerRefused, ServerUnreachable
from estimation.ipalm.outbox import MAX_ATTEMPTS, Outbox
from estimation.measurement import Measurement
from estimation.store import Observation, learn_classes, reference_content

PNG = b"\x89PNG\r\n\x1a\n" + b"\0" * 20
USER, PASSWORD = "ada", "lovelace"  # the stub's


def document(number: int = 0, name: str = "banana") -> Document:
    return Document(
        ObjectInstance("ycb", f"{number:03d}", None, name),
        {"arm": "kinova_gen3", "gripper": "robotiq_2f85"},
        {
            "robotiq_2f85": {"time": [0.0, 0.1], "position": [0.1, 0.1 + number], "parameters": {"speed": 1}},
            "kinova_gen3": {"joint4_torque": [1.0, 2.0]},
        },
        (
            entry_of(Measurement("density", 560.0 + number, 20.0, "kg/m^3")),
            entry_of_classes("material", {"wood": 0.25, "foam": 0.75}),
        ),
        grasp=Pose((0.1, 0.2, 0.3), (173.3, 0.0, -180.0), True),
        object_pose=Pose((0.1, 0.2, 0.3), (0.0, 0.0, 0.0)),
        method="weigh",
    )


@pytest.fixture
def client(database: Any) -> Client:
    return Client(Connection(database.url, USER, PASSWORD, timeout=5))


def test_an_upload_arrives_whole_also_with_new_devices(database: Any, client: Client) -> None:
    part = Part("measurement png", "scene.png", PNG)
    extra = Part("measurement robotiq_2f85 current", "current.bin", b"123")
    stored = client.upload(document(), "id-1", [part, extra])
    assert stored.differences == ()
    (row,) = database.uploads()
    assert len(row["sensor_outputs"]) == 2
    assert len(database.rows["measurements"]) == 2  # the registration came first
    assert dict(database.files) == {"measurement png": len(PNG), "measurement robotiq_2f85 current": 3}
    client.upload(document(1), "id-2")
    assert len(database.rows["measurements"]) == 3  # no second registration


def test_what_the_server_drops_is_noticed(database: Any, client: Client, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Client, "register", lambda *_: False)
    stored = client.upload(document(), "id-1")
    assert any("robotiq_2f85 were dropped" in text for text in stored.differences)


def test_what_is_stored_is_found_by_its_identity_on_any_page(database: Any, client: Client) -> None:
    for number in range(13):
        client.upload(document(number), f"id-{number}")
    for number in (0, 6, 12):
        found = client.find(f"id-{number}")
        assert found is not None
        assert client.compare(found, document(number)).differences != ()  # without its identity it differs ...
        assert [row for row in database.uploads() if row["url"] == found] == [database.uploads()[number]]
    assert client.find("id-13") is None
    assert client.find("id-0", since="2999") is None


def test_downloaded_documents_are_those_that_were_uploaded(database: Any, client: Client) -> None:
    for number in range(7):
        client.upload(document(number), f"id-{number}")
    read = [one for one in client.documents(series=True) if one.method == "weigh"]
    assert len(read) == 7
    for number, one in enumerate(read):
        sent = document(number)
        assert one.object_instance == sent.object_instance
        assert one.setup == sent.setup
        assert one.grasp == sent.grasp
        assert one.object_pose == sent.object_pose
        assert one.sensor_outputs["kinova_gen3"] == sent.sensor_outputs["kinova_gen3"]
        assert measurements_of(one) == measurements_of(sent)
        assert one.entries[1].values == sent.entries[1].values


def test_a_reference_is_learned_from_downloads(database: Any, client: Client) -> None:
    for number, name in enumerate(["banana", "banana", "brick"]):
        client.upload(document(100 * number, name), f"id-{number}")
    rows = [
        Observation(str(one.object_instance.dataset_id), str(one.object_instance.common_name), measurement)
        for one in client.documents()
        for measurement in measurements_of(one)[0]
    ]
    content = reference_content("ipalm", learn_classes(rows), database.url)
    assert content["materials"] == ["banana", "brick"]
    assert content["properties"]["density"]["classes"]["banana"]["mean"] == pytest.approx(610)


@pytest.mark.parametrize(
    ("bad", "parts", "message"),
    [
        (replace(document(), setup={"arm": "kinova gen3"}), (), "without a space"),
        (replace(document(), entries=()), (Part("png", "a.png", PNG),), "files without an entry"),
        (document(), (Part("measurement png", "a.png", b"GIF89a"),), "neither PNG"),
        (document(), (Part("measurement camera", "a.bin", b""),), "names nothing"),
        (
            replace(document(), entries=(Entry("continuous", "m", (Value("m", float("nan"), 1.0, "kg"),)),)),
            (),
            "nan",
        ),
    ],
)
def test_what_the_server_would_spoil_is_never_sent(
    database: Any, client: Client, bad: Document, parts: tuple[Part, ...], message: str
) -> None:
    with pytest.raises(InvalidInput, match=message):
        client.upload(bad, "id", parts)
    assert not database.rows["measurements"]


def test_passwords_stay_out_of_the_clear() -> None:
    with pytest.raises(InvalidInput, match="plain HTTP"):
        Connection("http://example.org/ipalm", USER, PASSWORD)
    with pytest.raises(InvalidInput, match="plain HTTP"):
        Connection("http://127.0.0.1.example.org/ipalm", USER, PASSWORD)
    with pytest.raises(InvalidInput, match="without a password"):
        Connection(f"https://{USER}:{PASSWORD}@example.org/")
    trusting = ssl.create_default_context()
    trusting.check_hostname = False
    for mode in (ssl.CERT_REQUIRED, ssl.CERT_NONE):
        trusting.verify_mode = mode
        with pytest.raises(InvalidInput, match="verifies"):
            Connection("https://example.org/ipalm", USER, PASSWORD, context=trusting)
    for address in ("example.org", "ftp://example.org", "https://"):
        with pytest.raises(InvalidInput, match="address"):
            Connection(address)
    Connection("http://localhost:8000", USER, PASSWORD)
    Connection("http://[::1]:8000", USER, PASSWORD)
    Connection("http://example.org/ipalm")  # reading needs no password


@pytest.mark.skipif(shutil.which("openssl") is None, reason="no openssl to make a certificate with")
def test_a_certificate_that_nobody_vouches_for_is_refused(tmp_path: Path) -> None:
    """Neither reading nor uploading; with the authority that vouches for it, it is a server like others."""
    key, certificate = tmp_path / "key.pem", tmp_path / "certificate.pem"
    command = ["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=localhost"]
    command += ["-addext", "subjectAltName=DNS:localhost", "-keyout", str(key), "-out", str(certificate)]
    subprocess.run(command, check=True, capture_output=True)
    heard = []

    class Page(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            heard.append(self.headers.get("Authorization"))
            body = b'{"count": 0, "next": null, "results": []}'
            self.send_response(200)
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, *_: object) -> None:
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Page)
    identity = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    identity.load_cert_chain(certificate, key)
    server.socket = identity.wrap_socket(server.socket, server_side=True)
    server.handle_error = lambda *_: None  # type: ignore[method-assign]
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.02})
    thread.start()
    try:
        address = f"https://localhost:{server.server_address[1]}/ipalm"
        for user in ((), (USER, PASSWORD)):
            with pytest.raises(ServerUnreachable, match="certificate verify failed"):
                list(Connection(address, *user, timeout=5).pages("setups"))
        assert not heard
        known = ssl.create_default_context(cafile=str(certificate))
        assert list(Connection(address, USER, PASSWORD, timeout=5, context=known).pages("setups")) == []
        assert heard[0].startswith("Basic ")
    finally:
        server.shutdown()
        thread.join()
        server.server_close()


def test_addresses_of_the_server_are_put_under_its_base() -> None:
    connection = Connection("https://host/some/ipalm/rest/")
    assert connection.base == "https://host/some/ipalm"
    given = "http://other/ipalm/rest/measurements/?page=2"
    assert connection.rewrite(given) == "https://host/some/ipalm/rest/measurements/?page=2"
    assert connection.rewrite("/ipalm/media/output5.json") == "https://host/some/ipalm/media/output5.json"
    assert connection.rewrite("setups/3/") == "https://host/some/ipalm/rest/setups/3/"


def test_refusals_and_failures_are_told_apart(database: Any) -> None:
    wrong = Client(Connection(database.url, USER, "wrong"))
    with pytest.raises(ServerRefused, match=r"401.*Invalid username") as refused:
        wrong.upload(document(), "id")
    assert refused.value.status == 401
    with pytest.raises(InvalidInput, match="user"):
        Client(Connection(database.url)).upload(document(), "id")
    with pytest.raises(ServerUnreachable):
        Client(Connection("http://127.0.0.1:1", USER, PASSWORD, timeout=1)).upload(document(), "id")
    with pytest.raises(ServerRefused, match="404"):
        Connection(database.url).get("nothing/")
    database.lose = ["break"]
    with pytest.raises(ServerFailed, match="OperationalError"):
        Client(Connection(database.url, USER, PASSWORD)).upload(document(), "id")


def test_the_outbox_survives_whatever_happens_to_the_connection(
    database: Any, client: Client, tmp_path: Path
) -> None:
    """Connections are lost before and after storing, and the process restarts; all arrive once."""
    database.lose = ["after", "before", "", "break", "after", "before", "after", ""]
    with Outbox(tmp_path / "outbox.sqlite") as box:
        for number in range(6):
            box.add(document(number), [Part("png", "a.png", PNG)] if number % 2 else [])
            box.add(document(number), [Part("png", "a.png", PNG)] if number % 2 else [])  # twice
        assert len(box.items()) == 6
    for _ in range(20):
        with Outbox(tmp_path / "outbox.sqlite") as box:  # as after a restart
            try:
                box.send(client)
            except ServerUnreachable:
                continue
            if all(item.state == "stored" for item in box.items()):
                break
    with Outbox(tmp_path / "outbox.sqlite") as box:
        assert [(item.state, item.problem) for item in box.items()] == [("stored", "")] * 6
        box.send(client)  # there is nothing left to do
    densities = [row["entries"][0]["property_element"][0]["value"] for row in database.uploads()]
    assert sorted(densities) == [560.0 + number for number in range(6)]
    assert database.posts > 6


def test_an_upload_at_which_the_server_always_breaks_is_given_up(
    database: Any, client: Client, tmp_path: Path
) -> None:
    database.lose = ["break"] * MAX_ATTEMPTS
    with Outbox(tmp_path / "outbox.sqlite") as box:
        box.add(document())
        for _ in range(MAX_ATTEMPTS):
            box.send(client)
        (item,) = box.items()
        assert item.state == "refused"
        assert "OperationalError" in item.problem
        box.send(client)
    assert not database.uploads()


def test_a_wrong_password_loses_nothing(database: Any, client: Client, tmp_path: Path) -> None:
    with Outbox(tmp_path / "outbox.sqlite") as box:
        box.add(document())
        with pytest.raises(ServerRefused, match="401"):
            box.send(Client(Connection(database.url, USER, "wrong")))
        (item,) = box.send(client)
        assert item.state == "stored"
    assert len(database.uploads()) == 1


def test_a_box_refuses_what_can_not_be_uploaded(tmp_path: Path) -> None:
    with Outbox(tmp_path / "outbox.sqlite") as box:
        with pytest.raises(InvalidInput, match="no devices"):
            box.add(replace(document(), setup={}, sensor_outputs={}))
        assert not box.items()
    (tmp_path / "letter").write_text("dear database, " * 100)
    with pytest.raises(InvalidInput, match="letter"):
        Outbox(tmp_path / "letter")
