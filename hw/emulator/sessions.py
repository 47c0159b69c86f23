"""The emulated arm's sessions: who is logged in from where, who is in control, who was silent too long."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass

from hw.kortex import messages_pb2 as pb

INVALID_PASSWORD, USER_NOT_FOUND = 15, 16
INVALID_SESSION, FOREIGN_SESSION, NOT_IN_CONTROL = 12, 54, 130
SERVER, DEVICE = 1, 3


class Refusal(Exception):
    """A request that the arm answers with an error."""

    def __init__(self, code: int, sub_code: int, words: str) -> None:
        super().__init__(words)
        self.code, self.sub_code, self.words = code, sub_code, words


@dataclass
class Session:
    """A client that is logged in.

    Attributes:
        number: what the arm calls it.
        client: the connection or address it belongs to.
        allowance: how long it may be silent [s].
        heard: when it was heard last [s].
    """

    number: int
    client: Hashable
    allowance: float
    heard: float


class Sessions:
    """All sessions of the arm.

    Args:
        users: passwords by name.
    """

    def __init__(self, users: dict[str, str]) -> None:
        self._users = users
        self._open: dict[int, Session] = {}
        self._next = 0
        self.control: int | None = None

    def open(self, client: Hashable, request: pb.CreateSessionInfo, now: float) -> Session:
        """Log a client in; what it had open before is closed."""
        if request.username not in self._users:
            raise Refusal(DEVICE, USER_NOT_FOUND, "no such user")
        if request.password != self._users[request.username]:
            raise Refusal(DEVICE, INVALID_PASSWORD, "wrong password")
        self.forget(client)
        self._next = self._next % 0xFFFF + 1
        while self._next in self._open:
            self._next = self._next % 0xFFFF + 1
        silent = [t for t in (request.session_inactivity_timeout, request.connection_inactivity_timeout) if t]
        session = Session(self._next, client, min(silent, default=60_000) / 1000, now)
        self._open[session.number] = session
        return session

    def find(self, number: int, client: Hashable, now: float) -> Session:
        """Return the session of a request."""
        session = self._open.get(number)
        if session is None:
            raise Refusal(SERVER, INVALID_SESSION, "there is no such session")
        if session.client != client:
            raise Refusal(SERVER, FOREIGN_SESSION, "the session belongs to another connection")
        session.heard = now
        return session

    def take_control(self, session: Session) -> None:
        """Give a session control of the arm, unless another one has it."""
        if self.control not in (None, session.number):
            raise Refusal(DEVICE, NOT_IN_CONTROL, "another session controls the arm")
        self.control = session.number

    def close(self, session: Session) -> None:
        """End a session."""
        self._open.pop(session.number, None)
        if self.control == session.number:
            self.control = None

    def forget(self, client: Hashable) -> None:
        """End the sessions of a connection that is gone."""
        for session in [s for s in self._open.values() if s.client == client]:
            self.close(session)

    def expire(self, now: float) -> list[Hashable]:
        """End the sessions that were silent for too long; return whose they were."""
        late = [s for s in self._open.values() if now - s.heard > s.allowance]
        for session in late:
            self.close(session)
        return [session.client for session in late]
