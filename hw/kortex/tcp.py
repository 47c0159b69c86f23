"""A session over TCP: requests from any thread, notifications, and keep-alive."""

from __future__ import annotations

import contextlib
import logging
import socket
import threading
import time
from collections.abc import Callable

from hw.kortex import messages_pb2 as pb
from hw.kortex import methods
from hw.kortex.errors import ConnectionFailed, ConnectionLost, FrameError, KortexError, RpcTimeout
from hw.kortex.exchange import Credentials, Timeouts, answer, request_frame, session_request
from hw.kortex.frame import Frame, FrameType, StreamDecoder, encode_stream
from hw.kortex.methods import A, Method, Q
from hw.kortex.ports import TCP_PORT

log = logging.getLogger(__name__)
NotificationSink = Callable[[bytes], None]


class _Waiter:
    """A request that waits for its answer."""

    def __init__(self) -> None:
        self.done = threading.Event()
        self.frame: Frame | None = None


class TcpSession:
    """A connection to the arm with a session of its own.

    A thread reads what arrives and hands answers to the requests that wait for them; another asks for
    nothing whenever nothing was asked for a while, so that the arm keeps the session.

    Attributes:
        host, port: where the arm is.
        session: the number the arm gave the session.
    """

    def __init__(
        self, host: str, credentials: Credentials, port: int = TCP_PORT, timeouts: Timeouts | None = None
    ) -> None:
        self.host, self.port, self.session = host, port, 0
        self.timeouts = timeouts or Timeouts()
        self._decoder = StreamDecoder()
        self._lock = threading.Lock()
        self._number = 0
        self._waiting: dict[int, _Waiter] = {}
        self._sinks: dict[int, NotificationSink] = {}
        self._early: dict[int, list[bytes]] = {}
        self._lost: KortexError | None = None
        self._closing = threading.Event()
        self._sent = time.monotonic()
        self._socket = _connect(host, port, self.timeouts.connect)
        self._threads = [
            threading.Thread(target=self._read, name="kortex-tcp", daemon=True),
            threading.Thread(target=self._keep_alive, name="kortex-keep-alive", daemon=True),
        ]
        self._threads[0].start()
        try:
            self.request(methods.CREATE_SESSION, session_request(credentials, self.timeouts))
        except BaseException:
            self._shut()
            raise
        self._threads[1].start()

    @property
    def lost(self) -> KortexError | None:
        """Why the connection is gone, None while it stands."""
        return self._lost

    def request(
        self, method: Method[Q, A], message: Q | None = None, device: int = 0, timeout: float | None = None
    ) -> A:
        """Ask for a method and return the answer.

        Args:
            method: what is asked for.
            message: its argument; left out for a method without one.
            device: the device it is routed to, 0 for the base.
            timeout: how long to wait for the answer [s]; the session's own if left out.

        Raises:
            RpcError: if the arm refuses it.
            RpcTimeout: if no answer comes in time.
            ConnectionLost: if the connection breaks.
        """
        waiter = _Waiter()
        with self._lock:
            self._check()
            self._number = self._number % 0xFFFF + 1
            number = self._number
            self._waiting[number] = waiter
            try:
                frame = request_frame(method, message or method.request(), number, self.session, device)
                self._socket.sendall(encode_stream(frame))
                self._sent = time.monotonic()
            except OSError as error:
                self._fail(ConnectionLost(f"connection to {self.host}:{self.port} broke: {error}"))
                self._check()
            except BaseException:
                self._waiting.pop(number, None)
                raise
        try:
            if not waiter.done.wait(self.timeouts.request if timeout is None else timeout):
                raise RpcTimeout(f"{self.host}:{self.port} did not answer {method.name} in time")
        finally:
            self._waiting.pop(number, None)
        if waiter.frame is None:
            self._check()
            raise ConnectionLost(f"connection to {self.host}:{self.port} was closed")
        if waiter.frame.session:
            self.session = waiter.frame.session
        return answer(method, waiter.frame)

    def subscribe(
        self, topic: Method[pb.NotificationOptions, pb.NotificationHandle], sink: NotificationSink
    ) -> int:
        """Hand the payload of every notification of a topic to a function; return the subscription's number."""
        handle = self.request(topic, pb.NotificationOptions())
        for payload in self._early.pop(handle.identifier, []):
            sink(payload)
        self._sinks[handle.identifier] = sink
        return int(handle.identifier)

    def close(self) -> None:
        """Close the session and the connection; again and again without harm."""
        if self._closing.is_set():
            return
        if self._lost is None:
            with contextlib.suppress(KortexError):
                self.request(methods.CLOSE_SESSION, timeout=0.5)
        self._shut()

    def _shut(self) -> None:
        self._closing.set()
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        for thread in self._threads:
            if thread.is_alive() and thread is not threading.current_thread():
                thread.join(1.0)
        self._socket.close()
        self._fail(ConnectionLost(f"connection to {self.host}:{self.port} was closed"))

    def _check(self) -> None:
        if self._lost is not None:
            raise self._lost

    def _fail(self, error: KortexError) -> None:
        """Remember why the connection is gone and wake whoever waits."""
        if self._lost is None:
            self._lost = error
        for waiter in list(self._waiting.values()):
            waiter.done.set()

    def _read(self) -> None:
        """Hand on what arrives, until the connection ends."""
        try:
            while data := self._socket.recv(65536):
                for frame in self._decoder.feed(data):
                    self._take(frame)
            self._fail(ConnectionLost(f"{self.host}:{self.port} closed the connection"))
        except FrameError as error:
            self._fail(ConnectionLost(f"{self.host}:{self.port} sent {error}"))
        except OSError as error:
            self._fail(ConnectionLost(f"connection to {self.host}:{self.port} broke: {error}"))

    def _take(self, frame: Frame) -> None:
        if frame.type is FrameType.RESPONSE:
            waiter = self._waiting.get(frame.message)
            if waiter is not None:
                waiter.frame = frame
                waiter.done.set()
        elif frame.type is FrameType.NOTIFICATION:
            sink = self._sinks.get(frame.message)
            if sink is not None:
                sink(frame.payload)
            elif len(self._early) < 16:  # the first may overtake the answer to its own subscription
                self._early.setdefault(frame.message, []).append(frame.payload)
                del self._early[frame.message][:-16]
        elif frame.type is FrameType.PING:
            pong = Frame(FrameType.PONG, frame.method, frame.message, frame.session)
            with self._lock, contextlib.suppress(OSError):
                self._socket.sendall(encode_stream(pong))

    def _keep_alive(self) -> None:
        period = min(self.timeouts.connection, self.timeouts.session) / 4
        while not self._closing.wait(period / 4):
            if self._lost is not None:
                return
            if time.monotonic() - self._sent < period:
                continue
            try:
                self.request(methods.KEEP_ALIVE)
            except KortexError as error:
                log.warning("keep-alive: %s", error)


def _connect(host: str, port: int, timeout: float) -> socket.socket:
    """Return a connected socket that sends without delay."""
    try:
        connection = socket.create_connection((host, port), timeout=timeout)
    except TimeoutError:
        raise ConnectionFailed(f"{host}:{port} does not answer (waited {timeout:g} s)") from None
    except socket.gaierror as error:
        raise ConnectionFailed(f"host {host!r} is unknown: {error.strerror}") from None
    except (OSError, UnicodeError, OverflowError) as error:
        raise ConnectionFailed(f"no connection to {host}:{port}: {error}") from None
    connection.settimeout(None)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return connection
