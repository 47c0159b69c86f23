"""A client written from the protocol's description alone, without our code, talks to the emulator."""

import contextlib
import socket
import struct
import time

import pytest

from hw.emulator.kinematic import HOME, KinematicRobot
from tests.hw.conftest import serving

MAGIC = bytes.fromhex("07 78 45 74 52 6F 4B 07")


def varint(value):
    out = b""
    while True:
        value, low = value >> 7, value & 0x7F
        out += bytes([low | (0x80 if value else 0)])
        if not value:
            return out


def field(number, value):
    if isinstance(value, float):
        return varint(number << 3 | 5) + struct.pack("<f", value)
    if isinstance(value, int):
        return varint(number << 3) + varint(value)
    return varint(number << 3 | 2) + varint(len(value)) + value


def fixed(number, value):
    return varint(number << 3 | 5) + struct.pack("<I", value)


def parse(data):
    """Fields of a message: number -> list of raw values."""
    found, at = {}, 0

    def take():
        nonlocal at
        value = shift = 0
        while True:
            byte = data[at]
            at += 1
            value |= (byte & 0x7F) << shift
            shift += 7
            if byte < 0x80:
                return value

    while at < len(data):
        key = take()
        if key & 7 == 0:
            value = take()
        elif key & 7 == 5:
            value, at = data[at : at + 4], at + 4
        else:
            size = take()
            value, at = data[at : at + size], at + size
        found.setdefault(key >> 3, []).append(value)
    return found


class Foreign:
    """The other client."""

    def __init__(self, emulator, tcp=True):
        self.tcp, self.counter, self.session, self.notes = tcp, 0, 0, []
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_STREAM if tcp else socket.SOCK_DGRAM)
        self.socket.settimeout(2)
        self.socket.connect(("127.0.0.1", emulator.tcp_port if tcp else emulator.udp_port))

    def call(self, method, payload=b"", device=0):
        self.counter += 1
        header = fixed(1, 1 << 28 | 1 << 24 | device << 16) + fixed(2, self.session << 16 | self.counter)
        header += fixed(3, 1 << 28 | method) + fixed(4, len(payload))
        frame = field(1, header) + field(2, payload)
        self.socket.sendall((MAGIC + struct.pack(">I", len(frame)) if self.tcp else b"") + frame)
        while True:
            kind, message, session, sub, body = self.receive()
            if kind == 5:
                self.notes.append((message, body))
                continue
            assert kind == 3
            assert message == self.counter
            self.session = session or self.session
            return sub, parse(body)

    def receive(self):
        if self.tcp:
            head = self.exactly(12)
            assert head[:8] == MAGIC
            data = self.exactly(struct.unpack(">I", head[8:])[0])
        else:
            data = self.socket.recv(65507)
        frame = parse(data)
        words = {n: struct.unpack("<I", v[0])[0] for n, v in parse(frame[1][0]).items()}
        info, message = words[1], words.get(2, 0)
        assert info >> 28 == 1
        body = frame.get(2, [b""])[0]
        assert len(body) == words.get(4, 0)
        return info >> 24 & 15, message & 0xFFFF, message >> 16, info & 0xFFF, body

    def exactly(self, count):
        data = b""
        while len(data) < count:
            data += self.socket.recv(count - len(data))
        return data

    def login(self, password=b"admin"):
        return self.call(0x10001, field(1, b"admin") + field(2, 10000) + field(3, password) + field(4, 2000))


@pytest.fixture
def emulator():
    with serving(KinematicRobot()) as server:
        yield server


@pytest.fixture
def tcp(emulator):
    client = Foreign(emulator)
    client.login()
    yield client
    client.socket.close()


def waypoint(angles, seconds):
    packed = b"".join(struct.pack("<f", a) for a in angles)
    point = field(1, packed) + field(3, float(seconds))
    return field(1, field(2, point))


def test_feedback_over_udp(emulator):
    client = Foreign(emulator, tcp=False)
    assert client.login()[0] == 0
    sub, feedback = client.call(0x30003)
    assert sub == 0
    positions = [struct.unpack("<f", parse(joint).get(4, [bytes(4)])[0])[0] for joint in feedback[3]]
    assert positions == pytest.approx([0, 15, 180, 230, 0, 55, 90], abs=1e-4)
    torque = struct.unpack("<f", parse(feedback[3][1])[6][0])[0]
    assert torque == pytest.approx(-emulator.backend.arm.gravity(HOME)[1], abs=1e-4)
    base = parse(feedback[2][0])
    assert base[2] == [7]
    client.socket.close()


def test_motion_and_notifications(tcp, emulator):
    _sub, handle = tcp.call(0x2006A)
    subscription = handle[1][0]
    goal = [0, 15, 180, 230, 0, 55, 95]
    assert tcp.call(0x200EB, waypoint(goal, 0.5))[1].get(1, [b""]) == [b""]
    assert tcp.call(0x200E2, waypoint(goal, 0.5))[0] == 0
    deadline = time.monotonic() + 2
    events = [parse(body)[1][0] for number, body in tcp.notes if number == subscription]
    while 1 not in events and time.monotonic() < deadline:
        kind, number, _, _, body = tcp.receive()
        assert (kind, number) == (5, subscription)
        events.append(parse(body)[1][0])
    assert events == [4, 1]
    _, angles = tcp.call(0x2007E)
    last = parse(angles[1][6])
    assert struct.unpack("<f", last[2][0])[0] == pytest.approx(95, abs=1e-3)


