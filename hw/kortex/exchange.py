"""Requests and answers: how a method becomes a frame, and a frame an answer or an error."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, TypeVar

from google.protobuf.message import DecodeError, Message

from hw.kortex import messages_pb2 as pb
from hw.kortex.errors import FrameError, rpc_error
from hw.kortex.frame import Frame, FrameType
from hw.kortex.methods import A, Method

M = TypeVar("M", bound=Message)


@dataclass(frozen=True)
class Credentials:
    """Who logs in. The password appears in no representation."""

    user: str
    password: str = field(repr=False)


@dataclass(frozen=True)
class Timeouts:
    """How long to wait [s].

    Attributes:
        connect: for a connection.
        request: for the answer to a request on TCP.
        datagram: for the answer to one datagram, before it is sent again.
        session, connection: inactivity after which the arm ends the session and the connection.
    """

    connect: float = 2.0
    request: float = 1.5
    datagram: float = 0.006
    session: float = 10.0
    connection: float = 5.0


def session_request(credentials: Credentials, timeouts: Timeouts) -> pb.CreateSessionInfo:
    """Return the message that opens a session."""
    return pb.CreateSessionInfo(
        username=credentials.user,
        password=credentials.password,
        session_inactivity_timeout=round(timeouts.session * 1000),
        connection_inactivity_timeout=round(timeouts.connection * 1000),
    )


def request_frame(method: Method[Any, Any], message: Message, number: int, session: int, device: int = 0) -> Frame:
    """Return the frame of a request."""
    if not isinstance(message, method.request):
        raise TypeError(f"{method.name} takes {method.request.__name__}, not {type(message).__name__}")
    return Frame(FrameType.REQUEST, method.number, number, session, device, payload=message.SerializeToString())


def parse(kind: type[M], payload: bytes, where: str) -> M:
    """Return the message of a payload.

    Raises:
        FrameError: if it is none.
    """
    try:
        return kind.FromString(payload)
    except DecodeError:
        raise FrameError(f"{where}: {len(payload)} bytes that are no {kind.__name__}") from None


def answer(method: Method[Any, A], frame: Frame) -> A:
    """Return the message of an answer.

    Raises:
        RpcError: if the answer is an error.
        FrameError: if its payload is no message of the method.
    """
    if frame.error_code:
        error = parse(pb.Error, frame.payload, f"error answer to {method.name}")
        code = error.error_code or frame.error_code
        raise rpc_error(method.name, code, error.error_sub_code or frame.error_sub_code, error.error_sub_string)
    return parse(method.response, frame.payload, f"answer to {method.name}")
