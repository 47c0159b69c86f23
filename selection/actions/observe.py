"""Observe: look at the object from above with the camera on the wrist, and have a classifier say what it is."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from dynamics.kinematics import tool_down
from estimation.network import Network
from estimation.sensor import ClassSensor
from models.robot import COLOUR_CAMERA, TOOL_LENGTH
from selection.actions.action import Findings, Readings
from selection.actions.hand import Hand
from selection.eyes import Classifier
from selection.planner import ActionModel

Array = NDArray[np.float64]

CAMERA = np.array(COLOUR_CAMERA) - [0.0, 0.0, TOOL_LENGTH]  # in the tool frame [m]
ASIDE = 0.06  # m of the object from the line of sight, away from the finger that stands in its middle
DISTANCES = (0.30, 0.25, 0.35)  # m of the camera from the object's top, in order of preference
TURNS = (0.0, np.pi, np.pi / 2, -np.pi / 2)  # rad of the tool from where it grasps
LOOK = 0.5  # s of holding still


class Observe:
    """Look at the object and learn of its class.

    Args:
        eyes: says what it sees.
    """

    name = "observe"
    seconds = 8.0  # s, there and standing still; replaced by what it took

    def __init__(self, eyes: Classifier) -> None:
        self._eyes = eyes

    def model(self, network: Network) -> ActionModel | None:
        """Return what looking informs: the class that the reference's classifier ``observe`` tells apart.

        A classifier errs alike at every look at one object, so a second look tells nothing: one only.
        """
        sensor = dict(network.sensors).get(self.name)
        if not isinstance(sensor, ClassSensor):
            return None
        return ActionModel(self.name, (sensor,), self.seconds, repeat_cap=1)

    def perform(self, hand: Hand) -> None:
        """Go where the camera sees the object and stand still there; leaves a phase ``look``.

        Where no such pose can be reached, the look is from the gate, straight above the object.
        """
        hand.gate()
        for q in hand.plan_through(viewing_poses(hand), 1):
            hand.go(q)
        hand.settle()
        with hand.tape.phase(self.name, "look"):
            hand.robot.hold(LOOK)

    def measure(self, readings: Readings) -> Findings:
        """Have the classifier say what it sees from here."""
        seen = self._eyes.perceive()
        return Findings((), (f"looks most like {seen.variable} {seen.best}",), (seen,))


def viewing_poses(hand: Hand) -> list[Array]:
    """Return tool poses from which the camera looks down on the object past the finger, the preferred first."""
    grasp = hand.grasp_pose
    yaw = float(np.arctan2(-grasp[0, 1], grasp[1, 1]))
    top = np.array([*hand.declared.position, hand.declared.size[2]])
    poses = []
    for distance in DISTANCES:
        for turn in TURNS:
            rotation = tool_down(np.zeros(3), yaw + turn)[:3, :3]
            eye = top + np.array([0.0, 0.0, distance]) - ASIDE * rotation[:, 1]
            poses.append(tool_down(eye - rotation @ CAMERA, yaw + turn))
    return poses
