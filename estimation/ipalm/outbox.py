"""What is to be uploaded, kept on disk until the database is seen to have it: once, and not twice.

A document's identity is a digest of its content, so that queueing it twice is queueing it once. Before an upload
is tried again, the database is searched for it.
"""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
import sqlite3
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Self

from dynamics.errors import InvalidInput
from estimation.ipalm.client import Client, Stored, check, with_identity
from estimation.ipalm.documents import Document, from_json, to_json
from estimation.ipalm.http import Part, ServerFailed, ServerRefused
from estimation.recording.files import CannotRecord

WAITING, SENDING, STORED, REFUSED = "waiting", "sending", "stored", "refused"
MAX_ATTEMPTS = 5  # of an upload at which the server breaks
_CLOCK_ERROR = timedelta(days=1)  # by which the server's clock may differ from ours

_TABLES = """
CREATE TABLE IF NOT EXISTS item (
    identity TEXT PRIMARY KEY, queued TEXT NOT NULL, document TEXT NOT NULL, state TEXT NOT NULL,
    attempts INTEGER NOT NULL DEFAULT 0, url TEXT NOT NULL DEFAULT '', problem TEXT NOT NULL DEFAULT ''
);
CREATE TABLE IF NOT EXISTS part (
    identity TEXT NOT NULL REFERENCES item(identity),
    field TEXT NOT NULL, name TEXT NOT NULL, content BLOB NOT NULL
);
"""


@dataclass(frozen=True)
class Item:
    """An upload in the box.

    Attributes:
        identity: of its content.
        state: ``waiting``; ``sending`` if an attempt had no answer; ``stored``; ``refused``.
        attempts: how often it was tried.
        url: where the database keeps it, once stored.
        problem: why it was refused, or how what is stored differs.
    """

    identity: str
    state: str
    attempts: int
    url: str
    problem: str


class Outbox:
    """Uploads in an SQLite file.

    Args:
        path: the file; made if need be.

    Raises:
        InvalidInput: if it is another kind of file.
        CannotRecord: if it can not be written.
    """

    def __init__(self, path: Path) -> None:
        self.path = Path(path)
        with self._errors():
            self._database = sqlite3.connect(self.path, timeout=30)
            self._database.execute("PRAGMA journal_mode=WAL")
            self._database.execute("PRAGMA synchronous=FULL")
            self._database.executescript(_TABLES)

    def close(self) -> None:
        """Close the box."""
        self._database.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def add(self, document: Document, parts: Sequence[Part] = ()) -> str:
        """Queue a document with its files; return its identity. What is in the box already is not added again.

        Raises:
            InvalidInput: for what the database would spoil.
        """
        check(document, parts)
        identity = identity_of(document, parts)
        text = to_json(document, allow_nan=False)
        with self._errors(), self._database:
            row = (identity, datetime.now(UTC).isoformat(), text, WAITING)
            added = self._database.execute(
                "INSERT OR IGNORE INTO item (identity, queued, document, state) VALUES (?, ?, ?, ?)", row
            )
            if added.rowcount:
                files = [(identity, part.field, part.name, part.content) for part in parts]
                self._database.executemany("INSERT INTO part VALUES (?, ?, ?, ?)", files)
        return identity

    def items(self) -> tuple[Item, ...]:
        """Return what is in the box, in the order it was queued."""
        query = "SELECT identity, state, attempts, url, problem FROM item ORDER BY queued, identity"
        with self._errors():
            return tuple(Item(*row) for row in self._database.execute(query))

    def send(self, client: Client, told: Callable[[Item], None] = lambda item: None) -> tuple[Item, ...]:
        """Upload what waits; return what is in the box then.

        Args:
            client: of the database.
            told: called with every item that was dealt with.

        Raises:
            ServerUnreachable: when there is no answer; the rest waits for the next call.
            ServerRefused: when the user is not allowed to upload.
            InvalidInput: if another process is sending from this box.
        """
        with self._alone():
            for item in self.items():
                if item.state in (WAITING, SENDING):
                    self._send(item, client)
                    told(next(one for one in self.items() if one.identity == item.identity))
        return self.items()

    def _send(self, item: Item, client: Client) -> None:
        document, parts, queued = self._content(item.identity)
        try:
            stored = None
            if item.state == SENDING:  # tried before, without an answer
                stored = self._find(item.identity, client, document, queued)
            if stored is None:
                self._update(item.identity, SENDING, attempts=item.attempts + 1)
                stored = client.upload(document, item.identity, parts)
        except ServerRefused as error:
            if error.status in (401, 403, 429):
                self._update(item.identity, WAITING, problem=str(error))
                raise
            self._update(item.identity, REFUSED, problem=str(error))
            return
        except ServerFailed as error:
            stored = self._find(item.identity, client, document, queued)
            if stored is None:
                state = REFUSED if item.attempts + 1 >= MAX_ATTEMPTS else SENDING
                self._update(item.identity, state, problem=str(error))
                return
        self._update(item.identity, STORED, url=stored.url, problem="; ".join(stored.differences))

    def _find(self, identity: str, client: Client, document: Document, queued: str) -> Stored | None:
        since = (datetime.fromisoformat(queued) - _CLOCK_ERROR).strftime("%Y-%m-%dT%H:%M")
        url = client.find(identity, since)
        return None if url is None else client.compare(url, with_identity(document, identity))

    def _content(self, identity: str) -> tuple[Document, list[Part], str]:
        with self._errors():
            query = "SELECT document, queued FROM item WHERE identity = ?"
            text, queued = self._database.execute(query, (identity,)).fetchone()
            query = "SELECT field, name, content FROM part WHERE identity = ?"
            parts = [Part(*row) for row in self._database.execute(query, (identity,))]
        return from_json(text, f"{self.path}: {identity}"), parts, queued

    def _update(
        self, identity: str, state: str, attempts: int | None = None, url: str = "", problem: str = ""
    ) -> None:
        with self._errors(), self._database:
            query = "UPDATE item SET state=?, attempts=ifnull(?, attempts), url=?, problem=? WHERE identity=?"
            self._database.execute(query, (state, attempts, url, problem, identity))

    @contextmanager
    def _alone(self) -> Iterator[None]:
        """Keep other processes from sending the same things at the same time."""
        lock = os.open(f"{self.path}.lock", os.O_RDWR | os.O_CREAT, 0o600)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            yield
        except BlockingIOError:
            raise InvalidInput(f"outbox {self.path}", "another process that is sending", "one at a time") from None
        finally:
            os.close(lock)

    @contextmanager
    def _errors(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.OperationalError as error:
            raise CannotRecord(f"outbox {self.path}: {error}") from error
        except sqlite3.DatabaseError as error:
            raise InvalidInput(f"outbox {self.path}", str(error), "an outbox, or no file") from None


def identity_of(document: Document, parts: Sequence[Part] = ()) -> str:
    """Return a digest of a document and its files."""
    digest = hashlib.sha256(json.dumps(json.loads(to_json(document)), sort_keys=True).encode())
    for part in parts:
        digest.update(f"\0{part.field}\0{part.name}\0{len(part.content)}\0".encode() + part.content)
    return digest.hexdigest()[:32]
