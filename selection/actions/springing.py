"""How far the pads may open between two squeezes without losing the object: as far as it springs back."""

from __future__ import annotations

from dynamics.signals import Sample
from estimation.springing import LEAST_TICKS, PLASTIC, comes_back, lost_work
from selection.actions.hand import Hand

LEAST_STRAIN = 0.03  # to which the object is let spring back, if its weight allows
STIFF = 0.05  # strain of an object that has hardly given way at all
SLIPPERY = 0.4  # coefficient of friction that is counted on
_SAFETY = 1.5  # on the grip force
_MOST_FRICTION = 1.0  # coefficient that is counted on where friction does harm


class Grip:
    """The hold on an object that is squeezed in the air.

    The pads never open further than where the object is known to press with the least safe force. What springs
    back does so where the pads first met that force. What does not is felt for: closed on again while it stood on
    the table, it told how far it comes back from the force of a grasp, and from a larger one it comes back no
    less; then every squeeze tells how far it comes back from that one.

    Args:
        hand: holds the object.
        closing: how the pads closed on it first.
        again: how they did it again, from no further open than a squeeze begins.
        weight: what hangs between them [N].
    """

    def __init__(self, hand: Hand, closing: list[Sample], again: list[Sample], weight: float) -> None:
        self._hand = hand
        self._effort = _least_effort(hand, weight)
        self._start = self._opening_at(closing)
        self._tight = hand.robot.read().opening
        self._tick = hand.robot.gripper.opening_quantum
        at = self._opening_at(again)
        self._recovers = at - min(sample.opening for sample in again) - self._tick
        if at < self._start - LEAST_TICKS * self._tick:
            self._start = at
        self._begun = False

    def opening(self, shift: float) -> float | None:
        """Return how far to open before the next squeeze [m], or None where the object is not to be let go at all.

        Args:
            shift: by which to open less [m].
        """
        start = self._start - shift
        if not self._begun:
            self._begun = True  # what has hardly given way may not do so at all: not yet
            return start if start > self._tight else None
        start = max(start, self._tight)
        now = self._hand.robot.read().opening
        if start - now <= 2 * LEAST_TICKS * self._tick or start - now <= STIFF * self._hand.width:
            return start  # so stiff that how far it comes back is not known better than that it does
        felt = comes_back(self._hand.tape.phases, self._effort, self._tick) - self._tick
        start = min(start, now + max(self._recovers, felt) - shift)
        return start if start > now + self._tick else None

    def keeps_shape(self) -> bool:
        """Tell whether the object has kept the shape that it was pressed to."""
        air = sum(sample.effort for sample in self._hand.air) / len(self._hand.air)
        return lost_work(self._hand.tape.phases, air, self._tick) > PLASTIC

    def _opening_at(self, closing: list[Sample]) -> float:
        """Return the opening at which closing met the least safe force [m]."""
        tight = [sample.opening for sample in closing if sample.effort >= self._effort]
        return min(max(tight, default=self._hand.robot.read().opening), (1 - LEAST_STRAIN) * self._hand.width)


def _least_effort(hand: Hand, weight: float) -> float:
    """Return the current of pads that close with the least safe force [A].

    The grip force F must carry the weight, 2 mu F >= safety x weight. Closing on the table reads high, by up to
    1 + mu swing, for the pads come down as they close and the object cannot.
    """
    gripper = hand.robot.gripper
    shear = 1 + _MOST_FRICTION * gripper.swing(hand.width)
    force = shear * _SAFETY * weight / (2 * SLIPPERY)
    return (force + gripper.friction_force) / gripper.force_per_ampere + 2 * gripper.effort_quantum
