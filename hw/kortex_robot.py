"""The Kinova Gen3 with a Robotiq 2F-85, over the Kortex protocol, as a robot.

Motions run over TCP in single-level servoing, where the arm itself closes the loops and validates every
trajectory; feedback is read over UDP by a thread of its own, which also enforces the limits.
"""

from __future__ import annotations

import contextlib
import logging
import math
import queue
import signal
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from types import FrameType, TracebackType
from typing import Any

import numpy as np

from dynamics.arm import Arm
from dynamics.errors import InvalidInput, MotionRefused, PalpateError
from dynamics.gripper import ParallelGripper
from dynamics.robot import GripResult, SampleSink
from dynamics.signals import Sample
from dynamics.trajectory import Trajectory
from hw.feedback import FeedbackReader, FeedbackStatistics
from hw.gripper_drive import GripperDrive
from hw.kortex import client, codes, units
from hw.kortex.client import ActionResult
from hw.kortex.errors import (
    ArmFault,
    CheckFailed,
    ConnectionLost,
    LimitExceeded,
    MotionTimeout,
    NotConfirmed,
    TrajectoryAborted,
)
from hw.kortex.exchange import Credentials
from hw.kortex.tcp import TcpSession
from hw.kortex.udp import UdpSession
from hw.kortex.units import Array, Reading
from hw.preflight import CheckReport, examine, identity_problems
from hw.safety import START_TOLERANCE, SafetyMonitor
from hw.settings import KortexSettings
from hw.stopper import Stopper
from hw.waypoints import waypoints
from models.robot import REVISIONS

log = logging.getLogger(__name__)

CHECK_SECONDS = 0.25  # s of readings that the check averages
LATE = 1.0  # s that a motion may take longer than planned
ARRIVAL_TIME = 0.5  # s for the joints to come to rest after the arm says it is done
ARRIVAL = 0.02  # rad between where a motion should end and where it ends
AT_REST = 0.01  # rad/s
CANDLE = 0.02  # rad of every joint from 0 in the candle pose
UNMOVED = 1e-4  # rad; a shorter way is no motion
Confirm = Callable[[str], bool]


