"""Logging in, staying logged in, and everything that keeps one from it."""

import io
import logging
import socket
import time

import pytest

from dynamics.errors import InvalidInput, PalpateError
from hw.credentials import credentials
from hw.emulator.services import Identity
from hw.kortex import client, methods
from hw.kortex.codes import Model, Vision
from hw.kortex.errors import (
    CheckFailed,
    ConnectionFailed,
    ConnectionLost,
    LoginRefused,
    NotInControl,
    RpcError,
    RpcTimeout,
    SessionLost,
)
from hw.kortex.exchange import Credentials, Timeouts
from hw.kortex.tcp import TcpSession
from hw.kortex.udp import UdpSession
from hw.kortex_robot import KortexRobot
from hw.settings import KortexSettings
from tests.conformance import MOVE, motion
from tests.hw.conftest import ADMIN, driving, serving

QUICK = Timeouts(connect=0.3, request=0.3)


def free_port(kind=socket.SOCK_STREAM):
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def test_port_closed():
    with pytest.raises(ConnectionFailed, match="refused"):
        KortexRobot("127.0.0.1", ADMIN, KortexSettings(tcp_port=free_port()))


@pytest.mark.parametrize("host", ["no.such.host.invalid", "", "a b", "x" * 300])
def test_host_that_does_not_exist(host):
    with pytest.raises(ConnectionFailed):
        TcpSession(host, ADMIN, free_port(), QUICK)


def test_host_that_does_not_speak_kortex():
    with socket.create_server(("127.0.0.1", 0)) as server:
        began = time.monotonic()
        with pytest.raises(RpcTimeout, match="CreateSession"):
            TcpSession("127.0.0.1", ADMIN, server.getsockname()[1], QUICK)
        assert time.monotonic() - began < 2


def test_udp_port_closed(emulator):
    settings = KortexSettings(tcp_port=emulator.tcp_port, udp_port=free_port(socket.SOCK_DGRAM))
    with pytest.raises(ConnectionFailed, match="UDP"):
        KortexRobot("127.0.0.1", ADMIN, settings)


def test_udp_that_never_answers(emulator):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as deaf:
        deaf.bind(("127.0.0.1", 0))
        with pytest.raises(ConnectionFailed, match="does not answer"):
            UdpSession("127.0.0.1", ADMIN, deaf.getsockname()[1], QUICK)


@pytest.mark.parametrize(("user", "name"), [("admin", "INVALID_PASSWORD"), ("nobody", "USER_NOT_FOUND")])
def test_wrong_login(emulator, user, name, caplog):
    caplog.set_level(logging.DEBUG)
    with pytest.raises(LoginRefused, match=name) as caught, driving(emulator, Credentials(user, "s3cret")):
        pass
    assert caught.value.code == 3
    assert "s3cret" not in str(caught.value) + caplog.text


def test_password_is_in_no_representation():
    assert "s3cret" not in repr(Credentials("admin", "s3cret"))


def test_credentials_from_the_environment(monkeypatch):
    monkeypatch.setenv("PALPATE_KORTEX_USER", "me")
    monkeypatch.setenv("PALPATE_KORTEX_PASSWORD", "s3cret")
    found = credentials()
    assert (found.user, found.password) == ("me", "s3cret")
    monkeypatch.delenv("PALPATE_KORTEX_PASSWORD")
    monkeypatch.setattr("sys.stdin", io.StringIO())
    with pytest.raises(InvalidInput, match="PALPATE_KORTEX_PASSWORD"):
        credentials()


@pytest.mark.parametrize(
    ("identity", "words"),
    [
        (Identity(model=Model.GEN3_LITE), "model GEN3_LITE; valid: GEN3"),
        (Identity(joints=6), "an arm of 6 joints; valid: 7"),
        (Identity(vision=Vision.NOT_INSTALLED), "without a vision module"),
    ],
)
def test_another_arm(identity, words):
    with (
        serving(identity=identity) as emulator,
        pytest.raises(CheckFailed, match=words),
        driving(emulator),
    ):
        pass


