"""The emulator's sockets: one loop over TCP connections, datagrams, faults and the clock."""

from __future__ import annotations

import contextlib
import heapq
import logging
import queue
import selectors
import socket
import threading
import time
from collections.abc import Callable, Hashable, Iterable
from dataclasses import dataclass, field
from functools import partial
from types import TracebackType

import numpy as np

from dynamics.errors import PalpateError
from hw.emulator.backend import Backend
from hw.emulator.faults import Fault
from hw.emulator.services import Identity, Services
from hw.kortex.errors import FrameError
from hw.kortex.frame import MAX_DATAGRAM, Frame, FrameType, StreamDecoder, decode, encode, encode_stream

log = logging.getLogger(__name__)

TICK = 0.005  # s between looks at the clock
CYCLIC_SERVICE = 3
MAX_UNSENT = 1 << 20  # bytes; a client that does not read them is dropped


@dataclass(frozen=True)
class Settings:
    """How the emulator is set up.

    Attributes:
        host: address to listen at.
        tcp_port, udp_port: 0 for any that is free.
        users: passwords by name.
        command_period: requests on TCP are looked at this often [s], as on the arm; at once if 0.
        identity: what the arm says it is.
        seed: of lost datagrams.
    """

    host: str = "127.0.0.1"
    tcp_port: int = 10000
    udp_port: int = 10001
    users: dict[str, str] = field(default_factory=lambda: {"admin": "admin"}, repr=False)
    command_period: float = 0.025
    identity: Identity = field(default_factory=Identity)
    seed: int = 0


class _Client:
    """A TCP connection."""

    def __init__(self, connection: socket.socket) -> None:
        self.socket = connection
        self.decoder = StreamDecoder()
        self.unsent = bytearray()


