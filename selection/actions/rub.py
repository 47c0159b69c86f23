"""Rub: pinch the object where it stands, and drive the pads down along its sides, a few times."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from dynamics.errors import ActionFailed
from dynamics.robot import GripResult
from dynamics.signals import Sample
from estimation.network import Network
from estimation.sensor import Sensor
from selection.actions.action import Findings, Readings
from selection.actions.hand import MAX_EFFORT, Hand
from selection.planner import ActionModel

Array = NDArray[np.float64]

SLIDES = 5
LEAST_STROKE = 0.004  # m that the pads must be able to go down
RIM = 0.0005  # m between the pads' upper edge and the object's at the start
APPROACH = 0.03  # m above the start from which it is approached, always downward: the joints' friction is the same
SLIDE_SPEED = 0.05  # share of the arm's limits
REST = 0.2  # s after a slide
TOUCH_EFFORT = 0.05  # A at which the pads have met the object
FIRST_FORCE, LEAST_FORCE, MOST_FORCE = 8.0, 6.5, 15.0  # N of a pad; less is hard to tell from a locked gripper
FIRM = 2.5  # N of a pad, to go on with
WANTED_PULL = 12.0  # N on both pads together
GRIP_TRAVEL = 0.0025  # m that a pad's force may compress the object by, beyond the least force
PRESS_SHARE = 0.2  # of the wanted force, by which a press to bring it about raises it at least
SHORTEST_PRESS, LONGEST_PRESS = 1e-4, 0.003  # m, to bring the force about
LAST_PRESS = 0.001  # m of the press after a slide: half a dozen readings while the gripper speeds up
RAISE = 15.0  # N by which the press after a slide may raise the force
GIVE = 2e-4  # m that a loaded gripper may stand open beyond its command: to less, it would open
STEPS = 3  # of the opening's reading that a press is at least, for a gripper obeys no finer ones
PRESSES = 6  # at most, to bring the force about
ENOUGH = 0.8  # of the wanted force, that is left as it is
BRACED = 0.5  # N that a slide must be felt by at least
_UPRIGHT = ("box",)  # shapes with sides that go straight up


class Rub:
    """Slide the pads down the object's sides and read the coefficient of friction off torques and motor current.

    The object stands on the table all the time, which takes the force: it is not carried, cannot tip, for both
    sides are rubbed alike, and its weight does not matter. The pull of a slide is of the order of 10 N, for what
    is left of the joint torques' offsets and hysteresis after the same motion in the air is 0.1 to 0.2 N.
    """

    name = "rub"
    seconds, setup_seconds = 26.0, 8.0  # s, of the slides and of the way there; replaced by what it took
    sensor = Sensor("friction", 0.01, 0.1)  # where the reference has none: default noise of the simulator

    def model(self, network: Network) -> ActionModel | None:
        """Return what rubbing informs: the friction; once, for the force's calibration is common to all rubs."""
        if "friction" not in network.quantities:
            return None
        sensor = dict(network.sensors).get("rub", self.sensor)
        return ActionModel(self.name, (sensor,), self.seconds, "grasp", self.setup_seconds, repeat_cap=1)

    def check(self, hand: Hand) -> None:
        """Refuse an object whose sides are not upright or leave no way to slide."""
        _stroke(hand)

    def perform(self, hand: Hand) -> None:
        """Rub the object; leaves phases ``idle``, ``air``, and ``touch``, ``slide``, ``press`` for every slide.

        A ``press`` or more between ``touch`` and ``slide`` bring the force about where the touch has not.

        Raises:
            ActionFailed: ``unsuitable`` for an object whose sides are not upright or leave no way to slide,
                ``missed`` if nothing is felt between the pads, ``too soft`` if they cannot press on the object,
                ``pushed`` if it goes along with them.
        """
        top, bottom = _stroke(hand)
        above = top.copy()
        above[2, 3] += APPROACH
        hand.gate()
        hand.open_fully()
        hand.line(above)
        hand.line(top)
        hand.settle()
        with hand.tape.phase(self.name, "idle") as idle:
            _open_around(hand)
        air = float(np.median([sample.effort for sample in idle]))
        with hand.tape.phase(self.name, "air") as free:
            hand.line(bottom, SLIDE_SPEED)
            hand.robot.hold(REST)
        target, ratios = FIRST_FORCE, []
        for _ in range(SLIDES):
            hand.line(above)
            hand.line(top)
            hand.settle()
            force = self._pinch(hand, air, target)
            with hand.tape.phase(self.name, "slide") as slide:
                hand.line(bottom, SLIDE_SPEED)
                hand.robot.hold(REST)
            pull = _pull(hand, free, slide)
            with hand.tape.phase(self.name, "press"):
                _close_by(hand, LAST_PRESS, force + hand.robot.gripper.swing(hand.width) * pull / 2 + RAISE, air)
            if pull < BRACED:
                raise ActionFailed(
                    "pushed", "the object went along with the pads instead of standing on the table"
                )
            ratios.append(pull / (2 * max(force, 1.0)))
            _open_around(hand)
            target = float(np.clip(WANTED_PULL / (2 * np.median(ratios)), LEAST_FORCE, MOST_FORCE))
        hand.retreat()

    def measure(self, readings: Readings) -> Findings:
        """Measure the friction."""
        from estimation.rubbing import measure_rub

        _, measurement = measure_rub(readings.robot.arm, readings.phases, gripper=readings.robot.gripper)
        return Findings((measurement,))

    def _pinch(self, hand: Hand, air: float, target: float) -> float:
        """Close until the pads press as wanted, as far as the object is stiff; return the force of a pad [N]."""
        gripper = hand.robot.gripper
        with hand.tape.phase(self.name, "touch") as touch:
            result = hand.robot.grip(0.65 * hand.width, gripper.min_speed, TOUCH_EFFORT + air)
        force = _force(hand, touch, air)
        if result is GripResult.REACHED and force < FIRM:
            raise ActionFailed("missed", "the gripper closed without feeling the object")
        compressed = max(hand.width - hand.robot.read().opening, gripper.opening_quantum, 1e-4)
        stiffness = force / compressed
        target = min(target, max(GRIP_TRAVEL * stiffness, LEAST_FORCE))
        for _ in range(PRESSES):
            if force >= ENOUGH * target:
                break
            rise = max(target - force, PRESS_SHARE * target)
            travel = min(max(rise / stiffness, SHORTEST_PRESS), LONGEST_PRESS)
            with hand.tape.phase(self.name, "press") as press:
                _close_by(hand, travel, target, air)
            force = max(_force(hand, press, air), force)
        if force < FIRM:
            raise ActionFailed("too soft", f"the pads press with {force:.1f} N; {LEAST_FORCE:g} N are wanted")
        return force


