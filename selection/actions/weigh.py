"""Weigh: hold the object still in several poses, and the empty gripper in the same ones before and after."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from dynamics.errors import ActionFailed, InvalidInput
from dynamics.kinematics import tool_down
from estimation.network import Network
from estimation.sensor import Sensor
from selection.actions.action import Findings, Readings
from selection.actions.hand import Hand
from selection.information import AnySensor
from selection.planner import ActionModel

Array = NDArray[np.float64]

HOLD = 1.5  # s of reading in each pose
COUNT, LEAST = 4, 3  # poses to weigh in, at most and at least
# Tool positions [m], yaw from the grasp's and lean [rad], in order of preference: found by a search over
# poses for the smallest standard deviation of the mass per travel, white torque noise assumed.
POSES = (
    ((0.50, -0.20, 0.40), -0.8, -0.3),
    ((0.55, 0.00, 0.30), 0.0, 0.3),
    ((0.45, 0.00, 0.40), 0.0, 0.3),
    ((0.60, 0.00, 0.30), 0.0, 0.0),
    ((0.55, 0.20, 0.30), 0.8, 0.0),
    ((0.60, 0.10, 0.36), 0.0, 0.0),
    ((0.50, -0.28, 0.34), 0.6, -0.35),
    ((0.45, 0.20, 0.30), 0.0, 0.0),
)


class Weigh:
    """Lift the object and read its mass off the joint torques."""

    name = "weigh"
    seconds, setup_seconds = 62.0, 8.0  # s, of the poses and of the grasp; replaced by what it took
    enough, enough_share = 0.001, 0.004  # kg, and share of the mass: an sd at which no further pose is visited
    sensor = Sensor("mass", 0.003, 0.01)  # where the reference has none: default noise of the simulator

    def model(self, network: Network) -> ActionModel | None:
        """Return what weighing informs: the mass, or the density of an object whose volume is declared."""
        known = dict(network.sensors)
        if "mass" in network.quantities:
            return self._model(known.get("weigh", self.sensor))
        if "density" in network.quantities and "weigh" in known:
            return self._model(known["weigh"])
        return None

    def perform(self, hand: Hand) -> None:
        """Weigh the object and put it back; leaves phases ``tare`` and ``hold``, one each a pose.

        The empty poses come before and after the laden ones, so that the drift of the torque sensors in between
        is seen, and are approached along the same paths, so that their offsets and direction-dependent hysteresis
        are the same in both and cancel. The tour ends early once the mass is known well enough.

        Raises:
            ActionFailed: if the object was missed or dropped, or fewer than two of the poses can be reached.
        """
        hand.gate()
        positions = hand.plan_through(_poses(hand), COUNT)
        if len(positions) < 2:
            raise ActionFailed("unreachable", "fewer than two poses to weigh in can be reached from here")
        hand.preshape()
        for q in positions:
            _stand(hand, q, "tare")
        hand.gate()
        hand.grasp(self.name)
        hand.tighten(self.name)
        hand.lift()
        hand.check_still_held(self.name)
        visited = []
        for q in positions:
            _stand(hand, q, "hold")
            visited.append(q)
            if len(visited) >= LEAST and self._is_known(hand):
                break
        hand.gate()
        hand.check_still_held(self.name)
        hand.put_back(self.name)
        hand.preshape()
        for q in visited:
            _stand(hand, q, "tare")
        hand.gate()

    def measure(self, readings: Readings) -> Findings:
        """Measure the mass."""
        from estimation.weighing import measure_weighing

        estimate, measurements = measure_weighing(readings.robot.arm, readings.phases)
        return Findings(measurements, () if measurements else (estimate.verdict,))

    def _is_known(self, hand: Hand) -> bool:
        """Tell whether the readings so far give the mass well enough."""
        from estimation.weighing import measure_weighing

        try:
            estimate, _ = measure_weighing(hand.robot.arm, hand.tape.phases)
        except InvalidInput:  # too few yet
            return False
        return estimate.mass_sd <= max(self.enough, self.enough_share * abs(estimate.mass))

    def _model(self, sensor: AnySensor) -> ActionModel:
        return ActionModel(self.name, (sensor,), self.seconds, "grasp", self.setup_seconds, repeat_cap=2)


def _stand(hand: Hand, q: Array, phase: str) -> None:
    """Go to a pose and read there."""
    hand.go(q)
    hand.settle()
    with hand.tape.phase("weigh", phase):
        hand.robot.hold(HOLD)


def _poses(hand: Hand) -> list[Array]:
    """Return the tool poses, turned as the hand is over the object."""
    grasp = hand.grasp_pose
    yaw = float(np.arctan2(-grasp[0, 1], grasp[1, 1]))
    return [tool_down(position, yaw + turn, lean) for position, turn, lean in POSES]
