"""The arm's numbers with a name: states, modes, events, kinds of device, and the bits of its fault banks."""

from __future__ import annotations

from enum import IntEnum


class ArmState(IntEnum):
    """What the arm is doing."""

    UNSPECIFIED = 0
    BASE_INITIALIZATION = 1
    IDLE = 2
    INITIALIZATION = 3
    IN_FAULT = 4
    MAINTENANCE = 5
    SERVOING_LOW_LEVEL = 6
    SERVOING_READY = 7
    SERVOING_PLAYING_SEQUENCE = 8
    SERVOING_MANUALLY_CONTROLLED = 9
    BRAKE_RELEASING = 10


class ServoingMode(IntEnum):
    """Who closes the position loop."""

    UNSPECIFIED = 0
    SINGLE_LEVEL = 2
    LOW_LEVEL = 3


class ActionEvent(IntEnum):
    """What a notification tells of an action."""

    END = 1
    ABORT = 2
    PAUSE = 3
    START = 4


class GripperMode(IntEnum):
    """What a gripper command means."""

    SPEED = 2
    POSITION = 3


class DeviceType(IntEnum):
    """Kinds of device in the arm."""

    BASE = 1
    VISION = 2
    BIG_ACTUATOR = 3
    SMALL_ACTUATOR = 4
    INTERCONNECT = 5
    GRIPPER = 6


class Model(IntEnum):
    """Models of arm."""

    UNSPECIFIED = 0
    GEN3 = 1
    GEN3_LITE = 2


class EndEffector(IntEnum):
    """Grippers that the arm can be configured for."""

    UNSPECIFIED = 0
    NOT_INSTALLED = 1
    GEN3_LITE_2F = 2
    ROBOTIQ_2F_85 = 3
    ROBOTIQ_2F_140 = 4


class Vision(IntEnum):
    """Vision modules that the arm can be configured for."""

    UNSPECIFIED = 0
    NOT_INSTALLED = 1
    COLOR_AND_DEPTH = 2
    COLOR = 3


EMERGENCY_BITS = 0x800000 | 0x1000000
BASE_FAULTS = {
    0x1: "FIRMWARE_UPDATE_FAILURE",
    0x4: "MAXIMUM_AMBIENT_TEMPERATURE",
    0x8: "MAXIMUM_CORE_TEMPERATURE",
    0x10: "JOINT_FAULT",
    0x100: "BRAKE_REMOVAL_FAILURE",
    0x400: "UNABLE_TO_REACH_POSE",
    0x800: "JOINT_DETECTION_ERROR",
    0x1000: "NETWORK_INITIALIZATION_ERROR",
    0x2000: "MAXIMUM_CURRENT",
    0x4000: "MAXIMUM_VOLTAGE",
    0x8000: "MINIMUM_VOLTAGE",
    0x400000: "MAXIMUM_END_EFFECTOR_PAYLOAD",
    0x800000: "EMERGENCY_STOP_ACTIVATED",
    0x1000000: "EMERGENCY_LINE_ACTIVATED",
    0x40000000: "ARM_INTO_ILLEGAL_POSITION",
}
ACTUATOR_FAULTS = {
    0x1: "FOLLOWING_ERROR",
    0x2: "MAXIMUM_VELOCITY",
    0x4: "JOINT_LIMIT_HIGH",
    0x8: "JOINT_LIMIT_LOW",
    0x10: "STRAIN_GAUGE_MISMATCH",
    0x20: "MAXIMUM_TORQUE",
    0x40: "UNRELIABLE_ABSOLUTE_POSITION",
    0x80: "MAGNETIC_POSITION",
    0x2000: "MAXIMUM_MOTOR_CURRENT",
    0x8000: "MAXIMUM_VOLTAGE",
    0x10000: "MINIMUM_VOLTAGE",
    0x20000: "MAXIMUM_MOTOR_TEMPERATURE",
    0x40000: "MAXIMUM_CORE_TEMPERATURE",
    0x100000: "MOTOR_DRIVER_FAULT",
    0x200000: "EMERGENCY_LINE_ASSERTED",
    0x400000: "COMMUNICATION_TICK_LOST",
    0x800000: "WATCHDOG_TRIGGERED",
}
TRAJECTORY_ERRORS = {
    1: "OUTSIDE_WORKSPACE",
    2: "ACTUATOR_COUNT_MISMATCH",
    3: "INVALID_DURATION",
    4: "JOINT_NO_MOTION",
    5: "INVALID_JOINT_SPEED",
    7: "INVALID_JOINT_ACCELERATION",
    8: "INVALID_TIME_STEP",
    9: "INVALID_TRAJECTORY_SIZE",
    11: "INVALID_JOINT_POSITION",
    15: "TRAJECTORY_ALREADY_RUNNING",
    24: "INVALID_JOINT_TORQUE",
    30: "NUMERICAL_ERROR_IMPOSSIBLE_TRAJECTORY",
}


def bit_names(bank: int, names: dict[int, str]) -> tuple[str, ...]:
    """Return the names of the bits that are set, the number itself where a bit has none."""
    bits = (1 << shift for shift in range(32) if bank >> shift & 1)
    return tuple(names.get(bit, f"{bit:#x}") for bit in bits)


def name_of(kind: type[IntEnum], value: int) -> str:
    """Return the name of a number, the number itself where it has none."""
    try:
        return kind(value).name
    except ValueError:
        return str(value)
