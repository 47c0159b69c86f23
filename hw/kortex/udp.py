"""A session over UDP, for reading: short waits, and the same question again when an answer is lost."""

from __future__ import annotations

import contextlib
import socket
import time

from hw.kortex import methods
from hw.kortex.errors import ConnectionFailed, ConnectionLost, FrameError, KortexError, RpcTimeout
from hw.kortex.exchange import Credentials, Timeouts, answer, request_frame, session_request
from hw.kortex.frame import MAX_DATAGRAM, FrameType, decode, encode
from hw.kortex.methods import A, Method, Q
from hw.kortex.ports import UDP_PORT

MAX_QUEUED = 1000  # datagrams that are looked at for one answer


class UdpSession:
    """A session for methods that may be asked twice; for one thread.

    Attributes:
        host, port: where the arm is.
        session: the number the arm gave the session.
        repeats: how many datagrams were sent again.
        late: how many answers came after their question had been answered by a repetition.
    """

    def __init__(
        self, host: str, credentials: Credentials, port: int = UDP_PORT, timeouts: Timeouts | None = None
    ) -> None:
        self.host, self.port, self.session = host, port, 0
        self.timeouts = timeouts or Timeouts()
        self.repeats = self.late = 0
        self._number = 0
        try:
            self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            self._socket.connect((host, port))
        except (OSError, UnicodeError, OverflowError) as error:
            raise ConnectionFailed(f"no connection to {host}:{port} (UDP): {error}") from None
        try:
            self.request(
                methods.CREATE_SESSION,
                session_request(credentials, self.timeouts),
                within=self.timeouts.connect,
                each=0.1,
            )
        except RpcTimeout:
            self._socket.close()
            raise ConnectionFailed(f"{host}:{port} (UDP) does not answer") from None
        except ConnectionLost as error:
            self._socket.close()
            raise ConnectionFailed(f"no connection to {host}:{port} (UDP): {error}") from None
        except BaseException:
            self._socket.close()
            raise

    def request(
        self,
        method: Method[Q, A],
        message: Q | None = None,
        within: float | None = None,
        each: float | None = None,
    ) -> A:
        """Ask for a method, again and again, and return the first answer.

        An answer that comes late counts, to whichever of the questions it belongs.

        Args:
            method: what is asked for; it must not matter how often.
            message: its argument; left out for a method without one.
            within: how long to go on [s].
            each: how long to wait before asking again [s].

        Raises:
            RpcError: if the arm refuses it.
            RpcTimeout: if no answer comes in time.
            ConnectionLost: if nothing listens there any more.
        """
        argument = message or method.request()
        end = time.monotonic() + (self.timeouts.request if within is None else within)
        wait = self.timeouts.datagram if each is None else each
        asked: set[int] = set()
        while (now := time.monotonic()) < end:
            self._number = self._number % 0xFFFF + 1
            asked.add(self._number)
            self.repeats += len(asked) > 1
            self._send(encode(request_frame(method, argument, self._number, self.session)))
            reply = self._await(method, asked, min(now + wait, end))
            if reply is not None:
                return reply
        raise RpcTimeout(f"{self.host}:{self.port} (UDP) did not answer {method.name} in time")

    def close(self) -> None:
        """Close the session; again and again without harm."""
        if self._socket.fileno() < 0:
            return
        with contextlib.suppress(KortexError):
            self.request(methods.CLOSE_SESSION, within=0.05)
        self._socket.close()

    def _send(self, datagram: bytes) -> None:
        try:
            self._socket.send(datagram)
        except BlockingIOError:
            return
        except OSError as error:
            raise ConnectionLost(f"{self.host}:{self.port} (UDP): {error}") from None

    def _await(self, method: Method[Q, A], asked: set[int], end: float) -> A | None:
        """Return the answer to one of the open questions, None if none comes in time.

        What has arrived already is taken in any case: a busy machine may have let this thread wait.
        """
        for _ in range(MAX_QUEUED):
            self._socket.settimeout(max(end - time.monotonic(), 0.0))
            try:
                frame = decode(self._socket.recv(MAX_DATAGRAM))
            except (TimeoutError, BlockingIOError):
                return None
            except FrameError:
                continue
            except OSError as error:
                raise ConnectionLost(f"{self.host}:{self.port} (UDP): {error}") from None
            if frame.type is not FrameType.RESPONSE or frame.message not in asked:
                self.late += frame.type is FrameType.RESPONSE
                continue
            if frame.session:
                self.session = frame.session
            return answer(method, frame)
        return None
