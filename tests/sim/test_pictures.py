"""What the simulated robot shows of itself; drawing needs OpenGL, so it is tried in a process of its own."""

import os
import subprocess
import sys
from pathlib import Path

import mujoco
import numpy as np
import pytest

from dynamics.errors import UnknownName
from dynamics.robot import Camera, CannotDraw, Robot
from sim import opengl
from sim.robot import MujocoRobot
from tests.sim.objects import block

ROOT = Path(__file__).parents[2]
DRAW = """
from sim.opengl import choose_backend
choose_backend()
import numpy as np
from sim.robot import MujocoRobot
from dynamics.robot import CannotDraw
from tests.sim.objects import block
robot = MujocoRobot(block())
try:
    seen = {name: robot.picture(name, 320, 240) for name in robot.cameras}
except CannotDraw:
    print("cannot draw")
    raise SystemExit
orange = {name: np.mean((p[..., 0] > 150) & (p[..., 2] < 100)) for name, p in seen.items()}
print(seen["close"].shape, *(f"{name} {share:.4f}" for name, share in orange.items()))
robot.close()
"""


@pytest.mark.parametrize("position", [(0.5, 0.0), (-0.1, 0.45)])
def test_the_cameras_look_at_the_object(position):
    robot = MujocoRobot(block(position=position))
    assert isinstance(robot, Robot)
    assert isinstance(robot, Camera)
    assert robot.cameras == ("overview", "close", "wrist")
    model, data = robot._model, robot._data
    middle = np.array([*position, 0.03])
    for name in ("overview", "close"):
        camera = model.camera(name).id
        sight = data.cam_xmat[camera].reshape(3, 3).T @ (middle - data.cam_xpos[camera])
        half = np.tan(np.radians(model.cam_fovy[camera]) / 2)
        assert sight[2] < 0  # before it
        assert np.abs(sight[:2] / sight[2]).max() < half
    wrist = model.camera("wrist").id
    tool = robot.arm.tool_pose(data.qpos[:7])
    assert -data.cam_xmat[wrist].reshape(3, 3)[:, 2] == pytest.approx(tool[:3, 2], abs=1e-6)
    assert MujocoRobot(block(), vision=False).cameras == ("overview", "close")


def test_an_unknown_camera_is_refused():
    with pytest.raises(UnknownName, match="overview"):
        MujocoRobot(block()).picture("rear")


def test_without_opengl_it_says_which_packages(monkeypatch):
    def fail(*_):
        raise mujoco.FatalError("no OpenGL")

    monkeypatch.setattr(mujoco, "Renderer", fail)
    with pytest.raises(CannotDraw, match="libegl1"):
        MujocoRobot(block()).picture()


def test_without_a_display_there_is_no_viewer(monkeypatch):
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    with pytest.raises(CannotDraw, match="display"):
        MujocoRobot(block()).show()


@pytest.mark.parametrize(
    ("environment", "libraries", "chosen"),
    [
        ({}, {"EGL"}, "egl"),
        ({}, {"OSMesa"}, "osmesa"),
        ({}, set(), None),
        ({"DISPLAY": ":0"}, {"EGL"}, None),
        ({"MUJOCO_GL": "glfw"}, {"EGL"}, "glfw"),
    ],
)
def test_the_backend_is_one_that_is_there(monkeypatch, environment, libraries, chosen):
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "MUJOCO_GL"):
        monkeypatch.delenv(name, raising=False)
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr(opengl, "find_library", lambda name: name if name in libraries else None)
    opengl.choose_backend()
    assert os.environ.get("MUJOCO_GL") == chosen
    monkeypatch.delenv("MUJOCO_GL", raising=False)


def test_pictures_show_the_object_where_there_is_opengl():
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}
    done = subprocess.run(
        [sys.executable, "-c", DRAW], capture_output=True, text=True, cwd=ROOT, env=environment, check=True
    )
    if "cannot draw" in done.stdout:
        pytest.skip("no OpenGL here")
    shape, *shares = done.stdout.rsplit(")", 1)
    assert shape == "(240, 320, 3"
    seen = dict(zip(shares[0].split()[::2], map(float, shares[0].split()[1::2]), strict=True))
    assert 0.0005 < seen["overview"] < 0.01
    assert 0.005 < seen["close"] < 0.05


def test_a_second_picture_without_a_display_does_not_end_the_process():
    # MuJoCo itself aborts here, once its window library has failed before.
    script = """
from dynamics.robot import CannotDraw
from models import objects
from sim.robot import MujocoRobot
from sim.truth import read_truth
robot = MujocoRobot(read_truth(objects.locate("soft-cube")))
for _ in range(3):
    try:
        robot.picture()
    except CannotDraw:
        print("cannot")
"""
    hidden = ("DISPLAY", "WAYLAND_DISPLAY", "MUJOCO_GL")
    bare = {name: value for name, value in os.environ.items() if name not in hidden}
    done = subprocess.run([sys.executable, "-c", script], env=bare, capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stdout) == (0, "cannot\n" * 3)
