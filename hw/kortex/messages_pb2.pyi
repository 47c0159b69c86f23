from google.protobuf.internal import containers as _containers
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class Header(_message.Message):
    __slots__ = ("frame_info", "message_info", "service_info", "payload_info")
    FRAME_INFO_FIELD_NUMBER: _ClassVar[int]
    MESSAGE_INFO_FIELD_NUMBER: _ClassVar[int]
    SERVICE_INFO_FIELD_NUMBER: _ClassVar[int]
    PAYLOAD_INFO_FIELD_NUMBER: _ClassVar[int]
    frame_info: int
    message_info: int
    service_info: int
    payload_info: int
    def __init__(self, frame_info: _Optional[int] = ..., message_info: _Optional[int] = ..., service_info: _Optional[int] = ..., payload_info: _Optional[int] = ...) -> None: ...

class Frame(_message.Message):
    __slots__ = ("header", "payload")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    PAYLOAD_FIELD_NUMBER: _ClassVar[int]
    header: Header
    payload: bytes
    def __init__(self, header: _Optional[_Union[Header, _Mapping[str, object]]] = ..., payload: _Optional[bytes] = ...) -> None: ...

class Error(_message.Message):
    __slots__ = ("error_code", "error_sub_code", "error_sub_string")
    ERROR_CODE_FIELD_NUMBER: _ClassVar[int]
    ERROR_SUB_CODE_FIELD_NUMBER: _ClassVar[int]
    ERROR_SUB_STRING_FIELD_NUMBER: _ClassVar[int]
    error_code: int
    error_sub_code: int
    error_sub_string: str
    def __init__(self, error_code: _Optional[int] = ..., error_sub_code: _Optional[int] = ..., error_sub_string: _Optional[str] = ...) -> None: ...

