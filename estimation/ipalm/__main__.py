"""``python -m estimation.ipalm``: runs to an IPALM object database, and references from it.

User and password come from the variables IPALM_USER and IPALM_PASSWORD, or are asked for; they are never kept.
"""

from __future__ import annotations

import argparse
import getpass
import json
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from dynamics.command_line import interrupted
from dynamics.errors import InvalidInput, PalpateError

WRONG_INPUT, FAILED = 2, 1


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return its exit code."""
    given = _parser().parse_args(arguments)
    from estimation.ipalm.http import ServerFailed, ServerUnreachable

    try:
        status: int = given.command(given)
    except (ServerUnreachable, ServerFailed) as error:
        print(f"estimation.ipalm: {error}", file=sys.stderr)
        return FAILED
    except PalpateError as error:
        print(f"estimation.ipalm: {error}", file=sys.stderr)
        return WRONG_INPUT
    except KeyboardInterrupt:
        return interrupted("estimation.ipalm")
    return status


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m estimation.ipalm", description="Exchange measurements with an IPALM object database."
    )
    box = argparse.ArgumentParser(add_help=False)
    box.add_argument("--outbox", type=Path, default=Path("runs/outbox.sqlite"), metavar="FILE")
    commands = parser.add_subparsers(required=True)
    queue = commands.add_parser("queue", parents=[box], help="put runs into the outbox")
    queue.add_argument("run", nargs="+", type=Path)
    queue.add_argument("--dataset", default="palpate", help="data set that the object belongs to")
    queue.add_argument("--dataset-id", default="", help="its name there (default: as in the run)")
    queue.add_argument("--image", type=Path, metavar="FILE", help="PNG or JPEG of the scene")
    queue.add_argument("--no-series", action="store_true", help="leave out what the sensors read")
    queue.set_defaults(command=_queue)
    send = commands.add_parser("send", parents=[box], help="upload what is in the outbox")
    send.add_argument("--server", required=True, metavar="URL")
    send.set_defaults(command=_send)
    show = commands.add_parser("show", parents=[box], help="what is in the outbox")
    show.set_defaults(command=_show)
    learn = commands.add_parser("learn", help="a reference file from the objects in the database")
    learn.add_argument("--server", required=True, metavar="URL")
    learn.add_argument("--class", dest="classes", action="append", default=[], metavar="OBJECT=MATERIAL")
    learn.add_argument("--name", default="ipalm")
    learn.add_argument("--out", type=Path, required=True, metavar="FILE")
    learn.set_defaults(command=_learn)
    return parser


def _queue(given: argparse.Namespace) -> int:
    from estimation.ipalm.documents import ObjectInstance
    from estimation.ipalm.from_run import document_of
    from estimation.ipalm.http import Part
    from estimation.ipalm.outbox import Outbox
    from estimation.recording import read_recording

    parts = []
    if given.image is not None:
        try:
            parts = [Part("measurement png", given.image.name, given.image.read_bytes())]
        except OSError as error:
            raise InvalidInput(str(given.image), error.strerror or str(error), "a readable image") from None
    with Outbox(given.outbox) as outbox:
        for path in given.run:
            recording = read_recording(path)
            name = recording.object_name
            instance = ObjectInstance(given.dataset, given.dataset_id or name, None, name)
            identity = outbox.add(document_of(recording, instance, not given.no_series), parts)
            print(f"{path}: {identity}")
    return 0


def _send(given: argparse.Namespace) -> int:
    from estimation.ipalm.client import Client
    from estimation.ipalm.http import Connection
    from estimation.ipalm.outbox import STORED, Item, Outbox

    user = os.environ.get("IPALM_USER") or input("user: ")
    password = os.environ.get("IPALM_PASSWORD") or getpass.getpass()
    client = Client(Connection(given.server, user, password))

    def tell(item: Item) -> None:
        print(f"{item.identity}: {item.state} {item.url} {item.problem}".rstrip(), flush=True)

    with Outbox(given.outbox) as outbox:
        items = outbox.send(client, tell)
    lost = [item for item in items if item.state != STORED or item.problem]
    print(f"{len(items) - len(lost)} of {len(items)} are stored whole", file=sys.stderr)
    return FAILED if lost else 0


def _show(given: argparse.Namespace) -> int:
    from estimation.ipalm.outbox import Outbox

    with Outbox(given.outbox) as outbox:
        for item in outbox.items():
            print(f"{item.identity}: {item.state} {item.url} {item.problem}".rstrip())
    return 0


def _learn(given: argparse.Namespace) -> int:
    from estimation.ipalm.client import Client
    from estimation.ipalm.documents import measurements_of
    from estimation.ipalm.http import Connection
    from estimation.recording.files import write_atomically
    from estimation.store.learning import Observation, learn_classes, reference_content

    classes = {}
    for pair in given.classes:
        name, equals, material = pair.partition("=")
        if not (name and equals and material):
            raise InvalidInput("--class", pair, "OBJECT=MATERIAL")
        classes[name] = material
    rows, left_out = [], 0
    for document in Client(Connection(given.server)).documents():
        instance = document.object_instance
        name = instance.common_name or instance.dataset_id or "unnamed"
        found, notes = measurements_of(document)
        left_out += len(notes)
        identity = f"{instance.dataset}/{instance.dataset_id}/{instance.maker}/{name}"
        rows += [Observation(identity, classes.get(name, name), one) for one in found]
    learned = learn_classes(rows)
    content = reference_content(given.name, learned, f"learned from {given.server}")
    write_atomically(given.out, json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False) + "\n")
    print(f"{len(rows)} values of {len(learned)} classes and properties; {left_out} values left out")
    return 0


if __name__ == "__main__":
    sys.exit(main())
