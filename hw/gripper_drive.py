"""Driving the gripper by speed and position commands until it is there, meets its limit, or is found stuck."""

from __future__ import annotations

from collections.abc import Callable

from dynamics.gripper import ParallelGripper
from dynamics.robot import GripResult
from dynamics.signals import Sample
from hw.kortex import client, units
from hw.kortex.errors import GripperStuck
from hw.kortex.tcp import TcpSession

LATENCY = 0.015  # s from a reading until a command is obeyed: the arm looks at commands every 25 ms
TOLERANCE_QUANTA = 2.5  # steps of the reported opening; a command of 0.99 was seen to settle at 0.9869
STANDSTILL = 0.4  # s without a step of the opening
SETTLED = 0.05  # s without a step after which the pads stand
RESEND = 0.25  # s
CONTACT_CURRENT = 0.15  # A; a gripper that stands reads 0.05, one that cannot go on against something near 1
OWN_ACCURACY = 0.002  # m that the gripper may settle beside its target
MAX_SECONDS = 12.0  # s; the whole stroke at the lowest speed takes 4.3


class GripperDrive:
    """One motion of the gripper.

    It runs at the asked speed, which only the speed mode knows, and is stopped so that it comes to rest at the
    target; a position command corrects what is left beyond the tolerance. A command may get lost or fall short,
    so it is sent again as long as nothing is reached.

    Args:
        session: to command the arm.
        gripper: converts to its units.
        take: waits for further samples and returns them.
        opening: where to go [m].
        speed: how fast [m/s].
        max_effort: motor current at which to stop [A].
    """

    def __init__(
        self,
        session: TcpSession,
        gripper: ParallelGripper,
        take: Callable[[], list[Sample]],
        opening: float,
        speed: float,
        max_effort: float,
    ) -> None:
        self._session, self._gripper, self._take = session, gripper, take
        self._opening, self._max_effort = opening, max_effort
        self._share = units.speed_share(gripper, speed)
        self._speed = units.speed_from_share(gripper, self._share)
        self._tolerance = TOLERANCE_QUANTA * gripper.opening_quantum
        self._peak = self._stepped = 0.0
        self._closing = True

    def run(self, start: Sample) -> GripResult:
        """Go there from the sample at the start.

        Raises:
            GripperStuck: if the gripper neither moves nor presses.
        """
        if abs(self._opening - start.opening) <= self._tolerance:
            return GripResult.REACHED
        self._closing = self._opening < start.opening
        sign = 1 if self._closing else -1
        result = self._go(lambda: client.gripper_speed(self._session, sign * self._share), self._ahead)
        client.gripper_speed(self._session, 0.0)
        if result is None:
            self._go(lambda: None, lambda newest: newest.time - self._stepped < SETTLED)
            if abs(self._take()[-1].opening - self._opening) > self._tolerance:
                result = self._correct()
        return result or GripResult.REACHED

    def _correct(self) -> GripResult | None:
        """Go the rest by a position command; return what ended it before the target, if anything."""
        closed = units.percent_from_opening(self._gripper, self._opening) / 100
        result = self._go(lambda: client.gripper_position(self._session, closed), self._away)
        if result is not None:
            client.gripper_speed(self._session, 0.0)
        return result

    def _ahead(self, newest: Sample) -> bool:
        """Tell whether the target is further away than the pads run until a command is obeyed."""
        passed = min(self._speed * (newest.time - self._stepped), self._gripper.opening_quantum)
        left = abs(newest.opening - self._opening) - passed
        before = (newest.opening > self._opening) == self._closing
        return before and left > self._speed * LATENCY

    def _away(self, newest: Sample) -> bool:
        """Tell whether the pads are not at the target, or still on their way to it."""
        return abs(newest.opening - self._opening) > self._tolerance or newest.time - self._stepped < SETTLED

    def _go(self, send: Callable[[], None], on: Callable[[Sample], bool]) -> GripResult | None:
        """Send a command and watch, as long as a condition holds; return what ended it otherwise."""
        taken = self._take()
        place, began = taken[-1].opening, taken[-1].time
        self._stepped = sent = began
        send()
        while True:
            for newest in self._take():
                self._peak = max(self._peak, newest.effort)
                if self._closing and newest.effort > self._max_effort:
                    return GripResult.STALLED
                if abs(newest.opening - place) > self._gripper.opening_quantum / 2:
                    place, self._stepped = newest.opening, newest.time
            if not on(newest):
                return None
            if newest.time - self._stepped > STANDSTILL:
                return self._standing(newest)
            if newest.time - began > MAX_SECONDS:
                raise GripperStuck(f"the gripper did not arrive in {MAX_SECONDS:g} s, at {1000 * place:.1f} mm")
            if newest.time - max(sent, self._stepped) > RESEND:
                send()
                sent = newest.time

    def _standing(self, newest: Sample) -> GripResult:
        """Return what it means that the gripper no longer moves."""
        if self._closing and self._peak >= CONTACT_CURRENT:
            return GripResult.STALLED
        if abs(newest.opening - self._opening) <= OWN_ACCURACY:
            return GripResult.REACHED
        raise GripperStuck(
            f"the gripper stands at {1000 * newest.opening:.1f} mm on its way to {1000 * self._opening:.1f} mm "
            f"and presses on nothing (at most {self._peak:.2f} A): is it blocked, unpowered or at fault?"
        )
