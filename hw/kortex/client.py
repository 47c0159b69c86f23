"""The arm's services as functions: what the driver asks of the arm, and nothing more."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from hw.kortex import messages_pb2 as pb
from hw.kortex import methods
from hw.kortex.codes import ActionEvent, DeviceType, GripperMode, ServoingMode
from hw.kortex.errors import TrajectoryAborted, sub_code_name
from hw.kortex.exchange import parse
from hw.kortex.tcp import TcpSession

STOP_TIMEOUT = 0.4  # s
GRIPPER_FINGER = 1


@dataclass(frozen=True)
class Product:
    """What the arm says it is.

    Attributes:
        model, joints, end_effector, vision, brakes: numbers of the product configuration.
        serial: of the arm.
        firmware: version of the firmware bundle, empty where the arm does not tell.
    """

    model: int
    joints: int
    end_effector: int
    vision: int
    brakes: int
    serial: str
    firmware: str = ""


@dataclass(frozen=True)
class ActionResult:
    """How an action of the arm went on.

    Attributes:
        event: what happened.
        reason: sub code of an abort.
    """

    event: int
    reason: int = 0

    @property
    def final(self) -> bool:
        """Whether nothing more will come of the action."""
        return self.event in (ActionEvent.END, ActionEvent.ABORT)

    def raise_if_aborted(self) -> None:
        """Raise TrajectoryAborted unless the action came to its end."""
        if self.event == ActionEvent.ABORT:
            raise TrajectoryAborted(
                f"the arm gave the trajectory up: {sub_code_name(self.reason)} ({self.reason})"
            )


def product(session: TcpSession) -> Product:
    """Return what the arm says it is."""
    found = session.request(methods.GET_PRODUCT_CONFIGURATION)
    count = session.request(methods.GET_ACTUATOR_COUNT).count
    return Product(
        model=found.model,
        joints=count or found.degrees_of_freedom,
        end_effector=found.end_effector_type,
        vision=found.vision_module_type,
        brakes=found.brake_type,
        serial=found.serial,
    )


def arm_state(session: TcpSession) -> int:
    """Return what the arm is doing, a number of ArmState."""
    return int(session.request(methods.GET_ARM_STATE).active_state)


def servoing_mode(session: TcpSession) -> int:
    """Return who closes the position loop, a number of ServoingMode."""
    return int(session.request(methods.GET_SERVOING_MODE).servoing_mode)


def take_control(session: TcpSession) -> None:
    """Put the arm into single-level servoing, which takes control of it."""
    session.request(methods.SET_SERVOING_MODE, pb.ServoingModeInformation(servoing_mode=ServoingMode.SINGLE_LEVEL))


def speed_limits(session: TcpSession) -> tuple[float, ...]:
    """Return the arm's own speed limits [deg/s], one a joint."""
    return tuple(session.request(methods.GET_KINEMATIC_HARD_LIMITS).joint_speed_limits)


def tool_mass(session: TcpSession) -> float:
    """Return the mass of the tool that the arm's own model counts with [kg]."""
    return float(session.request(methods.GET_TOOL).tool_mass)


def payload_mass(session: TcpSession) -> float:
    """Return the payload that the arm's own model counts with [kg]."""
    return float(session.request(methods.GET_PAYLOAD).payload_mass)


def actuators(session: TcpSession) -> tuple[int, ...]:
    """Return the devices that are joints, in order from the base."""
    kinds = (DeviceType.BIG_ACTUATOR, DeviceType.SMALL_ACTUATOR)
    devices = session.request(methods.READ_ALL_DEVICES).device_handle
    joints = sorted((d for d in devices if d.device_type in kinds), key=lambda d: d.order)
    return tuple(int(device.device_identifier) for device in joints)


def on_action(session: TcpSession, sink: Callable[[ActionResult], None]) -> int:
    """Hand every event of the arm's actions to a function; return the subscription's number."""

    def take(payload: bytes) -> None:
        event = parse(pb.ActionNotification, payload, "notification of an action")
        sink(ActionResult(event.action_event, event.abort_details))

    return session.subscribe(methods.ACTION_TOPIC, take)


def waypoint_list(angles: Sequence[Sequence[float]], durations: Sequence[float]) -> pb.WaypointList:
    """Return the arm's form of waypoints.

    Args:
        angles: joint angles of each waypoint [deg].
        durations: time to each from the one before [s]; the first starts where the arm stands.
    """
    points = [
        pb.Waypoint(name=f"waypoint-{number}", angular_waypoint=pb.AngularWaypoint(angles=q, duration=duration))
        for number, (q, duration) in enumerate(zip(angles, durations, strict=True))
    ]
    return pb.WaypointList(waypoints=points, use_optimal_blending=False)


def validate(session: TcpSession, waypoints: pb.WaypointList) -> pb.TrajectoryErrorReport:
    """Return what the arm finds wrong with waypoints; nothing moves."""
    return session.request(methods.VALIDATE_WAYPOINT_LIST, waypoints).trajectory_error_report


def execute(session: TcpSession, waypoints: pb.WaypointList) -> None:
    """Start moving along waypoints; notifications tell how it goes."""
    session.request(methods.EXECUTE_WAYPOINT_TRAJECTORY, waypoints)


def gripper_position(session: TcpSession, closed: float) -> None:
    """Send the gripper to a position, 0 open to 1 closed."""
    _gripper(session, GripperMode.POSITION, closed)


def gripper_speed(session: TcpSession, closing: float) -> None:
    """Let the gripper run, 1 closing at full speed, -1 opening, 0 standing."""
    _gripper(session, GripperMode.SPEED, -closing)


def _gripper(session: TcpSession, mode: GripperMode, value: float) -> None:
    fingers = pb.Gripper(finger=[pb.Finger(finger_identifier=GRIPPER_FINGER, value=value)])
    session.request(methods.SEND_GRIPPER_COMMAND, pb.GripperCommand(mode=mode, gripper=fingers))


def stop(session: TcpSession) -> None:
    """Stop every motion of the arm."""
    session.request(methods.STOP, timeout=STOP_TIMEOUT)


def set_torque_offset(session: TcpSession, device: int, offset: float) -> None:
    """Tell a joint what its torque is now [N m]; 0 zeroes the reading."""
    session.request(methods.SET_TORQUE_OFFSET, pb.TorqueOffset(torque_offset=offset), device=device)
