"""What the emulated arm does with a request: one small function a method."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import Any

import numpy as np
from google.protobuf.message import DecodeError, Message
from numpy.typing import NDArray

from dynamics.trajectory import Trajectory
from hw.emulator.backend import Backend
from hw.emulator.feedback import Health, feedback
from hw.emulator.sessions import DEVICE, SERVER, Refusal, Session, Sessions
from hw.emulator.trajectories import Invalid, through_waypoints, to_angles
from hw.kortex import codes, methods, units
from hw.kortex import messages_pb2 as pb
from hw.kortex.codes import ActionEvent, ArmState, DeviceType, GripperMode, ServoingMode
from hw.kortex.frame import Frame, FrameType

Array = NDArray[np.float64]

UNSUPPORTED_SERVICE, UNSUPPORTED_METHOD, PAYLOAD_DECODING = 4, 5, 13
INVALID_PARAM, NOT_FOUND, MOVING, IN_FAULT, IN_EMERGENCY, WRONG_MODE = 3, 17, 18, 22, 25, 75
MANUAL_STOP, ABORTED, INVALID_DEVICE = 55, 140, 52
NAMED = {
    1: ("Home", [0, 15, 180, 230, 0, 55, 90]),
    2: ("Retract", [0, 340, 180, 214, 0, 310, 90]),
    3: ("Zero", [0] * 7),
}
REACH_JOINT_ANGLES, WAYPOINTS = 7, 41
Notify = Callable[[Hashable, Frame], None]


@dataclass(frozen=True)
class Identity:
    """What the emulated arm says it is.

    Attributes:
        model: number of the model, codes.Model.
        joints: how many it claims to have.
        vision, brakes: numbers of the product configuration.
    """

    model: int = codes.Model.GEN3
    joints: int = 7
    vision: int = codes.Vision.COLOR_AND_DEPTH
    brakes: int = 1


class Services:
    """The emulated arm behind its sockets.

    Args:
        backend: the robot.
        users: passwords by name.
        identity: what the arm says it is.
        notify: sends a frame to a client.
    """

    def __init__(self, backend: Backend, users: dict[str, str], identity: Identity, notify: Notify) -> None:
        self.backend, self.identity = backend, identity
        self.sessions = Sessions(users)
        self._notify = notify
        self._subscribers: dict[int, Session] = {}
        self._next_subscription = 0
        self._mode = ServoingMode.SINGLE_LEVEL
        self._base_faults, self._joint_faults = 0, [0] * backend.arm.nv
        self._torque_offset = np.zeros(backend.arm.nv)
        self._action: pb.ActionHandle | None = None
        self._reference: Array | None = None
        self._actions = self._frames = 0
        self.motions = 0
        self._handlers = self._table()

    def handle(self, request: Frame, client: Hashable, now: float) -> Frame:
        """Return the answer to a request."""
        try:
            message, session = self._dispatch(request, client, now)
            return Frame(FrameType.RESPONSE, request.method, request.message, session, payload=message)
        except Refusal as refusal:
            error = pb.Error(
                error_code=refusal.code, error_sub_code=refusal.sub_code, error_sub_string=refusal.words
            )
            return Frame(
                FrameType.RESPONSE,
                request.method,
                request.message,
                request.session,
                error_code=refusal.code,
                error_sub_code=refusal.sub_code,
                payload=error.SerializeToString(),
            )

    def poll(self) -> None:
        """Tell the subscribers of an action that has ended."""
        if self._action is None:
            return
        state = self.backend.state()
        if not state.arm_moving:
            self._reference = None if state.failed else self._reference
            self._finish(ActionEvent.ABORT if state.failed else ActionEvent.END, ABORTED if state.failed else 0)

    def fail(self, place: int, bits: int) -> None:
        """Let the arm fall into a fault: of the base (0) or of a joint."""
        if place > self.backend.arm.nv:
            return
        if place:
            self._joint_faults[place - 1] |= bits
            bits = 0x10
        self._base_faults |= bits
        self._halt(IN_EMERGENCY if bits & codes.EMERGENCY_BITS else IN_FAULT)

    def abort(self) -> None:
        """Give the running trajectory up."""
        self._halt(ABORTED)

    def _dispatch(self, request: Frame, client: Hashable, now: float) -> tuple[bytes, int]:
        method = methods.METHODS.get(request.method)
        handler = self._handlers.get(request.method)
        if method is None or handler is None:
            known = {number >> 16 for number in self._handlers}
            served = request.method >> 16 in known
            raise Refusal(SERVER, UNSUPPORTED_METHOD if served else UNSUPPORTED_SERVICE, f"{request.method:#x}")
        try:
            message = method.request.FromString(request.payload)
        except DecodeError:
            raise Refusal(SERVER, PAYLOAD_DECODING, f"no {method.request.__name__}") from None
        if method is methods.CREATE_SESSION:
            session = self.sessions.open(client, message, now)
        else:
            session = self.sessions.find(request.session, client, now)
        if method.control:
            self.sessions.take_control(session)
        reply: Message | None = handler(session, message, request.device)
        return b"" if reply is None else reply.SerializeToString(), session.number

    def _table(self) -> dict[int, Callable[[Session, Any, int], Message | None]]:
        """Return the function of each method that is served."""
        arm = self.backend.arm
        table: dict[Any, Callable[[Session, Any, int], Message | None]] = {
            methods.CREATE_SESSION: lambda session, message, device: None,
            methods.CLOSE_SESSION: lambda session, message, device: self.sessions.close(session),
            methods.KEEP_ALIVE: lambda session, message, device: None,
            methods.READ_ALL_ACTIONS: self._named_actions,
            methods.EXECUTE_ACTION_FROM_REFERENCE: self._execute_reference,
            methods.EXECUTE_ACTION: self._execute,
            methods.STOP_ACTION: lambda session, message, device: self._halt(MANUAL_STOP, gripper=False),
            methods.STOP: lambda session, message, device: self._halt(MANUAL_STOP),
            methods.UNSUBSCRIBE: self._unsubscribe,
            methods.ACTION_TOPIC: self._subscribe,
            methods.PLAY_JOINT_TRAJECTORY: lambda session, message, device: self._reach(message),
            methods.GET_MEASURED_JOINT_ANGLES: self._joint_angles,
            methods.SEND_GRIPPER_COMMAND: self._grip,
            methods.GET_MEASURED_GRIPPER_MOVEMENT: self._gripper_movement,
            methods.APPLY_EMERGENCY_STOP: lambda session, message, device: self.fail(0, 0x800000),
            methods.CLEAR_FAULTS: self._clear,
            methods.SET_SERVOING_MODE: self._set_mode,
            methods.GET_SERVOING_MODE: lambda session, message, device: pb.ServoingModeInformation(
                servoing_mode=self._mode
            ),
            methods.GET_ACTUATOR_COUNT: lambda session, message, device: pb.ActuatorInformation(
                count=self.identity.joints
            ),
            methods.GET_ARM_STATE: lambda session, message, device: pb.ArmStateInformation(
                active_state=self._state()
            ),
            methods.GET_PRODUCT_CONFIGURATION: self._product,
            methods.GET_FIRMWARE: lambda session, message, device: pb.FirmwareBundleVersions(
                main_bundle_version="emulator"
            ),
            methods.EXECUTE_WAYPOINT_TRAJECTORY: lambda session, message, device: self._follow(message),
            methods.VALIDATE_WAYPOINT_LIST: self._validate,
            methods.REFRESH_FEEDBACK: self._feedback,
            methods.SET_TORQUE_OFFSET: self._set_torque_offset,
            methods.GET_TORQUE_OFFSET: lambda session, message, device: pb.TorqueOffset(),  # as the arm: always 0
            methods.GET_PAYLOAD: lambda session, message, device: pb.PayloadInformation(),
            methods.GET_TOOL: lambda session, message, device: pb.ToolConfiguration(
                tool_mass=0.925, tool_transform=pb.CartesianTransform(z=0.12)
            ),
            methods.GET_KINEMATIC_HARD_LIMITS: lambda session, message, device: pb.KinematicLimits(
                joint_speed_limits=units.velocities_to_arm(arm.velocity_limit)
            ),
            methods.READ_ALL_DEVICES: self._devices,
        }
        return {method.number: handler for method, handler in table.items()}

    # ---- state

    def _state(self) -> int:
        if self._base_faults or any(self._joint_faults):
            return ArmState.IN_FAULT
        return ArmState.SERVOING_READY if self._mode == ServoingMode.SINGLE_LEVEL else ArmState.SERVOING_LOW_LEVEL

    def _feedback(self, session: Session, message: pb.Empty, device: int) -> pb.Feedback:
        self._frames += 1
        health = Health(self._state(), self._base_faults, tuple(self._joint_faults), self._torque_offset)
        backend = self.backend
        return feedback(self._frames, backend.state(), backend.arm, backend.gripper, health)

    def _product(self, session: Session, message: pb.Empty, device: int) -> pb.ProductConfiguration:
        return pb.ProductConfiguration(
            serial="EMULATOR",
            model=self.identity.model,
            degrees_of_freedom=self.identity.joints,
            end_effector_type=codes.EndEffector.ROBOTIQ_2F_85,
            vision_module_type=self.identity.vision,
            brake_type=self.identity.brakes,
        )

    def _devices(self, session: Session, message: pb.Empty, device: int) -> pb.DeviceHandles:
        joints = [DeviceType.BIG_ACTUATOR] * 4 + [DeviceType.SMALL_ACTUATOR] * 3
        kinds = [DeviceType.BASE, *joints[: self.backend.arm.nv], DeviceType.INTERCONNECT, DeviceType.GRIPPER]
        handles = [
            pb.DeviceHandle(device_type=kind, device_identifier=number, order=number)
            for number, kind in enumerate(kinds)
        ]
        return pb.DeviceHandles(device_handle=handles)

    def _joint_angles(self, session: Session, message: pb.Empty, device: int) -> pb.JointAngles:
        angles = units.angles_to_arm(self.backend.state().sample.q)
        return pb.JointAngles(
            joint_angles=[pb.JointAngle(joint_identifier=i, value=angle) for i, angle in enumerate(angles)]
        )

    def _gripper_movement(self, session: Session, message: pb.GripperRequest, device: int) -> pb.Gripper:
        state = self.backend.state()
        closed = units.percent_from_opening(self.backend.gripper, state.sample.opening) / 100
        value = (
            closed
            if message.mode == GripperMode.POSITION
            else state.gripper_speed / self.backend.gripper.max_speed
        )
        return pb.Gripper(finger=[pb.Finger(finger_identifier=1, value=value)])

    def _set_mode(self, session: Session, message: pb.ServoingModeInformation, device: int) -> None:
        if message.servoing_mode not in (ServoingMode.SINGLE_LEVEL, ServoingMode.LOW_LEVEL):
            raise Refusal(DEVICE, INVALID_PARAM, f"servoing mode {message.servoing_mode}")
        self._mode = ServoingMode(message.servoing_mode)

    def _set_torque_offset(self, session: Session, message: pb.TorqueOffset, device: int) -> None:
        if not 1 <= device <= self.backend.arm.nv:
            raise Refusal(DEVICE, INVALID_DEVICE, f"device {device} is no joint")
        raw = units.torques_to_arm(self.backend.state().sample.tau)[device - 1]
        self._torque_offset[device - 1] = raw - message.torque_offset

    def _clear(self, session: Session, message: pb.Empty, device: int) -> None:
        self._base_faults, self._joint_faults = 0, [0] * self.backend.arm.nv

    # ---- notifications

    def _subscribe(self, session: Session, message: pb.NotificationOptions, device: int) -> pb.NotificationHandle:
        self._next_subscription += 1
        self._subscribers[self._next_subscription] = session
        return pb.NotificationHandle(identifier=self._next_subscription)

    def _unsubscribe(self, session: Session, message: pb.NotificationHandle, device: int) -> None:
        self._subscribers.pop(message.identifier, None)

    def _tell(self, handle: pb.ActionHandle, event: ActionEvent, reason: int = 0) -> None:
        payload = pb.ActionNotification(action_event=event, handle=handle, abort_details=reason)
        for number, session in self._subscribers.items():
            method = methods.ACTION_TOPIC.number
            frame = Frame(
                FrameType.NOTIFICATION, method, number, session.number, payload=payload.SerializeToString()
            )
            self._notify(session.client, frame)

    def _finish(self, event: ActionEvent, reason: int = 0) -> None:
        if self._action is not None:
            handle, self._action = self._action, None
            self._tell(handle, event, reason)

    # ---- motion

    def _ready(self) -> None:
        """Refuse a motion in a state in which the arm does not obey."""
        if self._base_faults & codes.EMERGENCY_BITS:
            raise Refusal(DEVICE, IN_EMERGENCY, "the emergency stop is active")
        if self._state() == ArmState.IN_FAULT:
            raise Refusal(DEVICE, IN_FAULT, "the arm is in a fault")
        if self._mode != ServoingMode.SINGLE_LEVEL:
            raise Refusal(DEVICE, WRONG_MODE, "the arm is in low-level servoing")

    def _start(self, plan: Callable[[], Any], kind: int) -> None:
        self._ready()
        self.poll()
        if self._action is not None:
            raise Refusal(DEVICE, MOVING, "the arm is moving")
        try:
            trajectory: Trajectory = plan()
        except Invalid as invalid:
            raise Refusal(DEVICE, INVALID_PARAM, str(invalid)) from None
        self._actions += 1
        self.motions += 1
        self._action = pb.ActionHandle(identifier=self._actions, action_type=kind)
        self.backend.start_trajectory(trajectory)
        self._reference = trajectory.q[-1]
        self._tell(self._action, ActionEvent.START)

    def _standing(self) -> Array:
        """Return where the joints are commanded to be: servos give way a little under load."""
        return self.backend.state().sample.q if self._reference is None else self._reference

    def _follow(self, waypoints: pb.WaypointList) -> None:
        q = self._standing()
        self._start(lambda: through_waypoints(self.backend.arm, q, waypoints), WAYPOINTS)

    def _reach(self, command: pb.ConstrainedJointAngles) -> None:
        q = self._standing()
        self._start(lambda: to_angles(self.backend.arm, q, command), REACH_JOINT_ANGLES)

    def _execute(self, session: Session, message: pb.Action, device: int) -> None:
        if message.HasField("execute_waypoint_list"):
            self._follow(message.execute_waypoint_list)
        elif message.HasField("reach_joint_angles"):
            self._reach(message.reach_joint_angles)
        else:
            raise Refusal(DEVICE, INVALID_PARAM, "an action of another kind")

    def _execute_reference(self, session: Session, message: pb.ActionHandle, device: int) -> None:
        if message.identifier not in NAMED:
            raise Refusal(DEVICE, NOT_FOUND, f"action {message.identifier}")
        self._reach(_named(message.identifier).reach_joint_angles)

    def _named_actions(self, session: Session, message: pb.RequestedActionType, device: int) -> pb.ActionList:
        if message.action_type not in (0, REACH_JOINT_ANGLES):
            return pb.ActionList()
        return pb.ActionList(action_list=[_named(number) for number in NAMED])

    def _validate(self, session: Session, message: pb.WaypointList, device: int) -> pb.WaypointValidationReport:
        try:
            through_waypoints(self.backend.arm, self._standing(), message)
        except Invalid as invalid:
            report = pb.TrajectoryErrorReport(trajectory_error_elements=[invalid.element])
            return pb.WaypointValidationReport(trajectory_error_report=report)
        return pb.WaypointValidationReport(optimal_waypoint_list=message)

    def _grip(self, session: Session, message: pb.GripperCommand, device: int) -> None:
        self._ready()
        if len(message.gripper.finger) != 1 or message.mode not in (GripperMode.SPEED, GripperMode.POSITION):
            raise Refusal(DEVICE, INVALID_PARAM, "a gripper command that is neither a speed nor a position")
        gripper, value = self.backend.gripper, message.gripper.finger[0].value
        if not abs(value) <= 1 or (message.mode == GripperMode.POSITION and value < 0):
            raise Refusal(DEVICE, INVALID_PARAM, f"gripper value {value:g}")
        if message.mode == GripperMode.POSITION:
            self.backend.start_grip(units.opening_from_percent(gripper, 100 * value), gripper.max_speed)
        elif value == 0:
            self.backend.halt_gripper()
            return
        else:
            target = gripper.max_opening if value > 0 else 0.0
            self.backend.start_grip(target, units.speed_from_share(gripper, value))
        self.motions += 1

    def _halt(self, reason: int, gripper: bool = True) -> None:
        self.backend.halt_arm()
        self._reference = None
        if gripper:
            self.backend.halt_gripper()
        self._finish(ActionEvent.ABORT, reason)


def _named(number: int) -> pb.Action:
    """Return one of the actions that the arm knows by name."""
    name, angles = NAMED[number]
    joints = [pb.JointAngle(joint_identifier=i, value=angle) for i, angle in enumerate(angles)]
    return pb.Action(
        handle=pb.ActionHandle(identifier=number, action_type=REACH_JOINT_ANGLES),
        name=name,
        reach_joint_angles=pb.ConstrainedJointAngles(joint_angles=pb.JointAngles(joint_angles=joints)),
    )
