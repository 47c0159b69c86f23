"""Sound: lift the object a little, set it down, and have a classifier say what the knock sounds like."""

from __future__ import annotations

from estimation.network import Network
from estimation.sensor import ClassSensor
from selection.actions.action import Findings, Readings
from selection.actions.hand import LINE_SPEED, Hand
from selection.eyes import Classifier
from selection.planner import ActionModel

HEIGHT = 0.02  # m from which the object is set down
RING = 0.3  # s of listening after it touched the table


class Sound:
    """Knock the object on the table and learn of its class.

    Args:
        ears: says what it hears.
    """

    name = "sound"
    seconds, setup_seconds = 5.0, 8.0  # s, of the knock and of the grasp; replaced by what it took

    def __init__(self, ears: Classifier) -> None:
        self._ears = ears

    def model(self, network: Network) -> ActionModel | None:
        """Return what the sound informs: the class that the reference's classifier ``sound`` tells apart, once."""
        sensor = dict(network.sensors).get(self.name)
        if not isinstance(sensor, ClassSensor):
            return None
        return ActionModel(self.name, (sensor,), self.seconds, "grasp", self.setup_seconds, repeat_cap=1)

    def perform(self, hand: Hand) -> None:
        """Lift and set down; leaves phases ``air``, ``grasp`` and ``knock``, the last from above the table on.

        Raises:
            ActionFailed: if the object was missed or dropped.
        """
        hand.gate()
        hand.grasp(self.name)
        hand.lift(HEIGHT)
        hand.check_still_held(self.name)
        with hand.tape.phase(self.name, "knock"):
            hand.line(hand.grasp_pose, LINE_SPEED)
            hand.robot.hold(RING)
        hand.put_back(self.name)

    def measure(self, readings: Readings) -> Findings:
        """Have the classifier say what it heard."""
        heard = self._ears.perceive()
        return Findings((), (f"sounds most like {heard.variable} {heard.best}",), (heard,))
