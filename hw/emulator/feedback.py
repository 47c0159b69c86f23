"""The feedback of the emulated arm, in the arm's own units."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dynamics.arm import Arm
from dynamics.gripper import ParallelGripper
from hw.emulator.backend import State
from hw.kortex import messages_pb2 as pb
from hw.kortex import units

STANDARD_GRAVITY = 9.81  # m/s^2, as the arm's description has it


@dataclass(frozen=True)
class Health:
    """What is wrong with the arm.

    Attributes:
        state: number of ArmState.
        base: fault bits of the base.
        joints: fault bits of the joints.
        torque_offset: what each torque sensor was told to subtract, with the arm's sign [N m].
    """

    state: int
    base: int
    joints: tuple[int, ...]
    torque_offset: NDArray[np.float64]


def feedback(number: int, state: State, arm: Arm, gripper: ParallelGripper, health: Health) -> pb.Feedback:
    """Return the feedback of a state, with its frame's number."""
    sample = state.sample
    pose = arm.tool_pose(sample.q)
    angles = units.angles_to_arm(sample.q)
    speeds = units.velocities_to_arm(sample.dq)
    torques = units.torques_to_arm(sample.tau) - health.torque_offset
    joints = [
        pb.ActuatorFeedback(
            command_id=number & 0xFFFF,
            position=angles[joint],
            velocity=speeds[joint],
            torque=torques[joint],
            voltage=24.0,
            temperature_motor=35.0,
            temperature_core=38.0,
            fault_bank_a=health.joints[joint],
        )
        for joint in range(arm.nv)
    ]
    up = pose[:3, :3].T @ [0.0, 0.0, STANDARD_GRAVITY]
    base = pb.BaseFeedback(
        active_state=health.state,
        arm_voltage=24.0,
        arm_current=1.0,
        imu_acceleration_z=STANDARD_GRAVITY,
        tool_pose_x=pose[0, 3],
        tool_pose_y=pose[1, 3],
        tool_pose_z=pose[2, 3],
        fault_bank_a=health.base,
    )
    motor = pb.MotorFeedback(
        motor_id=1,
        position=units.percent_from_opening(gripper, sample.opening),
        velocity=100 * state.gripper_speed / gripper.max_speed,
        current_motor=sample.effort,
        voltage=24.0,
        temperature_motor=30.0,
    )
    wrist = pb.InterconnectFeedback(
        imu_acceleration_x=up[0],
        imu_acceleration_y=up[1],
        imu_acceleration_z=up[2],
        voltage=24.0,
        gripper_feedback=pb.GripperFeedback(motor=[motor]),
    )
    return pb.Feedback(frame_id=number & 0xFFFF, base=base, actuators=joints, interconnect=wrist)