class Empty(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class CreateSessionInfo(_message.Message):
    __slots__ = ("username", "session_inactivity_timeout", "password", "connection_inactivity_timeout")
    USERNAME_FIELD_NUMBER: _ClassVar[int]
    SESSION_INACTIVITY_TIMEOUT_FIELD_NUMBER: _ClassVar[int]
    PASSWORD_FIELD_NUMBER: _ClassVar[int]
    CONNECTION_INACTIVITY_TIMEOUT_FIELD_NUMBER: _ClassVar[int]
    username: str
    session_inactivity_timeout: int
    password: str
    connection_inactivity_timeout: int
    def __init__(self, username: _Optional[str] = ..., session_inactivity_timeout: _Optional[int] = ..., password: _Optional[str] = ..., connection_inactivity_timeout: _Optional[int] = ...) -> None: ...

class DeviceHandle(_message.Message):
    __slots__ = ("device_type", "device_identifier", "order")
    DEVICE_TYPE_FIELD_NUMBER: _ClassVar[int]
    DEVICE_IDENTIFIER_FIELD_NUMBER: _ClassVar[int]
    ORDER_FIELD_NUMBER: _ClassVar[int]
    device_type: int
    device_identifier: int
    order: int
    def __init__(self, device_type: _Optional[int] = ..., device_identifier: _Optional[int] = ..., order: _Optional[int] = ...) -> None: ...

class DeviceHandles(_message.Message):
    __slots__ = ("device_handle",)
    DEVICE_HANDLE_FIELD_NUMBER: _ClassVar[int]
    device_handle: _containers.RepeatedCompositeFieldContainer[DeviceHandle]
    def __init__(self, device_handle: _Optional[_Iterable[_Union[DeviceHandle, _Mapping[str, object]]]] = ...) -> None: ...

class ProductConfiguration(_message.Message):
    __slots__ = ("serial", "model", "degrees_of_freedom", "base_type", "end_effector_type", "vision_module_type", "interface_module_type", "arm_laterality", "wrist_type", "brake_type")
    SERIAL_FIELD_NUMBER: _ClassVar[int]
    MODEL_FIELD_NUMBER: _ClassVar[int]
    DEGREES_OF_FREEDOM_FIELD_NUMBER: _ClassVar[int]
    BASE_TYPE_FIELD_NUMBER: _ClassVar[int]
    END_EFFECTOR_TYPE_FIELD_NUMBER: _ClassVar[int]
    VISION_MODULE_TYPE_FIELD_NUMBER: _ClassVar[int]
    INTERFACE_MODULE_TYPE_FIELD_NUMBER: _ClassVar[int]
    ARM_LATERALITY_FIELD_NUMBER: _ClassVar[int]
    WRIST_TYPE_FIELD_NUMBER: _ClassVar[int]
    BRAKE_TYPE_FIELD_NUMBER: _ClassVar[int]
    serial: str
    model: int
    degrees_of_freedom: int
    base_type: int
    end_effector_type: int
    vision_module_type: int
    interface_module_type: int
    arm_laterality: int
    wrist_type: int
    brake_type: int
    def __init__(self, serial: _Optional[str] = ..., model: _Optional[int] = ..., degrees_of_freedom: _Optional[int] = ..., base_type: _Optional[int] = ..., end_effector_type: _Optional[int] = ..., vision_module_type: _Optional[int] = ..., interface_module_type: _Optional[int] = ..., arm_laterality: _Optional[int] = ..., wrist_type: _Optional[int] = ..., brake_type: _Optional[int] = ...) -> None: ...

class FirmwareBundleVersions(_message.Message):
    __slots__ = ("main_bundle_version",)
    MAIN_BUNDLE_VERSION_FIELD_NUMBER: _ClassVar[int]
    main_bundle_version: str
    def __init__(self, main_bundle_version: _Optional[str] = ...) -> None: ...

class ActuatorInformation(_message.Message):
    __slots__ = ("count",)
    COUNT_FIELD_NUMBER: _ClassVar[int]
    count: int
    def __init__(self, count: _Optional[int] = ...) -> None: ...

class NotificationOptions(_message.Message):
    __slots__ = ("type", "rate_ms", "threshold")
    TYPE_FIELD_NUMBER: _ClassVar[int]
    RATE_MS_FIELD_NUMBER: _ClassVar[int]
    THRESHOLD_FIELD_NUMBER: _ClassVar[int]
    type: int
    rate_ms: int
    threshold: float
    def __init__(self, type: _Optional[int] = ..., rate_ms: _Optional[int] = ..., threshold: _Optional[float] = ...) -> None: ...

class NotificationHandle(_message.Message):
    __slots__ = ("identifier",)
    IDENTIFIER_FIELD_NUMBER: _ClassVar[int]
    identifier: int
    def __init__(self, identifier: _Optional[int] = ...) -> None: ...

class ArmStateInformation(_message.Message):
    __slots__ = ("active_state",)
    ACTIVE_STATE_FIELD_NUMBER: _ClassVar[int]
    active_state: int
    def __init__(self, active_state: _Optional[int] = ...) -> None: ...

class ServoingModeInformation(_message.Message):
    __slots__ = ("servoing_mode",)
    SERVOING_MODE_FIELD_NUMBER: _ClassVar[int]
    servoing_mode: int
    def __init__(self, servoing_mode: _Optional[int] = ...) -> None: ...

class ActionHandle(_message.Message):
    __slots__ = ("identifier", "action_type", "permission")
    IDENTIFIER_FIELD_NUMBER: _ClassVar[int]
    ACTION_TYPE_FIELD_NUMBER: _ClassVar[int]
    PERMISSION_FIELD_NUMBER: _ClassVar[int]
    identifier: int
    action_type: int
    permission: int
    def __init__(self, identifier: _Optional[int] = ..., action_type: _Optional[int] = ..., permission: _Optional[int] = ...) -> None: ...

class ActionNotification(_message.Message):
    __slots__ = ("action_event", "handle", "abort_details")
    ACTION_EVENT_FIELD_NUMBER: _ClassVar[int]
    HANDLE_FIELD_NUMBER: _ClassVar[int]
    ABORT_DETAILS_FIELD_NUMBER: _ClassVar[int]
    action_event: int
    handle: ActionHandle
    abort_details: int
    def __init__(self, action_event: _Optional[int] = ..., handle: _Optional[_Union[ActionHandle, _Mapping[str, object]]] = ..., abort_details: _Optional[int] = ...) -> None: ...

class JointAngle(_message.Message):
    __slots__ = ("joint_identifier", "value")
    JOINT_IDENTIFIER_FIELD_NUMBER: _ClassVar[int]
    VALUE_FIELD_NUMBER: _ClassVar[int]
    joint_identifier: int
    value: float
    def __init__(self, joint_identifier: _Optional[int] = ..., value: _Optional[float] = ...) -> None: ...

class JointAngles(_message.Message):
    __slots__ = ("joint_angles",)
    JOINT_ANGLES_FIELD_NUMBER: _ClassVar[int]
    joint_angles: _containers.RepeatedCompositeFieldContainer[JointAngle]
    def __init__(self, joint_angles: _Optional[_Iterable[_Union[JointAngle, _Mapping[str, object]]]] = ...) -> None: ...

class JointTrajectoryConstraint(_message.Message):
    __slots__ = ("type", "value")
    TYPE_FIELD_NUMBER: _ClassVar[int]
    VALUE_FIELD_NUMBER: _ClassVar[int]
    type: int
    value: float
    def __init__(self, type: _Optional[int] = ..., value: _Optional[float] = ...) -> None: ...

class ConstrainedJointAngles(_message.Message):
    __slots__ = ("joint_angles", "constraint")
    JOINT_ANGLES_FIELD_NUMBER: _ClassVar[int]
    CONSTRAINT_FIELD_NUMBER: _ClassVar[int]
    joint_angles: JointAngles
    constraint: JointTrajectoryConstraint
    def __init__(self, joint_angles: _Optional[_Union[JointAngles, _Mapping[str, object]]] = ..., constraint: _Optional[_Union[JointTrajectoryConstraint, _Mapping[str, object]]] = ...) -> None: ...

class AngularWaypoint(_message.Message):
    __slots__ = ("angles", "maximum_velocities", "duration")
    ANGLES_FIELD_NUMBER: _ClassVar[int]
    MAXIMUM_VELOCITIES_FIELD_NUMBER: _ClassVar[int]
    DURATION_FIELD_NUMBER: _ClassVar[int]
    angles: _containers.RepeatedScalarFieldContainer[float]
    maximum_velocities: _containers.RepeatedScalarFieldContainer[float]
    duration: float
    def __init__(self, angles: _Optional[_Iterable[float]] = ..., maximum_velocities: _Optional[_Iterable[float]] = ..., duration: _Optional[float] = ...) -> None: ...

class Waypoint(_message.Message):
    __slots__ = ("name", "angular_waypoint")
    NAME_FIELD_NUMBER: _ClassVar[int]
    ANGULAR_WAYPOINT_FIELD_NUMBER: _ClassVar[int]
    name: str
    angular_waypoint: AngularWaypoint
    def __init__(self, name: _Optional[str] = ..., angular_waypoint: _Optional[_Union[AngularWaypoint, _Mapping[str, object]]] = ...) -> None: ...

class WaypointList(_message.Message):
    __slots__ = ("waypoints", "duration", "use_optimal_blending")
    WAYPOINTS_FIELD_NUMBER: _ClassVar[int]
    DURATION_FIELD_NUMBER: _ClassVar[int]
    USE_OPTIMAL_BLENDING_FIELD_NUMBER: _ClassVar[int]
    waypoints: _containers.RepeatedCompositeFieldContainer[Waypoint]
    duration: float
    use_optimal_blending: bool
    def __init__(self, waypoints: _Optional[_Iterable[_Union[Waypoint, _Mapping[str, object]]]] = ..., duration: _Optional[float] = ..., use_optimal_blending: _Optional[bool] = ...) -> None: ...

class TrajectoryErrorElement(_message.Message):
    __slots__ = ("error_type", "error_value", "min_value", "max_value", "index", "message", "waypoint_index")
    ERROR_TYPE_FIELD_NUMBER: _ClassVar[int]
    ERROR_VALUE_FIELD_NUMBER: _ClassVar[int]
    MIN_VALUE_FIELD_NUMBER: _ClassVar[int]
    MAX_VALUE_FIELD_NUMBER: _ClassVar[int]
    INDEX_FIELD_NUMBER: _ClassVar[int]
    MESSAGE_FIELD_NUMBER: _ClassVar[int]
    WAYPOINT_INDEX_FIELD_NUMBER: _ClassVar[int]
    error_type: int
    error_value: float
    min_value: float
    max_value: float
    index: int
    message: str
    waypoint_index: int
    def __init__(self, error_type: _Optional[int] = ..., error_value: _Optional[float] = ..., min_value: _Optional[float] = ..., max_value: _Optional[float] = ..., index: _Optional[int] = ..., message: _Optional[str] = ..., waypoint_index: _Optional[int] = ...) -> None: ...

class TrajectoryErrorReport(_message.Message):
    __slots__ = ("trajectory_error_elements",)
    TRAJECTORY_ERROR_ELEMENTS_FIELD_NUMBER: _ClassVar[int]
    trajectory_error_elements: _containers.RepeatedCompositeFieldContainer[TrajectoryErrorElement]
    def __init__(self, trajectory_error_elements: _Optional[_Iterable[_Union[TrajectoryErrorElement, _Mapping[str, object]]]] = ...) -> None: ...

class WaypointValidationReport(_message.Message):
    __slots__ = ("trajectory_error_report", "optimal_waypoint_list")
    TRAJECTORY_ERROR_REPORT_FIELD_NUMBER: _ClassVar[int]
    OPTIMAL_WAYPOINT_LIST_FIELD_NUMBER: _ClassVar[int]
    trajectory_error_report: TrajectoryErrorReport
    optimal_waypoint_list: WaypointList
    def __init__(self, trajectory_error_report: _Optional[_Union[TrajectoryErrorReport, _Mapping[str, object]]] = ..., optimal_waypoint_list: _Optional[_Union[WaypointList, _Mapping[str, object]]] = ...) -> None: ...

class Action(_message.Message):
    __slots__ = ("handle", "name", "reach_joint_angles", "execute_waypoint_list")
    HANDLE_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    REACH_JOINT_ANGLES_FIELD_NUMBER: _ClassVar[int]
    EXECUTE_WAYPOINT_LIST_FIELD_NUMBER: _ClassVar[int]
    handle: ActionHandle
    name: str
    reach_joint_angles: ConstrainedJointAngles
    execute_waypoint_list: WaypointList
    def __init__(self, handle: _Optional[_Union[ActionHandle, _Mapping[str, object]]] = ..., name: _Optional[str] = ..., reach_joint_angles: _Optional[_Union[ConstrainedJointAngles, _Mapping[str, object]]] = ..., execute_waypoint_list: _Optional[_Union[WaypointList, _Mapping[str, object]]] = ...) -> None: ...

class RequestedActionType(_message.Message):
    __slots__ = ("action_type",)
    ACTION_TYPE_FIELD_NUMBER: _ClassVar[int]
    action_type: int
    def __init__(self, action_type: _Optional[int] = ...) -> None: ...

class ActionList(_message.Message):
    __slots__ = ("action_list",)
    ACTION_LIST_FIELD_NUMBER: _ClassVar[int]
    action_list: _containers.RepeatedCompositeFieldContainer[Action]
    def __init__(self, action_list: _Optional[_Iterable[_Union[Action, _Mapping[str, object]]]] = ...) -> None: ...

class Finger(_message.Message):
    __slots__ = ("finger_identifier", "value")
    FINGER_IDENTIFIER_FIELD_NUMBER: _ClassVar[int]
    VALUE_FIELD_NUMBER: _ClassVar[int]
    finger_identifier: int
    value: float
    def __init__(self, finger_identifier: _Optional[int] = ..., value: _Optional[float] = ...) -> None: ...

class Gripper(_message.Message):
    __slots__ = ("finger",)
    FINGER_FIELD_NUMBER: _ClassVar[int]
    finger: _containers.RepeatedCompositeFieldContainer[Finger]
    def __init__(self, finger: _Optional[_Iterable[_Union[Finger, _Mapping[str, object]]]] = ...) -> None: ...

class GripperCommand(_message.Message):
    __slots__ = ("mode", "gripper", "duration")
    MODE_FIELD_NUMBER: _ClassVar[int]
    GRIPPER_FIELD_NUMBER: _ClassVar[int]
    DURATION_FIELD_NUMBER: _ClassVar[int]
    mode: int
    gripper: Gripper
    duration: int
    def __init__(self, mode: _Optional[int] = ..., gripper: _Optional[_Union[Gripper, _Mapping[str, object]]] = ..., duration: _Optional[int] = ...) -> None: ...

class GripperRequest(_message.Message):
    __slots__ = ("mode",)
    MODE_FIELD_NUMBER: _ClassVar[int]
    mode: int
    def __init__(self, mode: _Optional[int] = ...) -> None: ...

class Position(_message.Message):
    __slots__ = ("x", "y", "z")
    X_FIELD_NUMBER: _ClassVar[int]
    Y_FIELD_NUMBER: _ClassVar[int]
    Z_FIELD_NUMBER: _ClassVar[int]
    x: float
    y: float
    z: float
    def __init__(self, x: _Optional[float] = ..., y: _Optional[float] = ..., z: _Optional[float] = ...) -> None: ...

class PayloadInformation(_message.Message):
    __slots__ = ("payload_mass", "payload_mass_center")
    PAYLOAD_MASS_FIELD_NUMBER: _ClassVar[int]
    PAYLOAD_MASS_CENTER_FIELD_NUMBER: _ClassVar[int]
    payload_mass: float
    payload_mass_center: Position
    def __init__(self, payload_mass: _Optional[float] = ..., payload_mass_center: _Optional[_Union[Position, _Mapping[str, object]]] = ...) -> None: ...

class CartesianTransform(_message.Message):
    __slots__ = ("x", "y", "z", "theta_x", "theta_y", "theta_z")
    X_FIELD_NUMBER: _ClassVar[int]
    Y_FIELD_NUMBER: _ClassVar[int]
    Z_FIELD_NUMBER: _ClassVar[int]
    THETA_X_FIELD_NUMBER: _ClassVar[int]
    THETA_Y_FIELD_NUMBER: _ClassVar[int]
    THETA_Z_FIELD_NUMBER: _ClassVar[int]
    x: float
    y: float
    z: float
    theta_x: float
    theta_y: float
    theta_z: float
    def __init__(self, x: _Optional[float] = ..., y: _Optional[float] = ..., z: _Optional[float] = ..., theta_x: _Optional[float] = ..., theta_y: _Optional[float] = ..., theta_z: _Optional[float] = ...) -> None: ...

class ToolConfiguration(_message.Message):
    __slots__ = ("tool_transform", "tool_mass", "tool_mass_center")
    TOOL_TRANSFORM_FIELD_NUMBER: _ClassVar[int]
    TOOL_MASS_FIELD_NUMBER: _ClassVar[int]
    TOOL_MASS_CENTER_FIELD_NUMBER: _ClassVar[int]
    tool_transform: CartesianTransform
    tool_mass: float
    tool_mass_center: Position
    def __init__(self, tool_transform: _Optional[_Union[CartesianTransform, _Mapping[str, object]]] = ..., tool_mass: _Optional[float] = ..., tool_mass_center: _Optional[_Union[Position, _Mapping[str, object]]] = ...) -> None: ...

class KinematicLimits(_message.Message):
    __slots__ = ("control_mode", "twist_linear", "twist_angular", "joint_speed_limits", "joint_acceleration_limits")
    CONTROL_MODE_FIELD_NUMBER: _ClassVar[int]
    TWIST_LINEAR_FIELD_NUMBER: _ClassVar[int]
    TWIST_ANGULAR_FIELD_NUMBER: _ClassVar[int]
    JOINT_SPEED_LIMITS_FIELD_NUMBER: _ClassVar[int]
    JOINT_ACCELERATION_LIMITS_FIELD_NUMBER: _ClassVar[int]
    control_mode: int
    twist_linear: float
    twist_angular: float
    joint_speed_limits: _containers.RepeatedScalarFieldContainer[float]
    joint_acceleration_limits: _containers.RepeatedScalarFieldContainer[float]
    def __init__(self, control_mode: _Optional[int] = ..., twist_linear: _Optional[float] = ..., twist_angular: _Optional[float] = ..., joint_speed_limits: _Optional[_Iterable[float]] = ..., joint_acceleration_limits: _Optional[_Iterable[float]] = ...) -> None: ...

class TorqueOffset(_message.Message):
    __slots__ = ("torque_offset",)
    TORQUE_OFFSET_FIELD_NUMBER: _ClassVar[int]
    torque_offset: float
    def __init__(self, torque_offset: _Optional[float] = ...) -> None: ...

class ActuatorFeedback(_message.Message):
    __slots__ = ("command_id", "status_flags", "jitter_comm", "position", "velocity", "torque", "current_motor", "voltage", "temperature_motor", "temperature_core", "fault_bank_a", "fault_bank_b", "warning_bank_a", "warning_bank_b")
    COMMAND_ID_FIELD_NUMBER: _ClassVar[int]
    STATUS_FLAGS_FIELD_NUMBER: _ClassVar[int]
    JITTER_COMM_FIELD_NUMBER: _ClassVar[int]
    POSITION_FIELD_NUMBER: _ClassVar[int]
    VELOCITY_FIELD_NUMBER: _ClassVar[int]
    TORQUE_FIELD_NUMBER: _ClassVar[int]
    CURRENT_MOTOR_FIELD_NUMBER: _ClassVar[int]
    VOLTAGE_FIELD_NUMBER: _ClassVar[int]
    TEMPERATURE_MOTOR_FIELD_NUMBER: _ClassVar[int]
    TEMPERATURE_CORE_FIELD_NUMBER: _ClassVar[int]
    FAULT_BANK_A_FIELD_NUMBER: _ClassVar[int]
    FAULT_BANK_B_FIELD_NUMBER: _ClassVar[int]
    WARNING_BANK_A_FIELD_NUMBER: _ClassVar[int]
    WARNING_BANK_B_FIELD_NUMBER: _ClassVar[int]
    command_id: int
    status_flags: int
    jitter_comm: int
    position: float
    velocity: float
    torque: float
    current_motor: float
    voltage: float
    temperature_motor: float
    temperature_core: float
    fault_bank_a: int
    fault_bank_b: int
    warning_bank_a: int
    warning_bank_b: int
    def __init__(self, command_id: _Optional[int] = ..., status_flags: _Optional[int] = ..., jitter_comm: _Optional[int] = ..., position: _Optional[float] = ..., velocity: _Optional[float] = ..., torque: _Optional[float] = ..., current_motor: _Optional[float] = ..., voltage: _Optional[float] = ..., temperature_motor: _Optional[float] = ..., temperature_core: _Optional[float] = ..., fault_bank_a: _Optional[int] = ..., fault_bank_b: _Optional[int] = ..., warning_bank_a: _Optional[int] = ..., warning_bank_b: _Optional[int] = ...) -> None: ...

class BaseFeedback(_message.Message):
    __slots__ = ("active_state_connection_identifier", "active_state", "arm_voltage", "arm_current", "temperature_cpu", "temperature_ambient", "imu_acceleration_x", "imu_acceleration_y", "imu_acceleration_z", "tool_pose_x", "tool_pose_y", "tool_pose_z", "tool_pose_theta_x", "tool_pose_theta_y", "tool_pose_theta_z", "fault_bank_a", "fault_bank_b", "warning_bank_a", "warning_bank_b")
    ACTIVE_STATE_CONNECTION_IDENTIFIER_FIELD_NUMBER: _ClassVar[int]
    ACTIVE_STATE_FIELD_NUMBER: _ClassVar[int]
    ARM_VOLTAGE_FIELD_NUMBER: _ClassVar[int]
    ARM_CURRENT_FIELD_NUMBER: _ClassVar[int]
    TEMPERATURE_CPU_FIELD_NUMBER: _ClassVar[int]
    TEMPERATURE_AMBIENT_FIELD_NUMBER: _ClassVar[int]
    IMU_ACCELERATION_X_FIELD_NUMBER: _ClassVar[int]
    IMU_ACCELERATION_Y_FIELD_NUMBER: _ClassVar[int]
    IMU_ACCELERATION_Z_FIELD_NUMBER: _ClassVar[int]
    TOOL_POSE_X_FIELD_NUMBER: _ClassVar[int]
    TOOL_POSE_Y_FIELD_NUMBER: _ClassVar[int]
    TOOL_POSE_Z_FIELD_NUMBER: _ClassVar[int]
    TOOL_POSE_THETA_X_FIELD_NUMBER: _ClassVar[int]
    TOOL_POSE_THETA_Y_FIELD_NUMBER: _ClassVar[int]
    TOOL_POSE_THETA_Z_FIELD_NUMBER: _ClassVar[int]
    FAULT_BANK_A_FIELD_NUMBER: _ClassVar[int]
    FAULT_BANK_B_FIELD_NUMBER: _ClassVar[int]
    WARNING_BANK_A_FIELD_NUMBER: _ClassVar[int]
    WARNING_BANK_B_FIELD_NUMBER: _ClassVar[int]
    active_state_connection_identifier: int
    active_state: int
    arm_voltage: float
    arm_current: float
    temperature_cpu: float
    temperature_ambient: float
    imu_acceleration_x: float
    imu_acceleration_y: float
    imu_acceleration_z: float
    tool_pose_x: float
    tool_pose_y: float
    tool_pose_z: float
    tool_pose_theta_x: float
    tool_pose_theta_y: float
    tool_pose_theta_z: float
    fault_bank_a: int
    fault_bank_b: int
    warning_bank_a: int
    warning_bank_b: int
    def __init__(self, active_state_connection_identifier: _Optional[int] = ..., active_state: _Optional[int] = ..., arm_voltage: _Optional[float] = ..., arm_current: _Optional[float] = ..., temperature_cpu: _Optional[float] = ..., temperature_ambient: _Optional[float] = ..., imu_acceleration_x: _Optional[float] = ..., imu_acceleration_y: _Optional[float] = ..., imu_acceleration_z: _Optional[float] = ..., tool_pose_x: _Optional[float] = ..., tool_pose_y: _Optional[float] = ..., tool_pose_z: _Optional[float] = ..., tool_pose_theta_x: _Optional[float] = ..., tool_pose_theta_y: _Optional[float] = ..., tool_pose_theta_z: _Optional[float] = ..., fault_bank_a: _Optional[int] = ..., fault_bank_b: _Optional[int] = ..., warning_bank_a: _Optional[int] = ..., warning_bank_b: _Optional[int] = ...) -> None: ...

class MotorFeedback(_message.Message):
    __slots__ = ("motor_id", "position", "velocity", "current_motor", "voltage", "temperature_motor")
    MOTOR_ID_FIELD_NUMBER: _ClassVar[int]
    POSITION_FIELD_NUMBER: _ClassVar[int]
    VELOCITY_FIELD_NUMBER: _ClassVar[int]
    CURRENT_MOTOR_FIELD_NUMBER: _ClassVar[int]
    VOLTAGE_FIELD_NUMBER: _ClassVar[int]
    TEMPERATURE_MOTOR_FIELD_NUMBER: _ClassVar[int]
    motor_id: int
    position: float
    velocity: float
    current_motor: float
    voltage: float
    temperature_motor: float
    def __init__(self, motor_id: _Optional[int] = ..., position: _Optional[float] = ..., velocity: _Optional[float] = ..., current_motor: _Optional[float] = ..., voltage: _Optional[float] = ..., temperature_motor: _Optional[float] = ...) -> None: ...

class GripperFeedback(_message.Message):
    __slots__ = ("status_flags", "fault_bank_a", "fault_bank_b", "warning_bank_a", "warning_bank_b", "motor")
    STATUS_FLAGS_FIELD_NUMBER: _ClassVar[int]
    FAULT_BANK_A_FIELD_NUMBER: _ClassVar[int]
    FAULT_BANK_B_FIELD_NUMBER: _ClassVar[int]
    WARNING_BANK_A_FIELD_NUMBER: _ClassVar[int]
    WARNING_BANK_B_FIELD_NUMBER: _ClassVar[int]
    MOTOR_FIELD_NUMBER: _ClassVar[int]
    status_flags: int
    fault_bank_a: int
    fault_bank_b: int
    warning_bank_a: int
    warning_bank_b: int
    motor: _containers.RepeatedCompositeFieldContainer[MotorFeedback]
    def __init__(self, status_flags: _Optional[int] = ..., fault_bank_a: _Optional[int] = ..., fault_bank_b: _Optional[int] = ..., warning_bank_a: _Optional[int] = ..., warning_bank_b: _Optional[int] = ..., motor: _Optional[_Iterable[_Union[MotorFeedback, _Mapping[str, object]]]] = ...) -> None: ...

class InterconnectFeedback(_message.Message):
    __slots__ = ("status_flags", "jitter_comm", "imu_acceleration_x", "imu_acceleration_y", "imu_acceleration_z", "voltage", "temperature_core", "fault_bank_a", "fault_bank_b", "warning_bank_a", "warning_bank_b", "gripper_feedback")
    STATUS_FLAGS_FIELD_NUMBER: _ClassVar[int]
    JITTER_COMM_FIELD_NUMBER: _ClassVar[int]
    IMU_ACCELERATION_X_FIELD_NUMBER: _ClassVar[int]
    IMU_ACCELERATION_Y_FIELD_NUMBER: _ClassVar[int]
    IMU_ACCELERATION_Z_FIELD_NUMBER: _ClassVar[int]
    VOLTAGE_FIELD_NUMBER: _ClassVar[int]
    TEMPERATURE_CORE_FIELD_NUMBER: _ClassVar[int]
    FAULT_BANK_A_FIELD_NUMBER: _ClassVar[int]
    FAULT_BANK_B_FIELD_NUMBER: _ClassVar[int]
    WARNING_BANK_A_FIELD_NUMBER: _ClassVar[int]
    WARNING_BANK_B_FIELD_NUMBER: _ClassVar[int]
    GRIPPER_FEEDBACK_FIELD_NUMBER: _ClassVar[int]
    status_flags: int
    jitter_comm: int
    imu_acceleration_x: float
    imu_acceleration_y: float
    imu_acceleration_z: float
    voltage: float
    temperature_core: float
    fault_bank_a: int
    fault_bank_b: int
    warning_bank_a: int
    warning_bank_b: int
    gripper_feedback: GripperFeedback
    def __init__(self, status_flags: _Optional[int] = ..., jitter_comm: _Optional[int] = ..., imu_acceleration_x: _Optional[float] = ..., imu_acceleration_y: _Optional[float] = ..., imu_acceleration_z: _Optional[float] = ..., voltage: _Optional[float] = ..., temperature_core: _Optional[float] = ..., fault_bank_a: _Optional[int] = ..., fault_bank_b: _Optional[int] = ..., warning_bank_a: _Optional[int] = ..., warning_bank_b: _Optional[int] = ..., gripper_feedback: _Optional[_Union[GripperFeedback, _Mapping[str, object]]] = ...) -> None: ...

class Feedback(_message.Message):
    __slots__ = ("frame_id", "base", "actuators", "interconnect")
    FRAME_ID_FIELD_NUMBER: _ClassVar[int]
    BASE_FIELD_NUMBER: _ClassVar[int]
    ACTUATORS_FIELD_NUMBER: _ClassVar[int]
    INTERCONNECT_FIELD_NUMBER: _ClassVar[int]
    frame_id: int
    base: BaseFeedback
    actuators: _containers.RepeatedCompositeFieldContainer[ActuatorFeedback]
    interconnect: InterconnectFeedback
    def __init__(self, frame_id: _Optional[int] = ..., base: _Optional[_Union[BaseFeedback, _Mapping[str, object]]] = ..., actuators: _Optional[_Iterable[_Union[ActuatorFeedback, _Mapping[str, object]]]] = ..., interconnect: _Optional[_Union[InterconnectFeedback, _Mapping[str, object]]] = ...) -> None: ...
