"""Pictures of a run: taken at its moments if the robot has cameras, left out in one line if it cannot draw."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from dynamics.robot import Camera, CannotDraw
from dynamics.signals import Sample
from selection.film import MOST_FRAMES, PERIOD, Film
from selection.pictures import HEIGHT, MOMENTS, WIDTH, Pictures
from selection.robots import OpenedRobot
from selection.run import main
from selection.sights import Sights

ROOT = Path(__file__).parents[2]


class Painter:
    """A robot with two cameras that count their pictures."""

    def __init__(self, cameras=("overview", "close")):
        self.cameras, self.taken, self.heard = cameras, [], []

    def picture(self, camera="overview", width=1080, height=720):
        self.taken.append(camera)
        return np.full((height, width, 3), 37 * len(self.taken) % 256, np.uint8)

    def listen(self, sink):
        self.heard.append(sink)

    def read(self):
        return sample(0.0)


class Blind(Painter):
    """A robot with cameras, on a machine that cannot draw."""

    def picture(self, camera="overview", width=1080, height=720):
        raise CannotDraw("no picture without OpenGL")


class Step:
    def __init__(self, action, ok):
        self.action, self.ok = action, ok


def sample(time):
    return Sample(time, np.zeros(7), np.zeros(7), np.zeros(7), 0.0, 0.0)


def act(pictures, action, phases, ok=True):
    pictures.decides(None)
    for phase in phases:
        pictures.phase(action, phase)
    pictures.learns(Step(action, ok))


def test_the_moments_of_a_run_are_kept_in_order(tmp_path):
    painter, told = Painter(("overview", "close", "wrist")), []
    assert isinstance(painter, Camera)
    pictures = Pictures(painter, told.append)
    pictures.keep_in(tmp_path)
    pictures.begins(None)
    act(pictures, "squeeze", ["air", "release", "compress", "dwell", "release", "compress", "dwell", "release"])
    act(pictures, "weigh", ["tare", "hold", "hold"], ok=False)
    kept = sorted(path.name for path in (tmp_path / "pictures").iterdir())
    assert kept == [
        "00-begin-overview.png",
        "01-begin-close.png",
        "02-squeeze-tightest-close.png",
        "03-squeeze-tightest-wrist.png",
        "04-squeeze-done-overview.png",
        "05-squeeze-done-close.png",
        "06-weigh-held-overview.png",
        "07-weigh-held-wrist.png",
        "08-weigh-failed-overview.png",
        "09-weigh-failed-close.png",
    ]
    with Image.open(tmp_path / "pictures" / kept[3]) as one:
        assert one.size == (WIDTH, HEIGHT)
    assert told == []


def test_a_resumed_run_keeps_its_first_pictures(tmp_path):
    for _ in range(2):
        pictures = Pictures(Painter(("overview",)), print)
        pictures.keep_in(tmp_path)
        pictures.begins(None)
    kept = sorted(path.name for path in (tmp_path / "pictures").iterdir())
    assert kept == ["00-begin-overview.png", "01-begin-overview.png"]


def test_where_nothing_can_be_drawn_it_is_said_once(tmp_path):
    told = []
    pictures = Pictures(Blind(), told.append)
    pictures.keep_in(tmp_path)
    pictures.begins(None)
    act(pictures, "weigh", ["hold"])
    assert told == ["no picture without OpenGL"]
    assert not (tmp_path / "pictures").exists()


def test_a_robot_without_cameras_has_no_pictures(tmp_path):
    told = []
    pictures = Pictures(object(), told.append)
    pictures.keep_in(tmp_path)
    pictures.begins(None)
    assert told == []
    assert list(tmp_path.iterdir()) == []


def test_every_moment_is_one_of_a_known_action():
    assert {action for action, _, _ in MOMENTS} <= {"weigh", "squeeze", "rub", "observe"}


@pytest.mark.parametrize("name", ["film.webp", "film.gif", "film.png"])
def test_a_film_has_a_frame_for_every_half_second(tmp_path, name):
    film = Film(Painter())
    for tick in range(400):
        film.follow(sample(tick / 100))
    film.save(tmp_path / name)
    with Image.open(tmp_path / name) as kept:
        assert kept.n_frames == 4 / PERIOD
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_a_long_film_stays_small():
    painter = Painter()
    painter.picture = lambda *_: np.zeros((1, 1, 3), np.uint8)
    film = Film(painter)
    for tick in range(3 * MOST_FRAMES):
        film.follow(sample(tick * PERIOD))
    assert MOST_FRAMES / 2 < len(film._frames) <= MOST_FRAMES


def test_what_cannot_be_shown_is_said_in_a_line_each(tmp_path):
    def no_display(speed):
        raise CannotDraw("no display to open the viewer on")

    for robot, show, lines in (
        (Blind(), no_display, ["--view: no display", "--video: no picture"]),
        (object(), None, ["--view: only a simulated", "--video: only a simulated"]),
    ):
        told = []
        sights = Sights(OpenedRobot(robot, None, show=show), 1.0, False, tmp_path / "film.webp", told.append)
        sights.close()
        assert len(told) == 2
        assert all(line.startswith(start) for line, start in zip(told, lines, strict=True))
    assert not (tmp_path / "film.webp").exists()


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["--view", "0"], "speed"),
        (["--view", "fast"], "number"),
        (["--video", "film.avi"], ".webp"),
        (["--video", "nowhere/film.gif"], "folder"),
    ],
)
def test_wrong_arguments(capsys, arguments, named):
    with pytest.raises(SystemExit) as stopped:
        main(arguments)
    assert stopped.value.code == 2
    assert named in capsys.readouterr().err


def test_a_run_without_opengl_and_display_goes_on(tmp_path):
    out = tmp_path / "run"
    environment = {key: value for key, value in os.environ.items() if "DISPLAY" not in key}
    environment |= {"MUJOCO_GL": "disabled", "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}
    command = [
        sys.executable,
        "-m",
        "selection.run",
        "--out",
        str(out),
        "--noise",
        "none",
        "--budget",
        "0",
        "--view",
    ]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, env=environment, check=True)
    lines = done.stderr.splitlines()
    assert [line[:10] for line in lines] == ["--view: no", "no picture"]
    assert not (out / "pictures").exists()
    assert (out / "result.json").exists()
