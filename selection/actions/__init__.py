"""The actions the robot can take."""

from __future__ import annotations

from collections.abc import Callable

from selection.actions.action import Action, Demanding, Findings, Readings
from selection.actions.observe import Observe
from selection.actions.rub import Rub
from selection.actions.sound import Sound
from selection.actions.squeeze import Squeeze
from selection.actions.weigh import Weigh
from selection.eyes import Classifier, Senses

ACTIONS: tuple[Action, ...] = (Weigh(), Squeeze(), Rub())
"""What the arm and the gripper can find out by themselves."""

PERCEIVING: dict[str, Callable[[Classifier], Action]] = {"observe": Observe, "sound": Sound}
"""What needs a classifier, by the name of the sensor model in the reference."""


def repertoire(senses: Senses) -> tuple[Action, ...]:
    """Return all actions that the senses allow."""
    return (*ACTIONS, *(make(senses[name]) for name, make in PERCEIVING.items() if name in senses))


__all__ = [
    "ACTIONS",
    "PERCEIVING",
    "Action",
    "Demanding",
    "Findings",
    "Observe",
    "Readings",
    "Rub",
    "Sound",
    "Squeeze",
    "Weigh",
    "repertoire",
]