def test_second_client_in_control(emulator):
    with driving(emulator) as first, driving(emulator) as second:
        first.follow(motion(first, MOVE))
        with pytest.raises(NotInControl, match="SESSION_NOT_IN_CONTROL"):
            second.follow(motion(second, MOVE))
        second.hold(0.05)
        first.follow(motion(first, -MOVE))


@pytest.mark.parametrize(
    "wrong",
    [{"rate": 50}, {"rate": float("nan")}, {"tcp_port": 0}, {"udp_port": 70000}, {"torque_tolerance": (1.0,) * 6}],
)
def test_senseless_settings(wrong):
    with pytest.raises(InvalidInput):
        KortexSettings(**wrong)


def test_keep_alive_keeps_a_quiet_session(emulator):
    session = TcpSession("127.0.0.1", ADMIN, emulator.tcp_port, Timeouts(session=0.4, connection=0.4))
    time.sleep(1.0)
    assert client.arm_state(session) == 7
    session.close()


def test_error_carries_code_sub_code_and_text(emulator):
    session = TcpSession("127.0.0.1", ADMIN, emulator.tcp_port)
    with pytest.raises(RpcError, match=r"ExecuteActionFromReference.*ENTITY_NOT_FOUND \(17\): action 0") as caught:
        session.request(methods.EXECUTE_ACTION_FROM_REFERENCE)
    assert (caught.value.code, caught.value.sub_code, caught.value.text) == (3, 17, "action 0")
    session.request(methods.CLOSE_SESSION)
    with pytest.raises(SessionLost):
        client.arm_state(session)
    session.close()
    session.close()
    with pytest.raises(ConnectionLost):
        client.arm_state(session)


def test_requests_from_many_threads_get_their_own_answers(emulator):
    from concurrent.futures import ThreadPoolExecutor

    session = TcpSession("127.0.0.1", ADMIN, emulator.tcp_port)
    with ThreadPoolExecutor(8) as pool:
        masses = pool.map(lambda n: client.tool_mass(session) if n % 2 else client.arm_state(session), range(200))
        found = list(masses)
    assert found[::2] == [7] * 100
    assert found[1::2] == pytest.approx([0.925] * 100)
    session.close()


def test_closed_robot_says_so(emulator):
    with driving(emulator) as robot:
        pass
    with pytest.raises(ConnectionLost, match="closed"):
        robot.read()
    with pytest.raises(PalpateError):
        robot.hold(0.1)


def test_unconfirmed_motion_is_refused(emulator):
    asked = []

    def no(question):
        asked.append(question)
        return False

    from dynamics.errors import MotionRefused

    with driving(emulator, confirm=no) as robot:
        before = robot.read().q
        with pytest.raises(MotionRefused, match="not confirmed"):
            robot.follow(motion(robot, MOVE))
        with pytest.raises(MotionRefused, match="not confirmed"):
            robot.grip(0.05, 0.05, 1.0)
        robot.hold(0.1)
        assert abs(robot.read().q - before).max() < 1e-6
        assert robot.read().opening > 0.08
    assert len(asked) == 2
    with driving(emulator, confirm=None) as robot, pytest.raises(MotionRefused, match="not confirmed"):
        robot.grip(0.05, 0.05, 1.0)


def test_confirmation_is_asked_once(emulator):
    asked = []
    with driving(emulator, confirm=lambda question: asked.append(question) or True) as robot:
        robot.follow(motion(robot, MOVE))
        robot.grip(0.08, 0.1, 1.0)
    assert len(asked) == 1
    assert "127.0.0.1" in asked[0]


def test_an_answer_that_waits_is_taken_even_when_it_is_late(emulator, monkeypatch):
    session = UdpSession("127.0.0.1", ADMIN, emulator.udp_port)
    send = session._send

    def busy(datagram):
        send(datagram)
        time.sleep(0.05)  # the machine has other things to do

    monkeypatch.setattr(session, "_send", busy)
    assert len(session.request(methods.REFRESH_FEEDBACK, within=0.02, each=0.01).actuators) == 7
    session.close()
