"""Reading the arm: a thread that asks for feedback at a steady rate and hands every reading on."""

from __future__ import annotations

import logging
import queue
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

from dynamics.errors import PalpateError
from dynamics.gripper import ParallelGripper
from hw.kortex import methods
from hw.kortex.errors import ConnectionLost, FeedbackLost, KortexError, RpcTimeout
from hw.kortex.udp import UdpSession
from hw.kortex.units import Array, Reading, reading

log = logging.getLogger(__name__)

BACKLOG = 20_000  # readings nobody took


@dataclass(frozen=True)
class FeedbackStatistics:
    """How the reading went so far.

    Attributes:
        readings: how many.
        repeats: datagrams that were sent again.
        late: answers that came after their question had been repeated; the other repeats were losses.
        longest_gap: the longest time between two readings [s].
        seconds: between the first reading and the last [s].
    """

    readings: int
    repeats: int
    late: int
    longest_gap: float
    seconds: float

    @property
    def rate(self) -> float:
        """Readings a second [Hz]."""
        return (self.readings - 1) / self.seconds if self.seconds > 0 else 0.0


class FeedbackReader:
    """Reads feedback until it is closed, or the arm falls silent.

    Args:
        session: to ask; used by this reader's thread alone from now on.
        gripper: converts its position.
        rate: readings a second [Hz].
        timeout: silence after which the feedback counts as lost [s].
        watch: looks at every reading as it comes; what it raises is the failure.
        failed: told once, by the reader's thread, what went wrong.
        torque_offset: what the torque sensors are known to read too much [N m], (nv,).
        clock: stamps the readings [s].
    """

    def __init__(
        self,
        session: UdpSession,
        gripper: ParallelGripper,
        rate: float,
        timeout: float,
        watch: Callable[[Reading], None],
        failed: Callable[[PalpateError], None],
        torque_offset: Array | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._session, self._gripper, self._period, self._timeout = session, gripper, 1 / rate, timeout
        self._watch, self._failed, self._clock = watch, failed, clock
        self._offset = torque_offset
        self._readings: queue.SimpleQueue[Reading] = queue.SimpleQueue()
        self._ending = threading.Event()
        self._near: Array | None = None
        self._count, self._gap, self._first, self._last = 0, 0.0, 0.0, 0.0
        self._told = False
        try:
            self.newest = self._read()
        except BaseException:
            session.close()
            raise
        self._thread = threading.Thread(target=self._run, name="kortex-feedback", daemon=True)
        self._thread.start()

    @property
    def statistics(self) -> FeedbackStatistics:
        """How the reading went so far."""
        return FeedbackStatistics(
            self._count, self._session.repeats, self._session.late, self._gap, self._last - self._first
        )

    def take(self, wait: float) -> list[Reading]:
        """Return what was read since the last call, waiting for a reading if there is none [s]."""
        try:
            taken = [self._readings.get(timeout=wait)]
        except queue.Empty:
            return []
        while not self._readings.empty():
            taken.append(self._readings.get_nowait())
        return taken

    def forget(self) -> None:
        """Drop what was read and not taken."""
        while not self._readings.empty():
            self._readings.get_nowait()

    def close(self) -> None:
        """Stop reading and end the session."""
        self._ending.set()
        if self._thread is not threading.current_thread():
            self._thread.join(1.0)
        self._session.close()

    def _run(self) -> None:
        due = time.monotonic()
        try:
            while not self._ending.is_set():
                due = max(due + self._period, time.monotonic())
                found = self._read()
                try:
                    self._watch(found)
                except PalpateError as error:
                    self._tell(error)
                if self._readings.qsize() < BACKLOG:
                    self._readings.put(found)
                self._ending.wait(max(due - time.monotonic(), 0.0))
        except PalpateError as error:
            self._tell(error)
        except Exception as error:
            log.exception("the feedback thread broke")
            self._tell(FeedbackLost(f"reading the feedback broke: {error!r}"))

    def _tell(self, error: PalpateError) -> None:
        if not self._told and not self._ending.is_set():
            self._told = True
            self._failed(error)

    def _read(self) -> Reading:
        """Return the next reading; what is lost on the way is asked for again until the time is over."""
        end = time.monotonic() + self._timeout
        while True:
            try:
                feedback = self._session.request(
                    methods.REFRESH_FEEDBACK, within=max(end - time.monotonic(), 1e-3)
                )
                break
            except ConnectionLost as error:
                if time.monotonic() > end:
                    raise FeedbackLost(f"no feedback for {self._timeout:g} s: {error}") from None
                self._ending.wait(0.005)
            except RpcTimeout:
                raise FeedbackLost(f"no feedback for {self._timeout:g} s") from None
            except KortexError as error:
                raise FeedbackLost(f"the arm refuses feedback: {error}") from None
        now = self._clock()
        found = reading(feedback, now, self._gripper, self._near)
        self._near = found.sample.q
        if self._offset is not None:
            found = replace(found, sample=replace(found.sample, tau=found.sample.tau - self._offset))
        self._gap = max(self._gap, now - self._last) if self._count else 0.0
        self._first = now if not self._count else self._first
        self._count, self._last = self._count + 1, now
        self.newest = found
        return found
