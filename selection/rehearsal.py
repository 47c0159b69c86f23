"""Rehearse the next action: every motion planned and checked, none of them made, nothing recorded.

What an action does by what it reads (how far and how often it presses, when it has weighed enough) can turn out
otherwise: a stand-in for the robot reads what is nominal.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from dynamics.signals import Phase
from selection.stand_in import SAMPLE_TIME, Move


@dataclass(frozen=True)
class Rehearsed:
    """What a rehearsal came to.

    Attributes:
        action: its name.
        moves: all of them, in order; up to the one that failed, if any.
        phases: the stretches that would be measured.
        problem: why the action can not be done; empty if it can.
    """

    action: str
    moves: tuple[Move, ...]
    phases: tuple[Phase, ...]
    problem: str = ""

    @property
    def seconds(self) -> float:
        """How long the motions would take [s]."""
        return sum(move.seconds for move in self.moves)

    def phase_of(self, move: Move) -> str:
        """Return the name of the phase in which a move would be measured, or nothing."""
        middle = move.start + move.seconds / 2
        for phase in self.phases:
            if phase.samples and phase.samples[0].time - SAMPLE_TIME <= middle <= phase.samples[-1].time:
                return f"{phase.action} {phase.name}"
        return ""


def told(rehearsed: Rehearsed) -> Sequence[str]:
    """Return a rehearsal as lines for people."""
    lines = []
    for move in rehearsed.moves:
        x, y, z = move.place
        where = {
            "arm": f"tool to ({x:.3f}, {y:.3f}, {z:.3f}) m",
            "gripper": f"to {1000 * move.opening:.1f} mm",
            "hold": "",
        }[move.kind]
        lines.append(f"  {move.seconds:6.2f} s  {move.kind:8} {where:34} {rehearsed.phase_of(move)}".rstrip())
    if rehearsed.problem:
        lines.append(f"cannot    {rehearsed.action}: {rehearsed.problem}")
        return lines
    count = {kind: sum(move.kind == kind for move in rehearsed.moves) for kind in ("arm", "gripper")}
    motions = f"{count['arm']} motions of the arm and {count['gripper']} of the gripper"
    lines.append(f"possible  {rehearsed.action}: {motions}, {rehearsed.seconds:.0f} s; nothing moved")
    lines.append("what it reads decides how far and how often it presses, and what comes after it")
    return lines
