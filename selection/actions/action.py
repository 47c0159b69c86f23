"""What an action is: what it informs and costs, how it moves, how its readings are measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from dynamics.robot import Robot
from dynamics.shapes import Shape
from dynamics.signals import Phase
from estimation.measurement import Measurement
from estimation.network import Network
from estimation.observation import Observation
from estimation.size import SizeEstimate
from selection.actions.hand import Hand
from selection.planner import ActionModel


@dataclass(frozen=True)
class Readings:
    """What an action left behind, and what its measuring needs to know.

    Attributes:
        robot: gives the descriptions of arm and gripper.
        phases: the marked samples.
        shape: of the object.
        size: of the object, as known so far.
        edge: which edge of the object the pads close on.
    """

    robot: Robot
    phases: Sequence[Phase]
    shape: Shape
    size: SizeEstimate
    edge: int


@dataclass(frozen=True)
class Findings:
    """What the readings of an action came to.

    Attributes:
        measurements: quantities with their uncertainty.
        notes: what else a person should know, such as a bound where no number could be given.
        observations: evidence about classes.
    """

    measurements: tuple[Measurement, ...]
    notes: tuple[str, ...] = ()
    observations: tuple[Observation, ...] = ()


class Action(Protocol):
    """One entry of the repertoire: add a class with these members and a line in `selection.actions`."""

    name: str

    def model(self, network: Network) -> ActionModel | None:
        """Return what the action informs and costs, or None if the reference knows nothing it could inform."""
        ...

    def perform(self, hand: Hand) -> None:
        """Move; everything worth measuring is left in marked phases."""
        ...

    def measure(self, readings: Readings) -> Findings:
        """Turn the phases into measurements, by the one function of `estimation` for this kind of action."""
        ...


@runtime_checkable
class Demanding(Protocol):
    """An action that not every object allows."""

    def check(self, hand: Hand) -> None:
        """Refuse an object by what is declared of it, before anything moves.

        Raises:
            ActionFailed: if the action cannot be done on it.
        """
        ...
