"""Pictures of a run: before it, at its moments, after every action; kept as ``pictures/NN-what.png``."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from dynamics.robot import Camera, CannotDraw, Robot
from estimation.belief import Belief
from selection.exploration import Step
from selection.planner import Decision

FOLDER = "pictures"
WIDTH, HEIGHT = 720, 480  # pixels
AROUND, NEAR = ("overview", "close"), ("close", "wrist")
MOMENTS = {  # action, phase that begins first, phase before it if that matters: what is seen, by whom
    ("weigh", "hold", ""): ("held", ("overview", "wrist")),
    ("squeeze", "release", "dwell"): ("tightest", NEAR),
    ("rub", "slide", ""): ("rubbing", NEAR),
    ("observe", "look", ""): ("seen", ("wrist", "overview")),
}

Tell = Callable[[str], None]


class Pictures:
    """Takes pictures of an exploration that it watches, as far as the robot has cameras.

    Args:
        robot: who may have cameras.
        tell: is told, once, why there are no pictures.
    """

    def __init__(self, robot: Robot, tell: Tell) -> None:
        self._camera = robot if isinstance(robot, Camera) else None
        self._tell = tell
        self._folder: Path | None = None
        self._count = 0
        self._before = ("", "")
        self._seen: set[tuple[str, str, str]] = set()

    def keep_in(self, run: Path) -> None:
        """Keep pictures in a run directory from now on, after those that are there."""
        self._folder = run / FOLDER
        numbers = (re.match(r"(\d+)-", path.name) for path in self._folder.glob("*.png"))
        self._count = 1 + max((int(found[1]) for found in numbers if found), default=-1)

    def begins(self, belief: Belief) -> None:
        """Take a picture of the beginning."""
        self._take("begin", AROUND)

    def decides(self, decision: Decision) -> None:
        """Get ready for an action."""
        self._seen.clear()
        self._before = ("", "")

    def phase(self, action: str, name: str) -> None:
        """Take a picture if this is a moment to keep; called when a phase begins."""
        after = self._before[1] if self._before[0] == action else ""
        self._before = (action, name)
        for moment in ((action, name, after), (action, name, "")):
            if moment in MOMENTS and moment not in self._seen:
                self._seen.add(moment)
                what, cameras = MOMENTS[moment]
                self._take(f"{action}-{what}", cameras)

    def learns(self, step: Step) -> None:
        """Take a picture of how an action left things."""
        self._take(f"{step.action}-{'done' if step.ok else 'failed'}", AROUND)

    def close(self) -> None:
        """Nothing is left open."""

    def _take(self, what: str, cameras: tuple[str, ...]) -> None:
        if self._camera is None or self._folder is None:
            return
        try:
            for name in cameras:
                if name in self._camera.cameras:
                    pixels = self._camera.picture(name, WIDTH, HEIGHT)
                    save_png(self._folder / f"{self._count:02d}-{what}-{name}.png", pixels)
                    self._count += 1
        except CannotDraw as error:
            self._camera = None  # nor later
            self._tell(str(error))


def save_png(path: Path, pixels: NDArray[np.uint8]) -> None:
    """Write a picture, (height, width, 3)."""
    from PIL import Image

    path.parent.mkdir(exist_ok=True)
    Image.fromarray(pixels).save(path, format="PNG")
