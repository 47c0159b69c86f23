"""Dry runs of the command line on the emulated arm, and what a wrong address or login comes to."""

import socket

import pytest

from hw.emulator.kinematic import KinematicRobot
from hw.emulator.trajectories import Invalid
from models import objects
from selection import run
from sim.robot import MujocoRobot
from sim.sensors import SensorModel
from sim.truth import read_truth
from tests.hw.conftest import serving


@pytest.fixture(autouse=True)
def login(monkeypatch):
    monkeypatch.setenv("PALPATE_KORTEX_USER", "admin")
    monkeypatch.setenv("PALPATE_KORTEX_PASSWORD", "admin")


@pytest.fixture
def start():
    """Where the simulated arm starts, from which the exploration's motions are known to be possible."""
    return MujocoRobot(read_truth(objects.locate("soft-cube")), SensorModel.none()).read().q


def explore(emulator, *more):
    ports = ["--port", str(emulator.tcp_port), "--udp-port", str(emulator.udp_port)]
    return run.main(["--robot", "kortex", "--host", "127.0.0.1", *ports, "--dry-run", *more])


def test_everything_is_checked_and_nothing_moves(start, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with serving(KinematicRobot(q=start)) as emulator:
        asked = []
        validate = emulator.services._validate
        monkeypatch.setattr(emulator.services, "_validate", lambda *args: asked.append(1) or validate(*args))
        emulator.services._handlers = emulator.services._table()
        before = emulator.backend.state().sample
        assert explore(emulator) == 0
        after = emulator.backend.state().sample
        assert not emulator.services.motions
    shown = capsys.readouterr().out
    assert "possible  weigh" in shown
    assert len(asked) == 1
    assert abs(after.q - before.q).max() == 0
    assert after.opening == before.opening
    assert not list(tmp_path.iterdir())


def test_an_arm_that_is_not_safe(start, capsys):
    with serving(KinematicRobot("BRAKES", q=start)) as emulator:
        assert explore(emulator) == 1
    error = capsys.readouterr().err
    assert "BRAKES" in error
    assert error.count("\n") == 1


def test_an_arm_that_refuses_the_first_motion(start, capsys, monkeypatch):
    def refuse(*arguments):
        raise Invalid("INVALID_JOINT_SPEED", 0, "too fast for this one", 2.0, 1.0)

    monkeypatch.setattr("hw.emulator.services.through_waypoints", refuse)
    with serving(KinematicRobot(q=start)) as emulator:
        assert explore(emulator) == 1
    shown = capsys.readouterr().out
    assert "all actions failed" in shown
    assert "INVALID_JOINT_SPEED at waypoint 1: too fast for this one" in shown


def test_no_arm_no_login_and_another_arm_are_wrong_input(emulator, capsys, monkeypatch, tmp_path):
    def refused(*arguments):
        assert run.main(["--robot", "kortex", "--out", str(tmp_path / "run"), "--yes", *arguments]) == 2
        captured = capsys.readouterr()
        assert captured.err.count("\n") == 1
        assert "s3cret" not in captured.out + captured.err
        assert not (tmp_path / "run").exists()
        return captured.err

    with socket.create_server(("127.0.0.1", 0)) as free:
        closed = str(free.getsockname()[1])
    there = ["--host", "127.0.0.1", "--port", str(emulator.tcp_port), "--udp-port", str(emulator.udp_port)]
    assert "--host" in refused()
    assert "unknown" in refused("--host", "no.such.host.invalid")
    assert "refused" in refused("--host", "127.0.0.1", "--port", closed)
    assert "vision" in refused(*there, "--no-vision")
    monkeypatch.setenv("PALPATE_KORTEX_PASSWORD", "s3cret")
    assert "INVALID_PASSWORD" in refused(*there)
    assert "unrecognized" in _parse_error(capsys, "--password", "s3cret")


def _parse_error(capsys, *arguments):
    with pytest.raises(SystemExit) as stopped:
        run.main(list(arguments))
    assert stopped.value.code == 2
    return capsys.readouterr().err
