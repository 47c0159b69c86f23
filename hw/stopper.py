"""Stopping the arm, also when the connection that moved it is gone."""

from __future__ import annotations

import logging
import math
import threading
import time

from hw.kortex import client
from hw.kortex.errors import KortexError
from hw.kortex.exchange import Credentials, Timeouts
from hw.kortex.tcp import TcpSession

log = logging.getLogger(__name__)

RESCUE = Timeouts(connect=0.4, request=0.4)
ONCE = 0.5  # s in which a second order to stop adds nothing


class Stopper:
    """Tells the arm to stop, from any thread.

    Args:
        session: the connection that is tried first.
        credentials: to log in on a new one.

    Attributes:
        unstopped: why the arm could not be told to stop, empty as long as it could.
    """

    def __init__(self, session: TcpSession, credentials: Credentials) -> None:
        self._session, self._credentials = session, credentials
        self._lock = threading.Lock()
        self._done_at = -math.inf
        self.unstopped = ""

    def stop(self, again: bool = False) -> None:
        """Tell the arm to stop, over a new connection if this one is gone.

        Args:
            again: also if it was told so a moment ago.
        """
        with self._lock:
            if time.monotonic() - self._done_at < ONCE and not again:
                return
            try:
                client.stop(self._session)
                self.unstopped = ""
            except KortexError as error:
                log.warning("stop: %s; trying a new connection", error)
                self.unstopped = self._rescue()
            self._done_at = time.monotonic()

    def _rescue(self) -> str:
        """Stop the arm over a connection of its own; return why that failed."""
        try:
            session = TcpSession(self._session.host, self._credentials, self._session.port, RESCUE)
            try:
                client.stop(session)
            finally:
                session.close()
        except KortexError as error:
            words = f"the arm could not be told to stop ({error}): press the emergency stop"
            log.critical("%s", words)
            return words
        return ""