class KortexRobot:
    """The arm, connected; a context manager that closes the connection.

    Nothing moves before the check has passed and the first motion was confirmed. From then on until it is closed,
    SIGTERM and SIGHUP leave through SystemExit, which stops the arm like any exception does. Once the arm cannot
    be trusted any more (feedback lost, fault, limit exceeded), it is told to stop and every further call raises
    the reason; connect anew after looking at it. In a dry run nothing moves and no sample is handed on:
    trajectories are checked here, the first one by the arm too, and `read` says where the arm would stand.

    Args:
        host: name or address of the arm.
        credentials: who logs in.
        settings: how it is driven.
        confirm: asked once, before the first motion; without it nothing moves.

    Raises:
        ConnectionFailed: if there is no arm.
        LoginRefused: if it does not know the user.
        CheckFailed: if it is another kind of arm.
    """

    def __init__(
        self,
        host: str,
        credentials: Credentials,
        settings: KortexSettings | None = None,
        confirm: Confirm | None = None,
    ) -> None:
        self.settings = settings = settings or KortexSettings()
        self._arms: dict[str, Arm] = {name: Arm.gen3(name, settings.vision) for name in REVISIONS}
        self._arm, self._gripper = self._arms[settings.revision], settings.gripper
        self._host, self._confirm = host, confirm
        self._monitor = SafetyMonitor(self._arm, settings.limits)
        self._path_monitor = SafetyMonitor(self._arm, settings.limits)
        self._sinks: list[SampleSink] = []
        self._events: queue.SimpleQueue[ActionResult] = queue.SimpleQueue()
        self._failure: PalpateError | None = None
        self._armed = self._closed = False
        self._handlers: dict[int, Any] = {}
        self._planned: Sample | None = None
        self._reader: FeedbackReader | None = None
        self._tcp = TcpSession(host, credentials, settings.tcp_port, settings.timeouts)
        self._stopper = Stopper(self._tcp, credentials)
        try:
            problems = identity_problems(client.product(self._tcp), self._arm.nv, settings.vision)
            if problems:
                raise CheckFailed(tuple(problems))
            client.on_action(self._tcp, self._events.put)
            udp = UdpSession(host, credentials, settings.udp_port, settings.timeouts)
            offset = None if settings.tare is None else settings.tare.offset
            timeout = settings.limits.feedback_timeout
            self._reader = FeedbackReader(
                udp, self._gripper, settings.rate, timeout, self._watch, self._trip, offset
            )
        except BaseException:
            self._tcp.close()
            raise

    def __enter__(self) -> KortexRobot:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @property
    def arm(self) -> Arm:
        """The description of the arm."""
        return self._arm

    @property
    def gripper(self) -> ParallelGripper:
        """The description of the gripper."""
        return self._gripper

    @property
    def arms(self) -> Mapping[str, Arm]:
        """The model of each hardware revision."""
        return self._arms

    @property
    def statistics(self) -> FeedbackStatistics:
        """How the reading of the feedback went so far."""
        return self._feedback.statistics

    @property
    def newest(self) -> Reading:
        """The newest reading, with state and faults."""
        return self._feedback.newest

    def listen(self, sink: SampleSink) -> None:
        """Hand every further sample to a function."""
        self._sinks.append(sink)

    def read(self) -> Sample:
        """Return the newest sample; in a dry run, where the arm would stand."""
        self._trusted()
        return self._planned or self._feedback.newest.sample

    def check(self) -> CheckReport:
        """Return what the check before the first motion finds; nothing moves. The gripper must be empty."""
        self._trusted()
        readings, end = [self._feedback.newest], time.monotonic() + CHECK_SECONDS
        self._feedback.forget()
        while time.monotonic() < end:
            readings += self._feedback.take(0.05)
            self._trusted()
        settings = self.settings
        report = examine(
            self._tcp, readings, self._arms, settings.revision, settings.vision, settings.torque_tolerance
        )
        try:
            self._path_monitor.check_reading(readings[-1])
        except LimitExceeded as error:
            report = replace(report, problems=(*report.problems, str(error)))
        except ArmFault:
            pass  # among the problems already
        return report

    def follow(self, trajectory: Trajectory) -> None:
        """Move the joints along a trajectory that starts where the arm stands, and end at rest.

        Raises:
            MotionRefused: if it starts elsewhere, leaves the limits, the arm finds fault with it, or the first
                motion is not confirmed.
            CheckFailed: if the check before the first motion fails.
            TrajectoryAborted: if the arm gives it up.
            MotionTimeout: if it does not end in time.
        """
        self._trusted()
        q = self.read().q
        trajectory = self._nearest_turn(trajectory, q)
        self._path_monitor.check_path(trajectory, q)
        self._permit()
        if np.abs(trajectory.q - q).max() <= UNMOVED:
            self.hold(trajectory.duration)
            return
        points = waypoints(trajectory, self.settings.limits.speed_share * self._arm.velocity_limit)
        command = client.waypoint_list(units.angles_to_arm(points.q).tolist(), points.durations.tolist())
        stands = self._feedback.newest.sample.q
        if np.abs(q - stands).max() <= START_TOLERANCE:  # the arm can judge a motion only from where it stands
            _refuse(client.validate(self._tcp, command))
        if self.settings.dry_run:
            self._planned = replace(self.read(), q=trajectory.q[-1], dq=np.zeros(self._arm.nv))
            return
        while not self._events.empty():
            self._events.get_nowait()
        with self._stopping():
            client.execute(self._tcp, command)
            self._await_end(float(points.durations.sum()))
            self._await_rest(trajectory.q[-1])

    def hold(self, seconds: float) -> None:
        """Stand still for a time [s]."""
        if not (math.isfinite(seconds) and seconds >= 0):
            raise InvalidInput("hold: seconds", seconds, "a number >= 0")
        self._trusted()
        if self.settings.dry_run:
            return
        with self._stopping():
            start = self._feedback.newest.sample.time
            while self._take()[-1].time - start < seconds:
                pass

    def grip(self, opening: float, speed: float, max_effort: float = math.inf) -> GripResult:
        """Drive the gripper to an opening [m] at a speed [m/s], or until its current exceeds a limit [A].

        Raises:
            InvalidInput: for numbers that make no sense.
            GripperStuck: if it neither moves nor presses.
        """
        if not 0 <= opening <= self._gripper.max_opening:
            raise InvalidInput("grip: opening", opening, f"0 to {self._gripper.max_opening} m")
        if not (math.isfinite(speed) and speed > 0 and max_effort > 0):
            raise InvalidInput("grip: speed and effort limit", (speed, max_effort), "numbers > 0")
        self._trusted()
        self._permit()
        if self.settings.dry_run:
            self._planned = replace(self.read(), opening=opening)
            return GripResult.REACHED
        with self._stopping():
            start = self._take()[-1]
            drive = GripperDrive(self._tcp, self._gripper, self._take, opening, speed, max_effort)
            return drive.run(start)

    def stop(self) -> None:
        """Stop all motion at once; the gripper keeps its grip."""
        self._stopper.stop(again=True)
        if self._stopper.unstopped:
            raise ConnectionLost(self._stopper.unstopped)

    def close(self) -> None:
        """Release the connection; the robot stands still."""
        if self._closed:
            return
        self._closed = True
        for number, handler in self._handlers.items():
            signal.signal(number, handler)
        self._feedback.close()
        self._tcp.close()

    def zero_torques(self) -> Array:
        """Zero the torque sensors of the arm, which stands in the candle pose; return what they read then [N m].

        The torques that the model has in this pose are zeroed away with the offsets; a tare finds them again.

        Raises:
            MotionRefused: if the arm is not in the candle pose or not still; nothing was changed then.
        """
        sample = self.read()
        away = np.abs(np.mod(sample.q + np.pi, 2 * np.pi) - np.pi).max()
        if away > CANDLE or np.abs(sample.dq).max() > AT_REST:
            raise MotionRefused(
                f"the arm is not in the candle pose: a joint is {np.degrees(away):.1f} deg away; valid: all "
                f"joints within {np.degrees(CANDLE):.1f} deg of 0, and still"
            )
        if self.settings.dry_run:
            return sample.tau
        for device in client.actuators(self._tcp):
            client.set_torque_offset(self._tcp, device, 0.0)
        time.sleep(0.1)
        return self.read().tau

    # ---- inside

    @property
    def _feedback(self) -> FeedbackReader:
        assert self._reader is not None
        return self._reader

    def _watch(self, reading: Reading) -> None:
        """Look at a reading as it comes; in the reader's thread."""
        if self._armed:
            self._monitor.check_reading(reading)

    def _trip(self, error: PalpateError) -> None:
        """Remember what went wrong and stop the arm; in the reader's thread, which must read on."""
        log.error("stopping the arm: %s", error)
        self._failure = error
        if not self.settings.dry_run:
            threading.Thread(target=self._stopper.stop, name="kortex-stop", daemon=True).start()

    def _trusted(self) -> None:
        """Raise the reason if the arm cannot be trusted any more."""
        if self._closed:
            raise ConnectionLost("the connection was closed by this program")
        if self._failure is not None:
            raise self._failure
        if self._tcp.lost is not None and not self._failure:
            raise self._tcp.lost

    def _permit(self) -> None:
        """Let the first motion pass only after the check, and after a person agreed."""
        if self._armed:
            return
        if not self.settings.dry_run:
            client.take_control(self._tcp)
        report = self.check()
        for warning in report.warnings:
            log.warning("%s", warning)
        if report.problems:
            raise CheckFailed(report.problems)
        if not self.settings.dry_run:
            question = f"The arm at {self._host} is about to move. Is its workspace clear?"
            if self._confirm is None or not self._confirm(question):
                raise NotConfirmed("the first motion was not confirmed; nothing has moved")
        if threading.current_thread() is threading.main_thread():
            for number in (signal.SIGTERM, signal.SIGHUP):
                self._handlers[number] = signal.signal(number, _leave)
        self._armed = True

    def _take(self) -> list[Sample]:
        """Wait for further samples, hand them to the listeners, and return them."""
        while True:
            readings = self._feedback.take(0.05)
            for found in readings:
                for sink in self._sinks:
                    sink(found.sample)
            self._trusted()
            if readings:
                return [found.sample for found in readings]

    def _await_end(self, duration: float) -> None:
        """Wait until the arm says the motion is over."""
        deadline = time.monotonic() + duration + LATE
        while time.monotonic() < deadline:
            self._take()
            with contextlib.suppress(queue.Empty):
                while not (event := self._events.get_nowait()).final:
                    pass
                if event.event == codes.ActionEvent.ABORT:
                    self._explain_abort()
                event.raise_if_aborted()
                return
        raise MotionTimeout(f"the arm did not end a motion of {duration:.1f} s within {LATE:g} s more")

    def _explain_abort(self) -> None:
        """Give the feedback time to say why the arm gave up."""
        end = time.monotonic() + 0.05
        while time.monotonic() < end:
            self._take()

    def _await_rest(self, goal: Array) -> None:
        """Wait until the joints rest, and see whether they are where they should be."""
        deadline = time.monotonic() + ARRIVAL_TIME
        sample = self._take()[-1]
        while np.abs(sample.dq).max() > AT_REST and time.monotonic() < deadline:
            sample = self._take()[-1]
        away = float(np.abs(sample.q - goal).max())
        if away > ARRIVAL:
            raise TrajectoryAborted(f"the arm ended a trajectory {away:.3f} rad from where it leads")

    def _nearest_turn(self, trajectory: Trajectory, q: Array) -> Trajectory:
        """Return the trajectory in the turns that the arm counts: a continuous joint may be whole turns off."""
        path = np.asarray(trajectory.q, float)
        if path.ndim != 2 or path.shape[1:] != q.shape or not np.all(np.isfinite(path)):
            raise InvalidInput("trajectory", f"shape {path.shape}", f"finite positions, (N, {len(q)})")
        turns = np.round((q - path[0]) / (2 * np.pi)) * np.isinf(self._arm.upper)
        return Trajectory(trajectory.time, path + 2 * np.pi * turns)

    @contextlib.contextmanager
    def _stopping(self) -> Iterator[None]:
        """Stop the arm if anything goes wrong inside, whatever it is; samples from before do not count."""
        self._feedback.forget()
        try:
            yield
        except BaseException as error:
            self._stopper.stop()
            if self._stopper.unstopped and isinstance(error, Exception):
                raise ConnectionLost(f"{error}; {self._stopper.unstopped}") from error
            raise


def _refuse(report: Any) -> None:
    """Raise MotionRefused if the arm found something wrong with waypoints."""
    names = codes.TRAJECTORY_ERRORS
    found = [
        f"{names.get(e.error_type, e.error_type)} at waypoint {e.waypoint_index + 1}: {e.message}"
        for e in report.trajectory_error_elements
    ]
    if found:
        raise MotionRefused(f"the arm refuses the trajectory: {'; '.join(found)}")


def _leave(number: int, frame: FrameType | None) -> None:
    """Turn a signal into an exception, which stops the arm on its way out."""
    raise SystemExit(128 + number)
