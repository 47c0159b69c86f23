import contextlib
import threading

import pytest

from hw.emulator.kinematic import KinematicRobot
from hw.emulator.server import Emulator, Settings
from hw.kortex.exchange import Credentials
from hw.kortex_robot import KortexRobot
from hw.settings import KortexSettings

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
