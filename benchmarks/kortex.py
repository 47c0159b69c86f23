"""How well the real arm's feedback is read and how fast it is stopped: ``python -m benchmarks.kortex --json``.

The emulator runs in a process of its own. ``round_trip`` are plain questions one after the other; ``clean`` and
``lossy`` are a driver that reads for a while as the arm moves to and fro over TCP, without and with 5 % of the
datagrams lost each way. ``repeated`` counts questions that were asked again, ``late`` those of them whose first
answer came after all: the difference was lost. ``stops`` are seconds from a fault in a motion until the call has
returned and the arm rests (``mute``: nothing reaches the arm any more, which ends its trajectory).
"""

from __future__ import annotations

import argparse
import json
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from dynamics.errors import PalpateError
from dynamics.trajectory import time_path
from hw.emulator.kinematic import KinematicRobot
from hw.emulator.server import Emulator, Settings
from hw.kortex import methods
from hw.kortex.exchange import Credentials
from hw.kortex.udp import UdpSession
from hw.kortex_robot import KortexRobot
from hw.settings import KortexSettings

ADMIN = Credentials("admin", "admin")
QUESTIONS = 5000
SWING = np.array([0.2, -0.15, 0.15, 0.2, -0.2, 0.2, 0.4])  # rad


@contextmanager
def emulator(*options: str) -> Iterator[tuple[int, int]]:
    """Run an emulator; yield its ports."""
    command = [sys.executable, "-m", "hw.emulator", "--port", "0", "--udp-port", "0", *options]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        tcp, udp = (int(port) for port in re.findall(r":(\d+)", process.stdout.readline()))
        try:
            yield tcp, udp
        finally:
            process.send_signal(signal.SIGTERM)


def round_trips() -> dict[str, float]:
    with emulator() as (_, port):
        session = UdpSession("127.0.0.1", ADMIN, port)
        taken = []
        for _ in range(QUESTIONS):
            began = time.perf_counter()
            session.request(methods.REFRESH_FEEDBACK)
            taken.append(1000 * (time.perf_counter() - began))
        session.close()
    median, p99, worst = np.percentile(taken, [50, 99, 100])
    return {
        "median_ms": median,
        "p99_ms": p99,
        "worst_ms": worst,
        "repeated": session.repeats,
        "late": session.late,
        "questions": QUESTIONS,
    }


def reading(seconds: float, *options: str) -> dict[str, float]:
    with emulator(*options) as (tcp, udp):
        settings = KortexSettings(tcp_port=tcp, udp_port=udp)
        with KortexRobot("127.0.0.1", ADMIN, settings, lambda question: True) as robot:
            times: list[float] = []
            robot.listen(lambda sample: times.append(sample.time))
            end, side = time.monotonic() + seconds, 1
            while time.monotonic() < end:
                q = robot.read().q
                robot.follow(time_path(robot.arm, np.linspace(q, q + side * SWING, 60)))
                side = -side
            found = robot.statistics
    return {
        "seconds": found.seconds,
        "rate_hz": found.rate,
        "readings": found.readings,
        "longest_gap_ms": 1000 * found.longest_gap,
        "repeated": found.repeats,
        "late": found.late,
        "handed_on": len(times),
    }


def stops() -> dict[str, dict[str, float | str]]:
    """For each fault: what the driver raises, and how long after the fault it does and the arm rests."""
    found: dict[str, dict[str, float | str]] = {}
    for fault in ("silence", "drop", "garbage", "fault=joint2:0x20", "estop", "abort", "mute", "delay=5"):
        with Emulator(KinematicRobot(), Settings(tcp_port=0, udp_port=0)) as server:
            settings = KortexSettings(tcp_port=server.tcp_port, udp_port=server.udp_port)
            with KortexRobot("127.0.0.1", ADMIN, settings, lambda question: True) as robot:
                q = robot.read().q
                path = time_path(robot.arm, np.linspace(q, q + 5 * SWING, 60), 0.5)
                struck = threading.Timer(1.0, server.inject, (fault,))
                rested: list[float] = []
                watch = threading.Thread(target=_await_rest, args=(server, rested))
                robot.grip(0.08, 0.1, 1.0)  # the check is over then
                began = time.monotonic()
                struck.start()
                watch.start()
                try:
                    robot.follow(path)
                    name = "nothing"
                except PalpateError as error:
                    name = type(error).__name__
                returned = time.monotonic() - began - 1.0
                watch.join()
                found[fault] = {
                    "raises": name,
                    "returns_s": round(returned, 3),
                    "rests_s": round(rested[0] - began - 1.0, 3),
                }
    return found


def _await_rest(server: Emulator, rested: list[float]) -> None:
    """Note when the arm, once it has moved, rests."""
    while not server.backend.state().arm_moving:
        time.sleep(0.005)
    while server.backend.state().arm_moving:
        time.sleep(0.005)
    rested.append(time.monotonic())


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.kortex", description=__doc__)
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument("--seconds", type=float, default=60.0, help="of each reading (%(default)s)")
    given = parser.parse_args()
    found: dict[str, dict[str, Any]] = {
        "stops": stops(),
        "round_trip": round_trips(),
        "clean": reading(given.seconds),
        "lossy": reading(given.seconds, "--fault", "loss=0.05"),
    }
    if given.json:
        print(json.dumps(found, indent=1))
        return
    for name, figures in found.items():
        told = (
            f"{key} {value:.5g}" if isinstance(value, float) else f"{key} {value}"
            for key, value in figures.items()
        )
        print(f"{name}: {', '.join(told)}")


if __name__ == "__main__":
    main()
