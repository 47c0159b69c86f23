"""How MuJoCo draws: on a display where there is one, without one where a library for that is installed."""

from __future__ import annotations

import os
import sys
from ctypes.util import find_library

from dynamics.robot import CannotDraw

BACKENDS = {"egl": "EGL", "osmesa": "OSMesa"}  # by the names of MUJOCO_GL: the system's library
PACKAGES = "libegl1 libegl-mesa0 libgl1-mesa-dri"  # of Debian and Ubuntu


def choose_backend() -> None:
    """Set MUJOCO_GL where nobody has and there is no display; to be called before MuJoCo is first imported."""
    if "MUJOCO_GL" in os.environ or has_display() or sys.platform != "linux":
        return
    for backend, library in BACKENDS.items():
        if find_library(library):
            os.environ["MUJOCO_GL"] = backend
            return


def check_drawing() -> None:
    """Refuse to draw with a window library but no display, for there MuJoCo ends the process.

    Raises:
        CannotDraw: if MuJoCo, as it was imported, would draw that way, or not at all.
    """
    from mujoco.rendering.classic import gl_context

    context = getattr(gl_context, "GLContext", None)
    if context is None or (context.__module__.endswith("glfw") and not has_display()):
        raise CannotDraw(f"no picture without a display, or OpenGL without one (on Debian: {PACKAGES})")


def has_display() -> bool:
    """Tell whether there is a display to open windows on."""
    return sys.platform != "linux" or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
