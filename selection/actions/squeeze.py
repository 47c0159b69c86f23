"""Squeeze: compress the object by steps, held just above the table, and let it spring back, a few times."""

from __future__ import annotations

import math

import numpy as np

from dynamics.errors import ActionFailed
from dynamics.robot import GripResult
from dynamics.signals import Sample
from estimation.carried import pull_of_weight
from estimation.network import Network
from estimation.sensor import Sensor
from selection.actions.action import Findings, Readings
from selection.actions.hand import GRIP_EFFORT, MAX_EFFORT, SOFT, Hand
from selection.actions.springing import LEAST_STRAIN, SLIPPERY, Grip
from selection.planner import ActionModel

CLEARANCE = 0.006  # m that is left to the table when the object is squeezed most
BULGE = 0.1  # of its height, by which an object that is squeezed grows downward at most: 0.45 MAX_STRAIN / 2
STEP = 0.0015  # m of closing a step
DWELL = 0.15  # s between steps
TRAVEL = 0.03  # m of closing altogether: a stiff object gives little at a time and is squeezed more often
MOST_CYCLES = 8
LEAST_CYCLES = 3
MAX_STRAIN = 0.42
RIGID_STRAIN = 1e-3  # compression of which nothing can be told
HIGHER = 0.005  # m by which what is soft is raised further, to feel whether it hangs or sags onto the table
SETTLING = 2  # readings of a closing in which the motor still speeds up
NEAR = 8e-4  # m, within which readings of the first squeeze tell what the pads held with at an opening
ROUGH = 0.6  # coefficient of friction, of which more may be the table's doing: what slides is carried in part
_LOOK = 0.6  # s of holding still to feel the weight: white noise of 0.3 N m is then 0.1 N of a change
_LOST = 0.15, 0.3  # share of the weight, and N: a change of what is carried that tells of slipping


class Squeeze:
    """Squeeze the object and read its elasticity, and its width at contact, off gripper opening and current."""

    name = "squeeze"
    seconds, setup_seconds = 22.0, 8.0  # s, of the cycles and of the grasp; replaced by what it took
    sensor = Sensor("elasticity", 300.0, 0.08)  # where the reference has none: default noise of the simulator

    def model(self, network: Network) -> ActionModel | None:
        """Return what squeezing informs: the elasticity.

        The force's calibration is common to all squeezes, so a second one would not tell much more: one only.
        """
        if "elasticity" not in network.quantities:
            return None
        sensor = dict(network.sensors).get("squeeze", self.sensor)
        return ActionModel(self.name, (sensor,), self.seconds, "grasp", self.setup_seconds, repeat_cap=1)

    def perform(self, hand: Hand) -> None:
        """Squeeze the object; leaves phases ``air``, ``grasp``, ``regrasp``, ``compress``, ``dwell``, ``release``.

        The motor current tells of force only while the gripper moves, so the readings are in the steps themselves.

        Raises:
            ActionFailed: if the object was missed, slipped or dropped.
        """
        hand.gate()
        hand.open_fully()
        hand.line(hand.grasp_pose)
        hand.settle()
        with hand.tape.phase(self.name, "look") as empty:
            hand.robot.hold(_LOOK)
        hand.grasp(self.name)
        closing = hand.closing
        again = closing
        if max(sample.effort for sample in closing) >= GRIP_EFFORT:
            again = hand.regrasp(self.name, (1 - LEAST_STRAIN) * hand.width)
        hand.lift(_lift(hand))
        hand.settle()
        with hand.tape.phase(self.name, "look") as laden:
            hand.robot.hold(_LOOK)
        weight = 9.81 * max(hand.rough_payload(empty, laden), 0.0)
        _check_grip(hand, closing, weight)
        if hand.width - hand.robot.read().opening > SOFT * hand.width:
            weight = _hangs(hand, empty, weight)
        grip = Grip(hand, closing, again, weight)
        tight = hand.robot.read().opening
        travel, cycle = 0.0, 0
        while cycle < LEAST_CYCLES or (travel < TRAVEL and cycle < MOST_CYCLES):
            # Cycles start a share of the opening's step apart, so that its coarse reading differs.
            opening = grip.opening((cycle % LEAST_CYCLES) / LEAST_CYCLES * hand.robot.gripper.opening_quantum)
            if cycle and opening is None:
                break  # it gives back too little to be let go at all
            if opening is not None:
                with hand.tape.phase(self.name, "release"):
                    hand.robot.grip(opening, hand.robot.gripper.min_speed, math.inf)
            gave = _compress(hand)
            if cycle == 0:
                _check_hold(hand, weight, tight)
            travel += gave
            cycle += 1
            if gave <= max(hand.robot.gripper.opening_quantum, RIGID_STRAIN * hand.width):
                break  # too stiff to tell: more of it would tell no more, and to let go a little is to let go
        with hand.tape.phase(self.name, "look") as after:
            hand.robot.hold(_LOOK)
        change = abs(9.81 * hand.rough_payload(empty, after) - weight)
        if change > _LOST[0] * weight + _LOST[1]:
            raise ActionFailed(
                "slipped",
                f"the pads carried {weight:.1f} N before squeezing and {change:.1f} N more or less after",
            )
        if grip.keeps_shape():
            hand.present_width = hand.robot.read().opening
        hand.check_still_held(self.name)
        hand.put_back(self.name)

    def measure(self, readings: Readings) -> Findings:
        """Measure elasticity and width."""
        from estimation.squeezed import believe_squeeze

        robot = readings.robot
        found = believe_squeeze(
            robot.arm, robot.gripper, readings.shape, readings.size, readings.edge, readings.phases
        )
        return Findings(found.measurements, found.notes)


