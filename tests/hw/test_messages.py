"""The generated messages are those of messages.proto, and their numbers are the protocol's."""

import importlib.util

import pytest

from hw.kortex import messages_pb2 as pb
from hw.kortex.generate import FOLDER, generate
from hw.kortex.methods import METHODS


@pytest.mark.skipif(importlib.util.find_spec("grpc_tools") is None, reason="needs grpcio-tools")
def test_generated_module_is_current():
    for name, text in generate().items():
        assert (FOLDER / name).read_text() == text, "run python -m hw.kortex.generate"


# name of a field path and its number, from the published lists
NUMBERS = {
    ("Feedback", "frame_id"): 1,
    ("Feedback", "base"): 2,
    ("Feedback", "actuators"): 3,
    ("Feedback", "interconnect"): 4,
    ("ActuatorFeedback", "position"): 4,
    ("ActuatorFeedback", "velocity"): 5,
    ("ActuatorFeedback", "torque"): 6,
    ("ActuatorFeedback", "fault_bank_a"): 11,
    ("ActuatorFeedback", "warning_bank_b"): 14,
    ("BaseFeedback", "active_state"): 2,
    ("BaseFeedback", "fault_bank_a"): 31,
    ("BaseFeedback", "tool_pose_x"): 13,
    ("InterconnectFeedback", "gripper_feedback"): 18,
    ("InterconnectFeedback", "fault_bank_a"): 12,
    ("GripperFeedback", "motor"): 7,
    ("MotorFeedback", "position"): 4,
    ("MotorFeedback", "current_motor"): 7,
    ("CreateSessionInfo", "password"): 3,
    ("CreateSessionInfo", "session_inactivity_timeout"): 2,
    ("AngularWaypoint", "duration"): 3,
    ("Waypoint", "angular_waypoint"): 2,
    ("WaypointList", "use_optimal_blending"): 3,
    ("Action", "reach_joint_angles"): 10,
    ("ActionNotification", "abort_details"): 5,
    ("GripperCommand", "mode"): 1,
    ("ProductConfiguration", "degrees_of_freedom"): 6,
    ("ProductConfiguration", "brake_type"): 13,
    ("ToolConfiguration", "tool_mass"): 2,
    ("KinematicLimits", "joint_speed_limits"): 4,
    ("TrajectoryErrorElement", "message"): 7,
}


@pytest.mark.parametrize(("message", "field"), NUMBERS)
def test_field_numbers(message, field):
    assert pb.DESCRIPTOR.message_types_by_name[message].fields_by_name[field].number == NUMBERS[message, field]


def test_fixed_words_of_the_header():
    kinds = {field.type for field in pb.Header.DESCRIPTOR.fields}
    assert kinds == {pb.Header.DESCRIPTOR.fields[0].TYPE_FIXED32}


METHOD_NUMBERS = {
    "Session.CreateSession": 65537,
    "Base.ActionTopic": 131178,
    "Base.ReadAllActions": 131116,
    "Base.ExecuteWaypointTrajectory": 131298,
    "Base.ValidateWaypointList": 131307,
    "Base.SendGripperCommand": 131208,
    "Base.Stop": 131184,
    "Base.GetProductConfiguration": 131270,
    "BaseCyclic.RefreshFeedback": 196611,
    "ActuatorConfig.SetTorqueOffset": 655365,
    "ControlConfig.GetToolConfiguration": 1048582,
    "ControlConfig.GetPayloadInformation": 1048580,
    "DeviceManager.ReadAllDevices": 1507329,
}


def test_method_numbers():
    by_name = {method.name: number for number, method in METHODS.items()}
    assert {name: by_name[name] for name in METHOD_NUMBERS} == METHOD_NUMBERS
