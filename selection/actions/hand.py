"""The moves that actions share: reach, grasp, lift, put back. Every path is checked before it is run."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from dynamics.collision import Box, Workspace, shifted
from dynamics.errors import ActionFailed, MotionRefused
from dynamics.grasping import grasp_height
from dynamics.kinematics import solve_pose, straight_joints, straight_line
from dynamics.objects import DeclaredObject
from dynamics.robot import GripResult, Robot
from dynamics.signals import Sample
from dynamics.trajectory import time_path
from estimation.carried import carried_weight
from selection.actions.reach import GATE_HEIGHT, TABLE, closing_edge, find_grasp, free_space
from selection.tape import Tape

Array = NDArray[np.float64]

GRIP_EFFORT = 0.3  # A at which a grasp is tight
GRIP_STRAIN = 0.35  # compression of a soft object at which a grasp is tight enough
PROBE_STEP = 0.0015  # m that the gripper closes to feel whether something is still between the pads
MAX_EFFORT = 0.9  # A
CENTRING_EFFORT = 0.15  # A, enough to push what the pads can hold
PATH_SPEED = 0.6  # share of the arm's speed and acceleration limits
LINE_SPEED = 0.35
SOFT = 0.05  # compression at a grasp from which an object is soft
OFF = 0.004  # m over the table, to close on it again
LOWERING = 0.001  # m by which the hand goes down between two openings as it lets go
_PUSHED = 16  # samples in which to tell that something is pushed
_SAME = 1e-6  # rad: a motion of less is none


class Hand:
    """An arm and gripper at work on one object that stands on the table.

    Args:
        robot: moves and reads.
        declared: what is known of the object.
        tape: gathers what is read.

    Attributes:
        edge: which length of the object the pads close on.
        width: that length, as declared [m].
        present_width: the same, of what was pressed and has not sprung back [m].
        air, closing: what was read as the pads last closed, in air and then on the object.
        remarks: what was noticed of the object besides, for the user.

    Raises:
        InvalidInput: if the object is larger than the gripper opens, both ways, or stands out of reach.
    """

    def __init__(self, robot: Robot, declared: DeclaredObject, tape: Tape) -> None:
        self.robot, self.declared, self.tape = robot, declared, tape
        self.remarks: list[str] = []
        self._q = robot.read().q.copy()
        self._rest = self._q
        self.edge, _ = closing_edge(robot.gripper, declared)
        self.width = self.present_width = self._met = declared.size[self.edge]
        gripper = robot.gripper
        self._free = free_space(robot.arm, declared, self._rest)
        depth = gripper.pad_depth(self.width) - gripper.tool_depth
        self._height = grasp_height(gripper, declared, self.edge)
        held = shifted(0.0, 0.0, depth + self._height - declared.size[2] / 2)
        # The carried box is a little smaller, so that it may stand on the table.
        size = (declared.size[self.edge], declared.size[1 - self.edge], declared.size[2])
        carried = Box("carried object", tuple(edge - 0.01 for edge in size), held)  # type: ignore[arg-type]
        self._laden = Workspace(robot.arm, (TABLE,), self._rest, carried)
        self._is_laden = False
        self.grasp_pose, self._gate = find_grasp(gripper, self._free, declared, self._rest)

    @property
    def pad_height_at_grasp(self) -> float:
        """Height of the pads' centre over the table where they close on the object [m]."""
        return self._height

    def gate(self) -> None:
        """Go to the place above the object where every approach begins."""
        self.go(self._gate)

    def go(self, q: Array) -> None:
        """Move straight in joint space to joint positions."""
        self._run(straight_joints(self._q, q), PATH_SPEED)

    def line(self, pose: Array, speed: float = LINE_SPEED) -> None:
        """Move the tool straight to a pose."""
        self._run(straight_line(self.robot.arm, self._q, pose), speed)

    def plan_through(self, poses: Sequence[Array], count: int) -> tuple[Array, ...]:
        """Return joint positions for tool poses, visited one after the other from the gate, laden or not.

        Poses out of reach or in the way are left out; the first so many that are not make the tour.
        """
        positions: list[Array] = []
        near = self._gate
        for pose in poses:
            if len(positions) == count:
                break
            try:
                q = solve_pose(self.robot.arm, pose, near)
                self._laden.check(straight_joints(near, q))
                self._free.check(straight_joints(near, q))
                self._laden.check(straight_joints(q, self._gate))
                self._free.check(straight_joints(q, self._gate))
            except MotionRefused:
                continue
            positions.append(q)
            near = q
        return tuple(positions)

    def settle(self, seconds: float = 0.5) -> None:
        """Wait until the arm has stopped swinging."""
        self.robot.hold(seconds)

    def open_fully(self) -> None:
        """Open the gripper."""
        self.robot.grip(self.robot.gripper.max_opening, self.robot.gripper.max_speed, math.inf)

    def preshape(self) -> None:
        """Open the gripper as far as it will be with the object in it."""
        self.robot.grip(self.width, self.robot.gripper.max_speed, math.inf)

    def grasp(self, action: str) -> None:
        """Descend around the object and close on it; leaves phases ``air`` (closing in air) and ``grasp``.

        Raises:
            ActionFailed: ``missed``, if nothing is felt between the pads; ``displaced``, if something is felt
                before they are as near as the object is wide.
        """
        gripper = self.robot.gripper
        self.open_fully()
        self.line(self.grasp_pose)
        self.settle(0.2)
        air = self._close_in_air(action)
        if self._meets_early(air):
            self._centre()
            air = self._close_in_air(action)
            if self._meets_early(air):
                raise ActionFailed("displaced", "the pads meet something before they have closed to its width")
        self._met = self.present_width
        with self.tape.phase(action, "grasp") as closing:
            result = self.robot.grip((1 - GRIP_STRAIN) * self.present_width, gripper.min_speed, GRIP_EFFORT)
        self._is_laden = True
        self.air, self.closing = air, closing
        if result is GripResult.REACHED and not self._feels(closing[len(closing) // 2 :]):
            raise ActionFailed("missed", "the gripper closed without feeling the object")

    def tighten(self, action: str) -> None:
        """Close again on what is soft, just off the table, which has taken a part of the force; or do nothing."""
        now = self.robot.read().opening
        if self.present_width - now <= SOFT * self.present_width:
            return
        self.lift(self._swung(now) + OFF)
        opening = min((1 - GRIP_STRAIN) * self.present_width, now)
        with self.tape.phase(action, "tighten"):
            self.robot.grip(opening, self.robot.gripper.min_speed, GRIP_EFFORT)

    def regrasp(self, action: str, opening: float) -> list[Sample]:
        """Open on the object where it stands and close on it again; leaves a phase ``regrasp``, and returns it."""
        gripper = self.robot.gripper
        self.line(self._raised(self._swung(self.robot.read().opening)))
        self._let_go(action, "ungrasp", max(opening, self.robot.read().opening))
        self.line(self.grasp_pose)
        with self.tape.phase(action, "regrasp") as closing:
            self.robot.grip((1 - GRIP_STRAIN) * self.present_width, gripper.min_speed, GRIP_EFFORT)
        self.closing = closing
        return closing

    def lift(self, height: float | None = None) -> None:
        """Raise the object straight up, by a height or up to the gate."""
        if height is None:
            self.line(self.robot.arm.tool_pose(self._gate))
            self.go(self._gate)
        else:
            self.line(self._raised(height))

    def check_still_held(self, action: str) -> None:
        """Close a little further and feel for the object.

        Raises:
            ActionFailed: ``dropped``, if nothing presses back.
        """
        opening = self.robot.read().opening
        with self.tape.phase(action, "probe") as probe:
            result = self.robot.grip(max(opening - PROBE_STEP, 0.0), self.robot.gripper.min_speed, MAX_EFFORT)
        if result is GripResult.REACHED and not self._feels(probe[len(probe) // 3 :]):
            self._is_laden = False
            raise ActionFailed("dropped", "nothing presses against the pads any more")

    def put_back(self, action: str) -> None:
        """Set the object down where it stood, let go and rise to the gate.

        Pads that have closed since they met it hold it lower in the hand: the hand stays higher by that, or it
        would press the object onto the table, from where it jumps when it is let go.
        """
        place = self._swung(self.robot.read().opening)
        if self._height_above() > place + 1e-6:
            self.line(self._raised(place))
        self._let_go(action, "release", min(self.width + 0.006, self.robot.gripper.max_opening))
        self.retreat()

    def retreat(self) -> None:
        """Open fully, rise straight and go to the gate; works from wherever a failed action left the arm."""
        self._is_laden = False
        self.open_fully()
        if self._height_above() < GATE_HEIGHT - 1e-6:
            self.line(self.robot.arm.tool_pose(self._gate))
        self.go(self._gate)

    def rough_payload(self, before: Sequence[Sample], after: Sequence[Sample]) -> float:
        """Return what the arm carries more after than before, at about the same pose, roughly [kg].

        From the change of torque that gravity of the arm itself does not explain, on all joints at once; good
        enough to decide how hard to grip.
        """
        return carried_weight(self.robot.arm, before, after) / 9.81

    def _let_go(self, action: str, phase: str, opening: float) -> None:
        """Open, and keep the pads at their height meanwhile, for they swing up and take along what is light."""
        gripper, now = self.robot.gripper, self.robot.read().opening
        free = min(opening, max(self._met, now))
        steps = math.ceil((self._swung(now) - self._swung(free)) / LOWERING - 0.5)
        for step in np.linspace(now, free, steps + 1)[1:]:
            with self.tape.phase(action, phase):
                self.robot.grip(float(step), gripper.min_speed, math.inf)
            place = self._swung(float(step))
            if self._height_above() > place + 1e-6:
                self.line(self._raised(place))
        with self.tape.phase(action, phase):
            self.robot.grip(opening, gripper.min_speed, math.inf)

    def _swung(self, opening: float) -> float:
        """Return how far pads that are so far open have come down since they met the object [m]."""
        gripper = self.robot.gripper
        return max(gripper.pad_depth(opening) - gripper.pad_depth(self._met), 0.0)

    def _raised(self, height: float) -> Array:
        """Return the pose over the one in which the object is grasped."""
        pose = self.grasp_pose.copy()
        pose[2, 3] += height
        return pose

    def _close_in_air(self, action: str) -> list[Sample]:
        """Close to just off the object; leaves a phase ``air``, and returns it."""
        gripper = self.robot.gripper
        near = min(self.width + 0.006 + 3 * self.declared.size_sd, gripper.max_opening)
        with self.tape.phase(action, "air") as air:
            self.robot.grip(near, gripper.min_speed, MAX_EFFORT)
        return air

    def _centre(self) -> None:
        """Push an object that stands aside to where both pads touch it, and let go of it there."""
        self.remarks.append("it did not stand where it was believed to: the pads met it early and moved it")
        self.robot.grip((1 - GRIP_STRAIN) * self.present_width, self.robot.gripper.min_speed, CENTRING_EFFORT)
        self.open_fully()

    def _meets_early(self, air: Sequence[Sample]) -> bool:
        """Tell whether the motor worked harder at the end of closing in air than before."""
        steps = np.flatnonzero(np.diff([sample.opening for sample in air]) < 0)
        if not len(steps):
            return False
        # The current of pads that stand still is not that of closing on nothing.
        effort = np.array([sample.effort for sample in air[int(steps[0]) + 1 : int(steps[-1]) + 1]])
        if len(effort) < 2 * _PUSHED:
            return False
        quantum = self.robot.gripper.effort_quantum
        begin, end = effort[: len(effort) // 2], effort[-_PUSHED:]
        spread = max(float(begin.std()), quantum)
        return bool(end.mean() - begin.mean() > 5 * spread / math.sqrt(_PUSHED) + max(quantum / 2, 1e-6))

    def _run(self, path: Array, speed: float) -> None:
        if np.abs(path - self._q).max() < _SAME:
            return
        (self._laden if self._is_laden else self._free).check(path)
        self.robot.follow(time_path(self.robot.arm, path, speed))
        self._q = path[-1]

    def _height_above(self) -> float:
        return float(self.robot.arm.tool_pose(self._q)[2, 3] - self.grasp_pose[2, 3])

    def _feels(self, samples: Sequence[Sample]) -> bool:
        """Tell whether the motor worked harder than in air, by three standard errors and half a step."""
        if len(samples) < 2:
            return False
        air = np.array([s.effort for s in self.air])
        here = np.array([s.effort for s in samples])
        error = math.sqrt(air.var() / len(air) + here.var() / len(here))
        return bool(here.mean() - air.mean() > 3 * error + 0.5 * self.robot.gripper.effort_quantum)
