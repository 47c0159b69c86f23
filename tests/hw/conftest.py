import contextlib
import threading
import time

import pytest
from _pytest.runner import runtestprotocol

from hw.emulator.kinematic import KinematicRobot
from hw.emulator.server import Emulator, Settings
from hw.kortex.exchange import Credentials
from hw.kortex_robot import KortexRobot
from hw.settings import KortexSettings

STALL = 0.05  # s by which a sleeping thread woke late; machines that keep up stay far below
ATTEMPTS = 3
ADMIN = Credentials("admin", "admin")


@contextlib.contextmanager
def serving(backend=None, faults=(), **settings):
    """An emulator on free ports."""
    own = {"tcp_port": 0, "udp_port": 0, "command_period": 0.005} | settings
    with Emulator(backend or KinematicRobot(), Settings(**own), faults) as emulator:
        yield emulator


@contextlib.contextmanager
def driving(emulator, credentials=ADMIN, confirm=lambda question: True, **settings):
    """A driver connected to an emulator."""
    own = {"tcp_port": emulator.tcp_port, "udp_port": emulator.udp_port} | settings
    with KortexRobot("127.0.0.1", credentials, KortexSettings(**own), confirm) as robot:
        yield robot


@pytest.fixture
def emulator():
    with serving() as server:
        yield server


@pytest.fixture
def robot(emulator):
    with driving(emulator) as driver:
        yield driver


@pytest.fixture(autouse=True)
def no_thread_left_behind():
    yield
    left = [t.name for t in threading.enumerate() if t.name.startswith(("kortex", "emulator")) and t.is_alive()]
    assert not left


class Stalls(threading.Thread):
    """Measures how long the machine let a thread wait that wanted to run."""

    def __init__(self):
        super().__init__(name="stalls", daemon=True)
        self.longest, self._over = 0.0, threading.Event()

    def run(self):
        before = time.monotonic()
        while not self._over.wait(0.01):
            now = time.monotonic()
            self.longest = max(self.longest, now - before - 0.01)
            before = now

    def __enter__(self):
        self.start()
        return self

    def __exit__(self, *_):
        self._over.set()
        self.join()


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_protocol(item, nextitem):
    """Try a test again that failed while the machine stood still: the arm's time is the wall's.

    Time-outs of the driver are tens of milliseconds, and on a machine that is busy otherwise they do what they are
    for. A failure while the machine keeps up stays one, and so does the last of the attempts.
    """
    item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
    for left in reversed(range(ATTEMPTS)):
        with Stalls() as stalls:
            reports = runtestprotocol(item, nextitem=nextitem, log=False)
        failed = any(report.failed for report in reports)
        if not failed or stalls.longest < STALL or not left:
            break
        item._initrequest()
    for report in reports:
        if failed and stalls.longest >= STALL:
            report.sections.append(
                ("machine", f"it stood still for {stalls.longest:.2f} s, in {ATTEMPTS} attempts")
            )
        item.ihook.pytest_runtest_logreport(report=report)
    item.ihook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
    return True
