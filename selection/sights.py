"""Everything that shows a run while it goes on: the viewer, pictures, a film."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from dynamics.robot import Camera, CannotDraw
from estimation.belief import Belief
from selection.exploration import Step, Watcher
from selection.film import Film
from selection.pictures import Pictures
from selection.planner import Decision
from selection.robots import OpenedRobot

Tell = Callable[[str], None]


class Sights:
    """Shows a run as far as the robot and this machine can; what they cannot is said in a line, and left out.

    Args:
        opened: the robot, before it moves.
        view: speed of the viewer against real time; None for no viewer.
        pictures: whether to take pictures.
        video: where to write a film; None for no film.
        tell: is told what cannot be shown.
    """

    def __init__(
        self, opened: OpenedRobot, view: float | None, pictures: bool, video: Path | None, tell: Tell
    ) -> None:
        self._pictures = Pictures(opened.robot, tell) if pictures else None
        self._film: Film | None = None
        self._video = video
        if view is not None:
            _open_viewer(opened, view, pictures, tell)
        if video is not None:
            self._film = _begin_film(opened, tell)

    def keep_in(self, run: Path) -> None:
        """Keep pictures in a run directory."""
        if self._pictures is not None:
            self._pictures.keep_in(run)

    def phase(self, action: str, name: str) -> None:
        """Show that a phase begins."""
        if self._pictures is not None:
            self._pictures.phase(action, name)

    def begins(self, belief: Belief) -> None:
        """Show how it begins."""
        if self._pictures is not None:
            self._pictures.begins(belief)

    def decides(self, decision: Decision) -> None:
        """Show what comes."""
        if self._pictures is not None:
            self._pictures.decides(decision)

    def learns(self, step: Step) -> None:
        """Show what came of an action."""
        if self._pictures is not None:
            self._pictures.learns(step)

    def close(self) -> None:
        """Write what is only written at the end."""
        if self._film is not None and self._video is not None:
            self._film.save(self._video)


class Together:
    """Tells several watchers the same.

    Args:
        watchers: whom.
    """

    def __init__(self, *watchers: Watcher) -> None:
        self._watchers: Sequence[Watcher] = watchers

    def begins(self, belief: Belief) -> None:
        """Show what is believed beforehand."""
        for watcher in self._watchers:
            watcher.begins(belief)

    def decides(self, decision: Decision) -> None:
        """Show what the planner thinks of every action, and its choice."""
        for watcher in self._watchers:
            watcher.decides(decision)

    def learns(self, step: Step) -> None:
        """Show what an action brought."""
        for watcher in self._watchers:
            watcher.learns(step)


def _open_viewer(opened: OpenedRobot, speed: float, pictures: bool, tell: Tell) -> None:
    if opened.show is None:
        tell("--view: only a simulated robot can be viewed")
        return
    try:
        opened.show(speed)
    except CannotDraw as error:
        tell(f"--view: {error}{'; pictures are kept with the run instead' if pictures else ''}")


def _begin_film(opened: OpenedRobot, tell: Tell) -> Film | None:
    if not isinstance(opened.robot, Camera):
        tell("--video: only a simulated robot can be filmed")
        return None
    film = Film(opened.robot)
    try:
        film.follow(opened.robot.read())
    except CannotDraw as error:
        tell(f"--video: {error}")
        return None
    opened.robot.listen(film.follow)
    return film
