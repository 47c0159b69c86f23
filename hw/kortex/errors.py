"""What can go wrong on the wire and on the arm, by name."""

from __future__ import annotations

from dynamics.errors import MotionRefused, PalpateError

ERROR_CODES = {1: "PROTOCOL_SERVER", 2: "PROTOCOL_CLIENT", 3: "DEVICE", 4: "INTERNAL"}

# Numbers of the published error list (ros_kortex, kortex_driver/protos/Errors.proto).
SUB_CODES = {
    1: "METHOD_FAILED",
    2: "UNIMPLEMENTED",
    3: "INVALID_PARAM",
    4: "UNSUPPORTED_SERVICE",
    5: "UNSUPPORTED_METHOD",
    6: "TOO_LARGE_ENCODED_FRAME_BUFFER",
    7: "FRAME_ENCODING_ERR",
    8: "FRAME_DECODING_ERR",
    9: "INCOMPATIBLE_HEADER_VERSION",
    10: "UNSUPPORTED_FRAME_TYPE",
    12: "INVALID_SESSION",
    13: "PAYLOAD_DECODING_ERR",
    15: "INVALID_PASSWORD",
    16: "USER_NOT_FOUND",
    17: "ENTITY_NOT_FOUND",
    18: "ROBOT_MOVEMENT_IN_PROGRESS",
    19: "ROBOT_NOT_MOVING",
    21: "ROBOT_NOT_READY",
    22: "ROBOT_IN_FAULT",
    23: "ROBOT_IN_MAINTENANCE",
    25: "ROBOT_IN_EMERGENCY_STOP",
    26: "SINGLE_LEVEL_SERVOING",
    27: "LOW_LEVEL_SERVOING",
    48: "VALUE_IS_ABOVE_MAXIMUM",
    49: "VALUE_IS_BELOW_MINIMUM",
    50: "DEVICE_DISCONNECTED",
    51: "DEVICE_NOT_READY",
    52: "INVALID_DEVICE",
    53: "SAFETY_THRESHOLD_REACHED",
    54: "INVALID_USER_SESSION_ACCESS",
    55: "CONTROL_MANUAL_STOP",
    56: "CONTROL_OUTSIDE_WORKSPACE",
    57: "CONTROL_ACTUATOR_COUNT_MISMATCH",
    58: "CONTROL_INVALID_DURATION",
    59: "CONTROL_INVALID_SPEED",
    60: "CONTROL_LARGE_SPEED",
    61: "CONTROL_INVALID_ACCELERATION",
    64: "CONTROL_WRONG_MODE",
    65: "CONTROL_JOINT_POSITION_LIMIT",
    68: "CONTROL_ALREADY_RUNNING",
    69: "CONTROL_WRONG_STARTING_POINT",
    73: "CONTROL_NO_ACTION",
    75: "WRONG_SERVOING_MODE",
    130: "SESSION_NOT_IN_CONTROL",
    131: "METHOD_TIMEOUT",
    132: "UNSUPPORTED_ROBOT_CONFIGURATION",
    136: "READ_PERMISSION_DENIED",
    138: "ACTION_IN_USE",
    139: "SEND_FAILED",
    140: "CONTROL_WAYPOINT_TRAJECTORY_ABORTED",
    141: "CONTROL_PERMISSION_DENIED",
}


def sub_code_name(sub_code: int) -> str:
    """Return the published name of a sub code, or its number."""
    return SUB_CODES.get(sub_code, f"SUB_CODE_{sub_code}")


class KortexError(PalpateError):
    """Base class of what goes wrong between this program and the arm."""


class FrameError(KortexError):
    """Bytes from the network are not a Kortex frame."""


class ConnectionFailed(KortexError):
    """No connection to the arm could be made."""


class ConnectionLost(KortexError):
    """The connection to the arm broke."""


class RpcTimeout(KortexError):
    """The arm did not answer a request in time."""


class RpcError(KortexError):
    """The arm answered a request with an error.

    Attributes:
        method: what was asked for.
        code, sub_code: the arm's numbers.
        text: the arm's words.
    """

    def __init__(self, method: str, code: int, sub_code: int, text: str = "") -> None:
        self.method, self.code, self.sub_code, self.text = method, code, sub_code, text
        kind = ERROR_CODES.get(code, f"CODE_{code}")
        words = f": {text}" if text else ""
        super().__init__(
            f"{method} was refused by the arm: {kind} / {sub_code_name(sub_code)} ({sub_code}){words}"
        )


class LoginRefused(RpcError):
    """The arm does not know the user or the password."""


class NotInControl(RpcError):
    """Another client controls the arm."""


class SessionLost(RpcError):
    """The arm has ended the session."""


class RobotNotReady(RpcError):
    """The arm is in a state in which it does not obey."""


_CLASSES: dict[int, type[RpcError]] = {
    12: SessionLost,
    15: LoginRefused,
    16: LoginRefused,
    21: RobotNotReady,
    22: RobotNotReady,
    23: RobotNotReady,
    25: RobotNotReady,
    54: NotInControl,
    75: RobotNotReady,
    130: NotInControl,
    141: NotInControl,
}


def rpc_error(method: str, code: int, sub_code: int, text: str = "") -> RpcError:
    """Return the error of an answer, in the class that says what can be done about it."""
    return _CLASSES.get(sub_code, RpcError)(method, code, sub_code, text)


class FeedbackLost(KortexError):
    """The arm's feedback stopped; the arm was told to stop."""


class ArmFault(KortexError):
    """The arm reports a fault; it does not move until the fault is cleared.

    Attributes:
        faults: their names, each with its place.
    """

    def __init__(self, faults: tuple[str, ...]) -> None:
        self.faults = faults
        super().__init__(f"the arm reports a fault: {', '.join(faults)}")


class EmergencyStopped(ArmFault):
    """The emergency stop is active."""


class TrajectoryAborted(KortexError):
    """The arm gave up a trajectory."""


class MotionTimeout(KortexError):
    """A motion did not end when it should have; the arm was told to stop."""


class GripperStuck(KortexError):
    """The gripper was told to move and neither moved nor pressed."""


class LimitExceeded(KortexError):
    """A measured quantity left its limit; the arm was told to stop."""


class CheckFailed(KortexError):
    """The check before the first motion found what makes moving unsafe.

    Attributes:
        problems: one line each.
    """

    def __init__(self, problems: tuple[str, ...]) -> None:
        self.problems = problems
        super().__init__("the arm is not safe to move: " + "; ".join(problems))


class NotConfirmed(MotionRefused):
    """Nobody agreed to the first motion; nothing has moved."""
