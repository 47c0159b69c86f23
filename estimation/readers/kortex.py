"""What Kortex drivers publish: joint states with the raw sign, and a base feedback in degrees and percent.

Torques: the arm reports the reaction, at rest -g(q); both drivers publish it as it is. Gripper: the driver of ROS
1 gives 0 to 0.8 rad for its finger joint, the one of ROS 2 0 to 0.81 rad for the left knuckle; only the base
feedback holds a motor current. Sources: messages and drivers of ros_kortex and ros2_kortex.
"""

from __future__ import annotations

import math
from typing import Any

GRIPPER_JOINTS = {"finger_joint": 0.8, "robotiq_85_left_knuckle_joint": 0.81}
"""Names of the gripper's joint, and its position when closed [rad]."""

BASE_FEEDBACK = "kortex_driver/msg/BaseCyclic_Feedback"


def is_kortex(names: tuple[str, ...]) -> bool:
    """Tell whether joints are named as the Kortex drivers do."""
    return len(names) in (6, 7) and all(name.endswith(f"joint_{n}") for n, name in enumerate(names, 1))


def base_feedback_row(message: Any, max_opening: float) -> list[float]:
    """Return q, dq, tau of every actuator [rad, rad/s, N m], then opening [m] and motor current [A]."""
    actuators = message.actuators
    q = [math.remainder(math.radians(a.position), math.tau) for a in actuators]
    dq = [math.radians(a.velocity) for a in actuators]
    tau = [float(a.torque) for a in actuators]
    opening = current = math.nan
    feedback = message.interconnect.oneof_tool_feedback.gripper_feedback
    if len(feedback) and len(feedback[0].motor):
        motor = feedback[0].motor[0]
        opening = max_opening * (1 - motor.position / 100)
        current = float(motor.current_motor)
    return [*q, *dq, *tau, opening, current]
