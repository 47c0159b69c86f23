"""The actions the robot can take."""

from __future__ import annotations

from selection.actions.action import Action, Findings, Readings
from selection.actions.rub import Rub
from selection.actions.squeeze import Squeeze
from selection.actions.weigh import Weigh

ACTIONS: tuple[Action, ...] = (Weigh(), Squeeze(), Rub())

__all__ = ["ACTIONS", "Action", "Findings", "Readings", "Rub", "Squeeze", "Weigh"]
