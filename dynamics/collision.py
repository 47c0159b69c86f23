"""What is in the way: checks a path of the arm against the table, the object and itself, by Coal."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from dynamics.arm import Arm
from dynamics.errors import InvalidInput, MotionRefused

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Box:
    """A box that the arm must not touch, or what round body it holds.

    Attributes:
        name: what to call it in messages.
        size: its full edge lengths [m], (3,).
        pose: of its centre in the base, (4, 4).
        body: ``box``, or the ``cylinder`` (upright) or ``ellipsoid`` that fills it.
    """

    name: str
    size: tuple[float, float, float]
    pose: Array
    body: Literal["box", "cylinder", "ellipsoid"] = "box"


def shifted(x: float, y: float, z: float) -> Array:
    """Return the pose that is moved by so much and not turned, (4, 4)."""
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


class Workspace:
    """The arm among boxes, one of which it may carry.

    Args:
        arm: an arm whose description has shapes.
        boxes: fixed boxes.
        rest: joint positions known to be free [rad], (nv,): links that touch each other there (neighbours
            do) are not checked against each other.
        carried: a box that moves with the tool, its pose given in the tool frame; it is checked against the
            other boxes alone.
    """

    def __init__(self, arm: Arm, boxes: tuple[Box, ...], rest: Array, carried: Box | None = None) -> None:
        if arm.geometry is None:
            raise MotionRefused(f"{arm.name} has no collision shapes, so no path can be checked")
        self.arm = arm
        self._geometry = arm.geometry.copy()
        links = range(len(self._geometry.geometryObjects))
        tool = arm.model.frames[arm.model.getFrameId(arm.tool_frame)]
        fixed = [self._add(box, 0, pin.SE3(box.pose)) for box in boxes]
        for index, box in zip(fixed, boxes, strict=True):
            for link in links:
                if self._geometry.geometryObjects[link].parentJoint > 0:
                    self._geometry.addCollisionPair(pin.CollisionPair(link, index))
            if carried is not None and box.name != carried.name:
                held = self._add(carried, tool.parentJoint, tool.placement * pin.SE3(carried.pose))
                self._geometry.addCollisionPair(pin.CollisionPair(held, index))
        for a in links:
            for b in range(a + 1, len(links)):
                self._geometry.addCollisionPair(pin.CollisionPair(a, b))
        self._data = arm.model.createData()
        self._results = self._geometry.createData()
        self._ignore = {
            (pair.first, pair.second)
            for pair in self._touching(rest)
            if pair.first in links and pair.second in links
        }
        for first, second in self._ignore:
            self._geometry.removeCollisionPair(pin.CollisionPair(first, second))
        self._results = self._geometry.createData()

    def check(self, path: Array, step: float = 0.02) -> None:
        """Refuse a path that touches something.

        Args:
            path: joint positions [rad], (N, nv).
            step: largest joint motion between two checks [rad].

        Raises:
            MotionRefused: naming what would touch what, and how far along.
            InvalidInput: for a path of the wrong shape or with numbers that are not finite.
        """
        points = np.asarray(path, float)
        nv = self.arm.nv
        if points.ndim != 2 or len(points) < 1 or points.shape[1] != nv or not np.all(np.isfinite(points)):
            raise InvalidInput("collision check: path", f"shape {points.shape}", f"finite positions, (N, {nv})")
        if len(points) == 1:
            points = points[[0, 0]]
        for number, (a, b) in enumerate(pairwise(points)):
            for q in np.linspace(a, b, max(int(np.ceil(np.abs(b - a).max() / step)), 1) + 1):
                touching = self._touching(q)
                if touching:
                    objects = self._geometry.geometryObjects
                    pair = touching[0]
                    share = 100 * number / max(len(points) - 1, 1)
                    raise MotionRefused(
                        f"the path would bring {objects[pair.first].name} against {objects[pair.second].name}, "
                        f"{share:.0f} % along"
                    )

    def is_free(self, q: Array) -> bool:
        """Tell whether nothing touches at a joint position."""
        return not self._touching(q)

    def _touching(self, q: Array) -> list[pin.CollisionPair]:
        pin.computeCollisions(
            self.arm.model, self._data, self._geometry, self._results, self.arm.configuration(q), False
        )
        return [
            pair
            for pair, result in zip(self._geometry.collisionPairs, self._results.collisionResults, strict=True)
            if result.isCollision()
        ]

    def _add(self, box: Box, joint: int, placement: pin.SE3) -> int:
        if box.body == "box":
            shape = coal.Box(*box.size)
        elif box.body == "cylinder":
            shape = coal.Cylinder(max(box.size[:2]) / 2, box.size[2])
        else:
            shape = coal.Ellipsoid(*(edge / 2 for edge in box.size))
        index: int = self._geometry.addGeometryObject(pin.GeometryObject(box.name, joint, placement, shape))
        return index
