"""A film of a run: frames at even times of the robot's clock, as an animated picture."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from dynamics.robot import Camera
from dynamics.signals import Sample

FORMATS = {".webp": "WEBP", ".gif": "GIF", ".png": "PNG"}
WIDTH, HEIGHT = 480, 320  # pixels
PERIOD = 0.5  # s of the robot's clock between frames
SHOWN = 100  # ms that a frame is shown: five times as fast as the robot
MOST_FRAMES = 600  # in memory; beyond, every second one is dropped


class Film:
    """Gathers frames while a robot moves; a listener of it.

    Args:
        camera: takes them.
        name: of the camera that sees it all.
    """

    def __init__(self, camera: Camera, name: str = "overview") -> None:
        self._camera, self._name = camera, name
        self._frames: list[NDArray[np.uint8]] = []
        self._period, self._due = PERIOD, 0.0

    def follow(self, sample: Sample) -> None:
        """Take a frame if it is time for one.

        Raises:
            CannotDraw: if there is no OpenGL.
        """
        if sample.time < self._due:
            return
        self._due = sample.time + self._period
        self._frames.append(self._camera.picture(self._name, WIDTH, HEIGHT))
        if len(self._frames) > MOST_FRAMES:
            del self._frames[1::2]
            self._period *= 2

    def save(self, path: Path) -> None:
        """Write the film; the end of the file's name says how."""
        from PIL import Image

        if not self._frames:
            return
        first, *rest = (Image.fromarray(frame) for frame in self._frames)
        temporary = path.with_name(f".{path.name}.tmp")
        kind = FORMATS[path.suffix.lower()]
        first.save(temporary, format=kind, save_all=True, append_images=rest, duration=SHOWN, loop=0)
        temporary.replace(path)