def _stroke(hand: Hand) -> tuple[Array, Array]:
    """Return where the pads begin to slide, just below the object's top, and where they end, as tool poses.

    Raises:
        ActionFailed: if the object's sides are not upright or the pads have no way to slide.
    """
    if hand.declared.shape not in _UPRIGHT:
        raise ActionFailed("unsuitable", f"the sides of a {hand.declared.shape} are not upright")
    bottom = hand.grasp_pose
    top = bottom.copy()
    way = hand.declared.size[2] - hand.robot.gripper.pad_length / 2 - RIM - hand.pad_height_at_grasp
    if way < LEAST_STROKE:
        raise ActionFailed("unsuitable", f"the pads can slide {1e3 * max(way, 0.0):.1f} mm on it, too little")
    top[2, 3] += way
    return top, bottom


def _open_around(hand: Hand) -> None:
    """Open, or close in the air, until the pads are just off the object."""
    gripper = hand.robot.gripper
    near = min(hand.width + 0.006 + 3 * hand.declared.size_sd, gripper.max_opening)
    hand.robot.grip(near, gripper.min_speed, MAX_EFFORT)


def _close_by(hand: Hand, travel: float, most: float, air: float) -> None:
    """Close further by a way, or until a pad presses with a force [m, N]."""
    gripper = hand.robot.gripper
    travel = max(travel, STEPS * gripper.opening_quantum) + GIVE
    limit = min(air + most / gripper.force_per_ampere, MAX_EFFORT)
    hand.robot.grip(max(hand.robot.read().opening - travel, 0.0), gripper.min_speed, limit)


def _force(hand: Hand, closing: Sequence[Sample], air: float) -> float:
    """Return about what a pad pressed with at the end of a closing [N].

    The largest current of its second half: one that stalls ends on its largest, another may end with readings of
    a gripper that stands.
    """
    gripper = hand.robot.gripper
    effort = max(sample.effort for sample in closing[len(closing) // 2 :])
    return gripper.force_per_ampere * max(effort - air, 0.0) + gripper.friction_force


def _pull(hand: Hand, free: Sequence[Sample], slide: Sequence[Sample]) -> float:
    """Return what the table held against in the end of a slide, roughly [N]; < 0 for an object in the air."""
    return -9.81 * hand.rough_payload(free[len(free) // 2 :], slide[len(slide) // 2 :])
