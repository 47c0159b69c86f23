"""MuJoCo's interactive viewer beside a simulated robot that goes its own way."""

from __future__ import annotations

import time
import warnings
from typing import Any

import mujoco

from dynamics.robot import CannotDraw
from dynamics.signals import Sample
from sim.opengl import has_display

FRAMES = 30.0  # 1/s of the wall's time


class Viewer:
    """A window on a simulation, in which a person may look around while the robot works.

    Args:
        model, data: what to show.
        speed: of the simulation against real time, at most.

    Raises:
        CannotDraw: if there is no display, or no OpenGL on it.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, speed: float = 1.0) -> None:
        if not has_display():
            raise CannotDraw("no display to open the viewer on")
        import glfw

        with warnings.catch_warnings():
            warnings.simplefilter("ignore", glfw.GLFWError)
            if not glfw.init():  # the viewer would wait for its window for ever
                raise CannotDraw("the display does not let the viewer open a window")
        import mujoco.viewer

        self._handle: Any = mujoco.viewer.launch_passive(model, data, show_left_ui=False, show_right_ui=False)
        self._speed = speed
        self._start: tuple[float, float] | None = None
        self._shown = 0.0

    def follow(self, sample: Sample) -> None:
        """Show the newest state; a listener of the robot. Waits where the simulation runs ahead of time."""
        if not self._handle.is_running():
            return
        now = time.monotonic()
        if self._start is None:
            self._start = now, sample.time
        due = self._start[0] + (sample.time - self._start[1]) / self._speed
        if due > now:
            time.sleep(due - now)
        if now - self._shown >= 1 / FRAMES:
            self._handle.sync()
            self._shown = now

    def close(self) -> None:
        """Close the window."""
        self._handle.close()