def _lift(hand: Hand) -> float:
    """Return how high to hold the object: the pads swing down as they close, and the object bulges [m]."""
    gripper = hand.robot.gripper
    swing = gripper.pad_depth((1 - MAX_STRAIN) * hand.width) - gripper.pad_depth(hand.width)
    return CLEARANCE + swing + BULGE * hand.declared.size[2]


def _compress(hand: Hand) -> float:
    """Close by steps until the strain or the force is enough; return how far the pads came [m]."""
    gripper = hand.robot.gripper
    start = target = hand.robot.read().opening
    while target > (1 - MAX_STRAIN) * hand.width:
        target -= STEP
        with hand.tape.phase("squeeze", "compress"):
            result = hand.robot.grip(max(target, 0.0), gripper.min_speed, MAX_EFFORT)
        with hand.tape.phase("squeeze", "dwell"):
            hand.robot.hold(DWELL)
        if result is GripResult.STALLED:
            break
    return start - hand.robot.read().opening


def _hangs(hand: Hand, empty: list[Sample], weight: float) -> float:
    """Raise the object further and return what the pads carry then [N].

    Raises:
        ActionFailed: ``too heavy``, if it is more than before: the table has carried the rest.
    """
    hand.lift(_lift(hand) + HIGHER)
    hand.settle()
    with hand.tape.phase("squeeze", "look") as laden:
        hand.robot.hold(_LOOK)
    more = 9.81 * max(hand.rough_payload(empty, laden), 0.0)
    if more - weight > _LOST[0] * weight + _LOST[1]:
        raise ActionFailed(
            "too heavy",
            f"it sags onto the table: the pads carry {weight:.1f} N, and {more:.1f} N {HIGHER:g} m higher up",
        )
    return more


def _check_hold(hand: Hand, weight: float, tight: float) -> None:
    """See that the weight needed no more friction than most things have, by the first squeeze.

    In the air the table adds nothing to the force at the opening at which the object was lifted, as it does when
    pads close on what stands there.

    Raises:
        ActionFailed: ``too heavy``, if it would need more.
    """
    gripper = hand.robot.gripper
    closing = [s for phase in hand.tape.phases if phase.name == "compress" for s in phase.samples[SETTLING:]]
    held = [sample for sample in closing if abs(sample.opening - tight) <= NEAR]
    if not held:
        return  # closing ended within the first readings: so stiff that it is held with all that the gripper has
    effort, air = (float(np.median([s.effort for s in readings])) for readings in (held, hand.air))
    force = gripper.force_per_ampere * (effort - air) + gripper.friction_force
    force += float(pull_of_weight(gripper, weight, np.array([tight]))[0])
    if 2 * ROUGH * force < weight:
        raise ActionFailed(
            "too heavy",
            f"the pads pressed with {force:.1f} N as they lifted it, which hardly holds the {weight:.1f} N "
            "that they carry: the table may carry the rest",
        )


def _check_grip(hand: Hand, closing: list[Sample], weight: float) -> None:
    """See that the force at which closing ended can hold what is felt of the weight, by the friction counted on.

    What stays on the table or creeps between the pads is not compressed by them alone, and reads as too soft.

    Raises:
        ActionFailed: ``too heavy``, if it cannot.
    """
    gripper = hand.robot.gripper
    effort = max(sample.effort for sample in closing[-3:])  # on what is stiff it rises within one of them
    force = gripper.force_per_ampere * effort + gripper.friction_force
    if 2 * SLIPPERY * force < weight:
        raise ActionFailed(
            "too heavy",
            f"the pads press with {force:.1f} N at the strain allowed, which cannot be counted on to hold "
            f"the {weight:.1f} N that the object weighs at least",
        )
