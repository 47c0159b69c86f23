"""The arm's methods that are used here: number, device, what goes in and what comes out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from google.protobuf.message import Message

from hw.kortex import messages_pb2 as pb

Q = TypeVar("Q", bound=Message)
A = TypeVar("A", bound=Message)


@dataclass(frozen=True)
class Method(Generic[Q, A]):
    """A remote method.

    Attributes:
        name: service and method, as published.
        number: service << 16 | method within it.
        request, response: types of its messages.
        control: whether it needs control of the arm.
    """

    name: str
    number: int
    request: type[Q]
    response: type[A]
    control: bool = False


CREATE_SESSION = Method("Session.CreateSession", 0x10001, pb.CreateSessionInfo, pb.Empty)
CLOSE_SESSION = Method("Session.CloseSession", 0x10002, pb.Empty, pb.Empty)
KEEP_ALIVE = Method("Session.KeepAlive", 0x10003, pb.Empty, pb.Empty)

READ_ALL_ACTIONS = Method("Base.ReadAllActions", 0x2002C, pb.RequestedActionType, pb.ActionList)
EXECUTE_ACTION_FROM_REFERENCE = Method(
    "Base.ExecuteActionFromReference", 0x2002F, pb.ActionHandle, pb.Empty, control=True
)
EXECUTE_ACTION = Method("Base.ExecuteAction", 0x20030, pb.Action, pb.Empty, control=True)
STOP_ACTION = Method("Base.StopAction", 0x20032, pb.Empty, pb.Empty)
UNSUBSCRIBE = Method("Base.Unsubscribe", 0x20061, pb.NotificationHandle, pb.Empty)
ACTION_TOPIC = Method("Base.ActionTopic", 0x2006A, pb.NotificationOptions, pb.NotificationHandle)
STOP = Method("Base.Stop", 0x20070, pb.Empty, pb.Empty)
PLAY_JOINT_TRAJECTORY = Method(
    "Base.PlayJointTrajectory", 0x2007C, pb.ConstrainedJointAngles, pb.Empty, control=True
)
GET_MEASURED_JOINT_ANGLES = Method("Base.GetMeasuredJointAngles", 0x2007E, pb.Empty, pb.JointAngles)
SEND_GRIPPER_COMMAND = Method("Base.SendGripperCommand", 0x20088, pb.GripperCommand, pb.Empty, control=True)
GET_MEASURED_GRIPPER_MOVEMENT = Method("Base.GetMeasuredGripperMovement", 0x20089, pb.GripperRequest, pb.Gripper)
APPLY_EMERGENCY_STOP = Method("Base.ApplyEmergencyStop", 0x20091, pb.Empty, pb.Empty)
CLEAR_FAULTS = Method("Base.ClearFaults", 0x20092, pb.Empty, pb.Empty, control=True)
SET_SERVOING_MODE = Method("Base.SetServoingMode", 0x20098, pb.ServoingModeInformation, pb.Empty, control=True)
GET_SERVOING_MODE = Method("Base.GetServoingMode", 0x20099, pb.Empty, pb.ServoingModeInformation)
GET_ACTUATOR_COUNT = Method("Base.GetActuatorCount", 0x200AB, pb.Empty, pb.ActuatorInformation)
GET_ARM_STATE = Method("Base.GetArmState", 0x200AF, pb.Empty, pb.ArmStateInformation)
GET_PRODUCT_CONFIGURATION = Method("Base.GetProductConfiguration", 0x200C6, pb.Empty, pb.ProductConfiguration)
GET_FIRMWARE = Method("Base.GetFirmwareBundleVersions", 0x200E0, pb.Empty, pb.FirmwareBundleVersions)
EXECUTE_WAYPOINT_TRAJECTORY = Method(
    "Base.ExecuteWaypointTrajectory", 0x200E2, pb.WaypointList, pb.Empty, control=True
)
VALIDATE_WAYPOINT_LIST = Method("Base.ValidateWaypointList", 0x200EB, pb.WaypointList, pb.WaypointValidationReport)

REFRESH_FEEDBACK = Method("BaseCyclic.RefreshFeedback", 0x30003, pb.Empty, pb.Feedback)

SET_TORQUE_OFFSET = Method("ActuatorConfig.SetTorqueOffset", 0xA0005, pb.TorqueOffset, pb.Empty, control=True)
GET_TORQUE_OFFSET = Method("ActuatorConfig.GetTorqueOffset", 0xA001E, pb.Empty, pb.TorqueOffset)

GET_PAYLOAD = Method("ControlConfig.GetPayloadInformation", 0x100004, pb.Empty, pb.PayloadInformation)
GET_TOOL = Method("ControlConfig.GetToolConfiguration", 0x100006, pb.Empty, pb.ToolConfiguration)
GET_KINEMATIC_HARD_LIMITS = Method("ControlConfig.GetKinematicHardLimits", 0x100012, pb.Empty, pb.KinematicLimits)

READ_ALL_DEVICES = Method("DeviceManager.ReadAllDevices", 0x170001, pb.Empty, pb.DeviceHandles)

METHODS: dict[int, Method[Any, Any]] = {
    value.number: value for value in list(globals().values()) if isinstance(value, Method)
}
