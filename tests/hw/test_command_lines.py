"""The command lines, and a driver and an emulator in processes of their own."""

import io
import re
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import numpy as np
import pytest

from dynamics.errors import PalpateError
from hw import check
from hw.emulator.__main__ import main as emulate
from hw.emulator.faults import FAULTS
from hw.emulator.kinematic import HOME, KinematicRobot
from hw.kortex_robot import KortexRobot
from hw.settings import KortexSettings
from tests.hw.conftest import ADMIN, serving


@pytest.fixture
def login(monkeypatch):
    monkeypatch.setenv("PALPATE_KORTEX_USER", "admin")
    monkeypatch.setenv("PALPATE_KORTEX_PASSWORD", "admin")


def look(emulator, *more):
    ports = ["--port", str(emulator.tcp_port), "--udp-port", str(emulator.udp_port)]
    return check.main(["--host", "127.0.0.1", *ports, "--seconds", "0.2", *more])


def test_check_of_a_healthy_arm(emulator, login, capsys):
    assert look(emulator) == 0
    out = capsys.readouterr().out
    assert "SERVOING_READY" in out
    assert re.search(r"2 +-13\.36 +-13\.36 +0\.00 +1\.00", out)
    assert "safe to move" in out
    assert not emulator.services.motions


def test_check_of_the_wrong_revision(login, capsys):
    with serving(KinematicRobot("BRAKES")) as emulator:
        assert look(emulator) == 1
        assert "unsafe: the torques fit a BRAKES arm" in capsys.readouterr().out
        assert look(emulator, "--revision", "BRAKES") == 0


def test_check_of_an_arm_in_emergency_stop(emulator, login, capsys):
    emulator.inject("estop")
    time.sleep(0.05)
    assert look(emulator) == 1
    out = capsys.readouterr().out
    assert "unsafe: fault: base EMERGENCY_STOP_ACTIVATED" in out
    assert "unsafe: arm state IN_FAULT" in out


def test_check_of_another_arm(emulator, login, capsys):
    assert look(emulator, "--no-vision") == 1
    assert "unsafe: the arm is with a vision module" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--host", "no.such.host.invalid"], "unknown"),
        (["--host", "127.0.0.1", "--port", "1"], "refused"),
        (["--host", "127.0.0.1", "--port", "0"], "1 to 65535"),
        (["--host", "127.0.0.1", "--seconds", "nan"], "--seconds"),
        (["--host", "127.0.0.1", "--offsets", "/no/such/file"], "torque tare"),
    ],
)
def test_wrong_input_is_one_line_and_status_2(arguments, words, login, capsys):
    assert check.main(arguments) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    assert words in err


def test_wrong_password_is_said_and_not_shown(emulator, login, monkeypatch, capsys):
    monkeypatch.setenv("PALPATE_KORTEX_PASSWORD", "s3cret")
    assert look(emulator) == 2
    captured = capsys.readouterr()
    assert "INVALID_PASSWORD" in captured.err
    assert "s3cret" not in captured.out + captured.err


def test_password_is_no_argument():
    with pytest.raises(SystemExit):
        check.main(["--host", "127.0.0.1", "--password", "x"])


def test_declined_tare_moves_nothing(emulator, login, monkeypatch, tmp_path, capsys):
    monkeypatch.setattr("sys.stdin", io.StringIO("no\n"))
    assert look(emulator, "--tare", str(tmp_path / "tare.json")) == 2
    assert "not confirmed" in capsys.readouterr().err
    assert not emulator.services.motions
    assert not list(tmp_path.iterdir())


def test_guided_zeroing(login, capsys):
    offset = np.full(7, 1.2)
    with serving(KinematicRobot(q=np.zeros(7), torque_offset=offset)) as emulator:
        assert look(emulator) == 1
        assert look(emulator, "--zero-torques", "--yes") == 0
        out = capsys.readouterr().out
        assert "take the gripper off" in out
        assert look(emulator) == 0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--fault", "earthquake"], "earthquake"),
        (["--width", "-1"], "block"),
        (["--host", "8.8.8.8"], "cannot listen"),
    ],
)
def test_emulator_with_wrong_input(arguments, words, capsys):
    assert emulate(["--port", "0", "--udp-port", "0", *arguments]) == 2
    assert words in capsys.readouterr().err


