"""Explorations by the command line through the emulator: two processes, real sockets, the simulation's result.

The simulated arm moves in real time. To be short, the clocks of both sides run up to three times as fast here; the
whole exploration in real time is among the long tests.
"""

import contextlib
import math
import re
import resource
import signal
import subprocess
import sys
import textwrap
import time

import numpy as np
import pytest

from estimation.recording import read_recording
from hw import kortex_robot
from hw.emulator.kinematic import KinematicRobot
from hw.feedback import FeedbackReader
from models import objects
from selection import run
from sim.robot import MujocoRobot
from sim.sensors import SensorModel
from sim.truth import read_truth
from tests.hw.conftest import serving

FASTEST = 1.6
QUIET = ["--quiet", "--no-report"]
SQUEEZE = [*QUIET, "--price", "0.05"]  # of the actions, only squeezing is worth its time then
THOROUGH = [*QUIET, "--price", "0.0005", "--confidence", "0.9999"]

EMULATOR = """
    import signal, sys, time
    from hw.emulator import server
    from hw.emulator.robot_backend import RobotBackend
    from models import objects
    from sim.robot import MujocoRobot
    from sim.sensors import SensorModel
    from sim.truth import read_truth

    speed = float(sys.argv[1])
    robot = MujocoRobot(read_truth(objects.locate("soft-cube")), SensorModel())
    backend = RobotBackend(robot, lambda: speed * time.monotonic(), lambda seconds: time.sleep(seconds / speed))
    server.TICK /= speed
    settings = server.Settings(tcp_port=0, udp_port=0, command_period=0.025 / speed)
    emulator = server.Emulator(backend, settings)
    signal.signal(signal.SIGTERM, lambda number, frame: emulator.end())
    print(f"ready :{emulator.tcp_port} :{emulator.udp_port}", flush=True)
    emulator.serve()
"""


@pytest.fixture
def login(monkeypatch):
    monkeypatch.setenv("PALPATE_KORTEX_USER", "admin")
    monkeypatch.setenv("PALPATE_KORTEX_PASSWORD", "admin")


def simulated(tmp_path, *options):
    """Explore in the simulation; return what was measured, and the share of a core that this process got."""
    wall, used = time.monotonic(), time.process_time()
    assert run.main(["--out", str(tmp_path / "sim"), *options]) == 0
    share = (time.process_time() - used) / (time.monotonic() - wall)
    return measured(tmp_path / "sim"), share


def emulated(command, tmp_path, *options):
    """Explore through an emulator; return what was measured."""
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        try:
            tcp, udp = re.findall(r":(\d+)", server.stdout.readline())
            # The simulated cube deforms evenly over the pads' face.
            arm = ["--robot", "kortex", "--host", "127.0.0.1", "--port", tcp, "--udp-port", udp, "--yes"]
            arm += ["--load-spread", "face"]
            assert run.main(["--out", str(tmp_path / "kortex"), *arm, *options]) == 0
        finally:
            server.send_signal(signal.SIGTERM)
            server.wait(5)
    return measured(tmp_path / "kortex")


def measured(directory):
    """Return mean and standard deviation of what a run measured, by quantity."""
    recording = read_recording(directory)
    assert recording.complete
    return {one.measurement.property: one.measurement for one in recording.measurements}


def agree(simulated, real):
    assert set(simulated) == set(real)
    for name, one in simulated.items():
        other = real[name]
        assert abs(one.mean - other.mean) < 3 * math.hypot(one.sd, other.sd), name


def test_an_exploration_through_the_emulator(tmp_path, login, monkeypatch):
    expected, share = simulated(tmp_path, *SQUEEZE)
    speed = min(max(1.0, FASTEST * share / 0.9), FASTEST)  # slower where others use the machine

    def fast(session, gripper, rate, *others):
        return FeedbackReader(
            session, gripper, rate * (1 + speed) / 2, *others, clock=lambda: speed * time.monotonic()
        )

    monkeypatch.setattr(kortex_robot, "FeedbackReader", fast)
    found = emulated([sys.executable, "-c", textwrap.dedent(EMULATOR), str(speed)], tmp_path, *SQUEEZE)
    assert set(found) == {"elasticity", "width"}
    agree(expected, found)


@contextlib.contextmanager
def exploring(emulator, directory, **options):
    """A run by the command line in a process of its own, once it moves the arm."""
    ports = ["--port", str(emulator.tcp_port), "--udp-port", str(emulator.udp_port)]
    command = [sys.executable, "-m", "selection.run", "--robot", "kortex", "--host", "127.0.0.1", *ports]
    command += ["--yes", "--quiet", "--no-report", "--out", str(directory)]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, **options) as process:
        deadline = time.monotonic() + 30
        while not emulator.backend.state().arm_moving:
            assert process.poll() is None
            assert time.monotonic() < deadline
            time.sleep(0.01)
        yield process


def rests(emulator):
    time.sleep(0.2)
    where = emulator.backend.state().sample.q
    time.sleep(0.1)
    state = emulator.backend.state()
    return not state.arm_moving and np.array_equal(state.sample.q, where)


@pytest.fixture
def arm():
    """An emulated arm that stands where the simulated one does, from where the exploration is known to go."""
    start = MujocoRobot(read_truth(objects.locate("soft-cube")), SensorModel.none()).read().q
    with serving(KinematicRobot(q=start)) as emulator:
        yield emulator


@pytest.mark.parametrize(("number", "status"), [(signal.SIGTERM, 143), (signal.SIGINT, 130)])
def test_a_signal_ends_an_exploration_in_order(number, status, arm, tmp_path, login):
    """The arm rests, the recording can be read, and the exit status says what happened."""
    with exploring(arm, tmp_path / "run") as process:
        time.sleep(0.3)
        process.send_signal(number)
        began = time.monotonic()
        error = process.communicate(timeout=10)[1]
        assert time.monotonic() - began < 2.0
        assert process.returncode == status
    assert "Traceback" not in error
    assert rests(arm)
    recording = read_recording(tmp_path / "run")
    assert len(recording.samples.time) > 20
    assert recording.decisions[0].data["choice"] == "weigh"
    assert not (tmp_path / "run" / "result.json").exists()


def test_a_disk_that_fills_stops_the_arm(arm, tmp_path, login):
    """A limit on the size of files stands for the full disk."""

    def limited():
        resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))

    with exploring(arm, tmp_path / "run", preexec_fn=limited) as process:
        error = process.communicate(timeout=10)[1]
        assert process.returncode == 1
    assert "recording failed" in error
    assert error.strip().count("\n") == 0
    assert rests(arm)
    assert arm.services.motions < 10  # of a few dozen
    assert len(read_recording(tmp_path / "run").samples.time) > 20


@pytest.mark.slow
def test_a_whole_exploration_in_real_time(tmp_path, login):
    command = [sys.executable, "-m", "hw.emulator", "--backend", "mujoco", "--port", "0", "--udp-port", "0"]
    expected, _ = simulated(tmp_path, *THOROUGH)
    found = emulated(command, tmp_path, *THOROUGH)
    assert {"mass", "elasticity"} <= set(found)
    agree(expected, found)