def test_named_actions(tcp):
    _, actions = tcp.call(0x2002C)
    names = {parse(action)[2][0]: parse(parse(action)[1][0])[1][0] for action in actions[1]}
    assert set(names) == {b"Home", b"Retract", b"Zero"}
    assert tcp.call(0x2002F, field(1, names[b"Zero"]))[0] == 0
    assert tcp.call(0x20070)[0] == 0


def test_gripper(tcp, emulator):
    command = field(1, 3) + field(2, field(1, field(1, 1) + field(2, 0.5)))
    assert tcp.call(0x20088, command)[0] == 0
    time.sleep(0.5)
    _, measured = tcp.call(0x20089, field(1, 3))
    assert struct.unpack("<f", parse(measured[1][0])[2][0])[0] == pytest.approx(0.5, abs=0.01)


@pytest.mark.parametrize(
    ("method", "sub"),
    [
        (0x110003, 4),  # GripperCyclic is not served by the base
        (0x20001, 5),  # a method of the base that the emulator has not
        (0x2002F, 17),  # an action that is none
    ],
)
def test_error_replies(tcp, method, sub):
    found, error = tcp.call(method)
    assert found == sub
    assert error[2] == [sub]


def test_waypoints_that_are_wrong(tcp):
    _, report = tcp.call(0x200EB, waypoint([0, 200, 180, 230, 0, 55, 90], 5.0))
    element = parse(parse(report[1][0])[1][0])
    assert element[1] == [11]
    _, report = tcp.call(0x200EB, waypoint([0, 15, 180, 230, 0, 55, 270], 0.1))
    assert parse(parse(report[1][0])[1][0])[1] == [5]
    assert tcp.call(0x200E2, waypoint([0, 15], 1.0))[0] == 3


def test_without_a_session(emulator):
    client = Foreign(emulator)
    assert client.call(0x200AF)[0] == 12
    assert client.login(b"wrong")[0] == 15
    assert client.call(0x10001, field(1, b"nobody"))[0] == 16
    client.socket.close()


def test_payload_that_is_no_message(tcp):
    assert tcp.call(0x20088, b"\x0a\xff")[0] == 13


def test_session_of_another_connection(emulator, tcp):
    other = Foreign(emulator)
    other.session = tcp.session
    assert other.call(0x200AF)[0] == 54
    other.socket.close()


def test_second_client_is_not_in_control_until_the_first_leaves(emulator, tcp):
    assert tcp.call(0x20098, field(1, 2))[0] == 0
    other = Foreign(emulator)
    other.login()
    assert other.call(0x20098, field(1, 2))[0] == 130
    assert other.call(0x200AF)[0] == 0
    assert other.call(0x20070)[0] == 0, "anybody may stop the arm"
    assert tcp.call(0x10002)[0] == 0
    assert other.call(0x20098, field(1, 2))[0] == 0
    other.socket.close()


def test_silent_session_ends(emulator):
    client = Foreign(emulator)
    client.call(0x10001, field(1, b"admin") + field(2, 200) + field(3, b"admin"))
    time.sleep(0.5)
    assert client.socket.recv(10) == b"", "the emulator hangs up"
    client.socket.close()


def test_faults_and_clearing_them(emulator, tcp):
    emulator.inject("fault=joint2:0x20")
    time.sleep(0.05)
    assert tcp.call(0x200AF)[1][1] == [4]
    assert tcp.call(0x200E2, waypoint([0, 15, 180, 230, 0, 55, 95], 1.0))[0] == 22
    assert tcp.call(0x20092)[0] == 0
    assert tcp.call(0x200AF)[1][1] == [7]
    assert tcp.call(0x20091)[0] == 0
    assert tcp.call(0x200E2, waypoint([0, 15, 180, 230, 0, 55, 95], 1.0))[0] == 25


def test_low_level_servoing_refuses_trajectories(tcp):
    assert tcp.call(0x20098, field(1, 3))[0] == 0
    assert tcp.call(0x200AF)[1][1] == [6]
    assert tcp.call(0x200E2, waypoint([0, 15, 180, 230, 0, 55, 95], 1.0))[0] == 75


def test_torque_offset_zeroes_one_joint(emulator, tcp):
    assert tcp.call(0xA0005, b"", device=2)[0] == 0
    client = Foreign(emulator, tcp=False)
    client.login()
    _, feedback = client.call(0x30003)
    torques = [struct.unpack("<f", parse(joint).get(6, [bytes(4)])[0])[0] for joint in feedback[3]]
    assert torques[1] == pytest.approx(0, abs=1e-5)
    assert torques[3] == pytest.approx(-emulator.backend.arm.gravity(HOME)[3], abs=1e-4)
    assert tcp.call(0xA0005, b"", device=9)[0] == 52
    client.socket.close()


def test_garbage_on_tcp_costs_only_its_own_connection(emulator, tcp):
    with socket.create_connection(("127.0.0.1", emulator.tcp_port)) as vandal:
        vandal.sendall(b"GET / HTTP/1.1\r\n\r\n" * 100)
        vandal.settimeout(2)
        with contextlib.suppress(ConnectionResetError):
            assert vandal.recv(10) == b""
    assert tcp.call(0x200AF)[0] == 0