@pytest.fixture
def emulator_process():
    command = [sys.executable, "-m", "hw.emulator", "--port", "0", "--udp-port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        ports = [int(port) for port in re.findall(r":(\d+)", process.stdout.readline())]
        yield process, ports
        if process.poll() is None:
            process.send_signal(signal.SIGTERM)
        assert process.wait(5) == 0


def test_two_processes(emulator_process):
    _, (tcp, udp) = emulator_process
    with KortexRobot(
        "127.0.0.1", ADMIN, KortexSettings(tcp_port=tcp, udp_port=udp), lambda question: True
    ) as robot:
        robot.grip(0.06, 0.1, 1.0)
        assert robot.read().opening == pytest.approx(0.06, abs=0.0015)


def test_vanished_server(emulator_process):
    process, (tcp, udp) = emulator_process
    with KortexRobot(
        "127.0.0.1", ADMIN, KortexSettings(tcp_port=tcp, udp_port=udp), lambda question: True
    ) as robot:
        process.send_signal(signal.SIGTERM)
        began = time.monotonic()
        with pytest.raises(PalpateError, match="press the emergency stop"):
            robot.hold(10.0)
        assert time.monotonic() - began < 2.5
        assert process.wait(5) == 0


DRIVER = """
    import sys
    import numpy as np
    from dynamics.trajectory import time_path
    from hw.kortex.exchange import Credentials
    from hw.kortex_robot import KortexRobot
    from hw.settings import KortexSettings
    tcp, udp = map(int, sys.argv[1:])
    settings = KortexSettings(tcp_port=tcp, udp_port=udp)
    robot = KortexRobot("127.0.0.1", Credentials("admin", "admin"), settings, lambda question: True)
    q = robot.read().q
    robot.listen(lambda sample: print("moving", flush=True) if abs(sample.dq).max() > 0.1 else None)
    robot.follow(time_path(robot.arm, np.linspace(q, q + 0.5, 50), 0.2))
    print("done", flush=True)
"""


@pytest.mark.parametrize(("number", "status"), [(signal.SIGTERM, 143), (signal.SIGHUP, 129), (signal.SIGINT, -2)])
def test_a_signal_stops_the_arm(emulator, number, status):
    command = [sys.executable, "-c", textwrap.dedent(DRIVER), str(emulator.tcp_port), str(emulator.udp_port)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as driver:
        assert driver.stdout.readline() == "moving\n"
        assert emulator.backend.state().arm_moving
        driver.send_signal(number)
        assert driver.wait(3) == status
        assert "done" not in driver.stdout.read()
    time.sleep(0.3)
    assert not emulator.backend.state().arm_moving
    where = emulator.backend.state().sample.q
    assert 0 < np.abs(where - HOME).max() < 0.4


def test_the_manuals_example_runs(emulator, login):
    manual = (Path(__file__).parents[2] / "docs" / "hardware.md").read_text()
    code = re.search(r"```python\n(.*?)```", manual, re.DOTALL)[1]
    call = f'connect("127.0.0.1", {emulator.tcp_port}, {emulator.udp_port}, revision="V12", yes=True)'
    found = {}
    exec(code.replace('connect("192.168.1.10", revision="V12")', call), found)
    assert len(found["samples"]) > 150
    assert emulator.backend.state().sample.opening == pytest.approx(0.04, abs=0.0015)


def test_the_manual_lists_every_fault_and_option():
    manual = (Path(__file__).parents[2] / "docs" / "hardware.md").read_text()
    for name in FAULTS:
        assert re.search(rf"`{name}[`=]", manual), name
    for option in re.findall(r"python -m hw\.check.*?(--[a-z-]+)", manual):
        assert option in check._parser().format_help()