class Emulator:
    """A server that speaks the protocol for a robot; runs in a thread of its own between enter and exit.

    Attributes:
        tcp_port, udp_port: where it listens.
        backend: the robot.
    """

    def __init__(self, backend: Backend, settings: Settings | None = None, faults: Iterable[Fault] = ()) -> None:
        self.settings = settings or Settings()
        self.backend = backend
        self.services = Services(backend, self.settings.users, self.settings.identity, self._notify)
        self._rng = np.random.default_rng(self.settings.seed)
        self._loss = self._delay = 0.0
        self._silent = self._mute = False
        self._pending: list[tuple[_Client, Frame]] = []
        self._later: list[tuple[float, int, Callable[[], None]]] = []
        self._timed: list[Fault] = []
        self._motions_seen = 0
        self._order = 0
        self._inbox: queue.SimpleQueue[Fault] = queue.SimpleQueue()
        self._clients: set[_Client] = set()
        self._selector = selectors.DefaultSelector()
        self._listener, self._datagrams = self._bind()
        self.tcp_port: int = self._listener.getsockname()[1]
        self.udp_port: int = self._datagrams.getsockname()[1]
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self.serve, name="emulator", daemon=True)
        for fault in faults:
            self.inject(fault)

    def __enter__(self) -> Emulator:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def inject(self, fault: Fault | str) -> None:
        """Let something go wrong, now or some time into the next motion; from any thread."""
        self._inbox.put(Fault.parse(fault) if isinstance(fault, str) else fault)

    def end(self) -> None:
        """Let the server end soon."""
        self._ending.set()

    def close(self) -> None:
        """End the server and wait for it."""
        self.end()
        if self._thread.is_alive():
            self._thread.join(2.0)

    def serve(self) -> None:
        """Serve until closed."""
        due = 0.0
        try:
            while not self._ending.is_set():
                for key, _ in self._selector.select(TICK if self.settings.command_period else TICK / 5):
                    key.data()
                now = time.monotonic()
                self._suffer()
                while self._later and self._later[0][0] <= now:
                    heapq.heappop(self._later)[2]()
                if now >= due:
                    due = now + self.settings.command_period
                    self._obey(now)
                self.services.poll()
        finally:
            for client in list(self._clients):
                self._drop(client)
            self._listener.close()
            self._datagrams.close()
            self._selector.close()
            self.backend.close()

    def _bind(self) -> tuple[socket.socket, socket.socket]:
        settings = self.settings
        listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        datagrams = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        for name, bound, port in (("TCP", listener, settings.tcp_port), ("UDP", datagrams, settings.udp_port)):
            try:
                bound.bind((settings.host, port))
            except (OSError, OverflowError) as error:
                listener.close()
                datagrams.close()
                raise PalpateError(f"cannot listen at {settings.host}:{port} ({name}): {error}") from None
            bound.setblocking(False)
        listener.listen()
        self._selector.register(listener, selectors.EVENT_READ, self._accept)
        self._selector.register(datagrams, selectors.EVENT_READ, self._datagram)
        return listener, datagrams

    # ---- TCP

    def _accept(self) -> None:
        with contextlib.suppress(BlockingIOError):
            connection, address = self._listener.accept()
            log.info("connection from %s:%s", *address)
            connection.setblocking(False)
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            client = _Client(connection)
            self._clients.add(client)
            self._selector.register(connection, selectors.EVENT_READ, lambda: self._stream(client))

    def _stream(self, client: _Client) -> None:
        """Take what arrives on a connection."""
        try:
            data = client.socket.recv(65536)
            if not data:
                self._drop(client)
                return
            for frame in client.decoder.feed(data):
                if frame.type is FrameType.REQUEST:
                    self._pending.append((client, frame))
                elif frame.type is FrameType.PING:
                    self._stream_out(client, Frame(FrameType.PONG, frame.method, frame.message, frame.session))
        except BlockingIOError:
            return
        except (OSError, FrameError) as error:
            log.info("connection dropped: %s", error)
            self._drop(client)

    def _obey(self, now: float) -> None:
        """Answer the requests that have come in on TCP."""
        pending, self._pending = self._pending, []
        for client, frame in pending:
            if client in self._clients and not self._mute:
                self._send(partial(self._stream_out, client, self.services.handle(frame, client, now)))
        for silent in self.services.sessions.expire(now):
            if isinstance(silent, _Client):
                log.info("a session was silent for too long")
                self._drop(silent)

    def _stream_out(self, client: _Client, frame: Frame) -> None:
        if client not in self._clients:
            return
        client.unsent += encode_stream(frame)
        try:
            del client.unsent[: client.socket.send(client.unsent)]
        except BlockingIOError:
            pass
        except OSError:
            self._drop(client)
            return
        if len(client.unsent) > MAX_UNSENT:
            self._drop(client)

    def _drop(self, client: _Client) -> None:
        if client in self._clients:
            self._clients.discard(client)
            self._selector.unregister(client.socket)
            client.socket.close()
            self.services.sessions.forget(client)

    def _notify(self, client: Hashable, frame: Frame) -> None:
        if isinstance(client, _Client):
            self._send(partial(self._stream_out, client, frame))

    # ---- UDP

    def _datagram(self) -> None:
        """Answer the datagrams that have come in."""
        with contextlib.suppress(BlockingIOError):
            while True:
                content, address = self._datagrams.recvfrom(MAX_DATAGRAM)
                if self._silent or self._mute or self._rng.random() < self._loss:
                    continue
                try:
                    frame = decode(content)
                except FrameError as error:
                    log.info("datagram dropped: %s", error)
                    continue
                if frame.type is FrameType.REQUEST:
                    reply = encode(self.services.handle(frame, address, time.monotonic()))
                    if self._rng.random() >= self._loss:
                        self._send(partial(self._datagram_out, reply, address))

    def _datagram_out(self, content: bytes, address: tuple[str, int]) -> None:
        with contextlib.suppress(OSError):
            self._datagrams.sendto(content, address)

    # ---- faults

    def _send(self, action: Callable[[], None]) -> None:
        """Send now, or later if everything is delayed."""
        if not self._delay:
            action()
            return
        self._schedule(time.monotonic() + self._delay, action)

    def _schedule(self, when: float, action: Callable[[], None]) -> None:
        self._order += 1
        heapq.heappush(self._later, (when, self._order, action))

    def _suffer(self) -> None:
        """Take in the faults that were asked for, and let those happen whose time has come."""
        with contextlib.suppress(queue.Empty):
            while True:
                fault = self._inbox.get_nowait()
                if fault.after is None:
                    self._happen(fault)
                else:
                    self._timed.append(fault)
                    self._motions_seen = self.services.motions
        if self._timed and self.services.motions > self._motions_seen:
            self._motions_seen = self.services.motions
            for fault in self._timed:
                self._schedule(time.monotonic() + (fault.after or 0.0), partial(self._happen, fault))
            self._timed.clear()

    def _happen(self, fault: Fault) -> None:
        log.warning("fault: %s %s", fault.name, fault.value)
        if fault.name == "loss":
            self._loss = fault.number()
        elif fault.name == "delay":
            self._delay = fault.number()
        elif fault.name == "drop":
            for client in list(self._clients):
                self._drop(client)
        elif fault.name == "silence":
            self._silent = True
        elif fault.name == "mute":
            self._mute = True
        elif fault.name == "fault":
            self.services.fail(*fault.bits())
        elif fault.name == "estop":
            self.services.fail(0, 0x800000)
        elif fault.name == "abort":
            self.services.abort()
        elif fault.name == "stuck-gripper":
            self.backend.jam()
        elif fault.name == "garbage":
            for client in list(self._clients):
                with contextlib.suppress(OSError):
                    client.socket.send(bytes(self._rng.integers(0, 256, 64, dtype=np.uint8)))
