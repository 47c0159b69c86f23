"""Dry runs: the next action planned and checked in thought; nothing moves, nothing is written."""

import re

import numpy as np
import pytest

from dynamics.arm import Arm
from dynamics.errors import MotionRefused
from dynamics.gripper import robotiq_2f85
from dynamics.objects import read_declared
from dynamics.robot import GripResult
from dynamics.signals import Sample
from dynamics.trajectory import Trajectory
from estimation.recording import read_recording
from models import objects
from selection import robots
from selection.actions import ACTIONS
from selection.run import main
from selection.stand_in import StandIn

PLACE = re.compile(r"arm +tool to \((.*?), (.*?), (.*?)\) m")


@pytest.fixture
def stand_in():
    arm = Arm.gen3()
    start = Sample(3.0, np.radians([0.0, 15, 180, -130, 0, 55, 90]), np.zeros(7), np.zeros(7), 0.085, 0.0)

    class Standing:
        def read(self):
            return start

    robot = Standing()
    robot.arm, robot.gripper = arm, robotiq_2f85()
    return StandIn(robot, read_declared(objects.locate("soft-cube")))


def places(text):
    return np.array([[float(x) for x in found] for found in PLACE.findall(text)])


def test_the_plan_is_what_a_run_does(capsys, default_run, tmp_path, monkeypatch):
    """Every place where the tool would be is one where it came by in a simulated run, in the same order."""
    monkeypatch.chdir(tmp_path)
    assert main(["--dry-run", "--out", str(tmp_path / "out")]) == 0
    shown = capsys.readouterr().out
    planned = places(shown)
    assert len(planned) > 15
    assert not list(tmp_path.iterdir())
    recording = read_recording(default_run)
    arm = Arm.gen3()
    reached = np.array([arm.tool_pose(q)[:3, 3] for q in recording.samples.q[::5]])
    at = 0
    for place in planned[: len(planned) * 2 // 3]:  # up to where the run may have known enough
        away = np.linalg.norm(reached[at:] - place, axis=1)
        near = np.flatnonzero(away < 0.004)
        assert len(near), place
        at += int(near[0])
    assert "weigh tare" in shown
    assert "weigh hold" in shown
    assert "nothing moved" in shown


def test_squeezing_is_planned_as_well(capsys):
    assert main(["--dry-run", "--price", "0.05"]) == 0
    shown = capsys.readouterr().out
    assert "possible  squeeze" in shown
    assert shown.count("squeeze compress") >= 3


def test_what_comes_next_in_an_interrupted_run(capsys, default_run, tmp_path):
    import shutil

    copy = tmp_path / "run"
    shutil.copytree(default_run, copy)
    before = sorted(path.name for path in copy.rglob("*"))
    assert main(["--dry-run", "--resume", str(copy)]) == 0
    assert "stop " in capsys.readouterr().out  # both actions are done
    assert sorted(path.name for path in copy.rglob("*")) == before


def test_a_refused_motion_leads_to_the_next_choice(capsys, monkeypatch):
    opened = robots.ROBOTS["sim"]
    refusals = iter(range(100))

    def refuse_once(trajectory: Trajectory) -> None:
        if next(refusals) == 0:
            raise MotionRefused("not with me")

    def judging(request, judge):
        found = opened(request)
        return robots.OpenedRobot(found.robot, found.truth, judge)

    monkeypatch.setitem(robots.ROBOTS, "sim", lambda request: judging(request, refuse_once))
    assert main(["--dry-run"]) == 0
    shown = capsys.readouterr().out
    assert "cannot    weigh: not with me" in shown
    assert "possible  squeeze" in shown

    def refuse(trajectory: Trajectory) -> None:
        raise MotionRefused("never")

    monkeypatch.setitem(robots.ROBOTS, "sim", lambda request: judging(request, refuse))
    assert main(["--dry-run"]) == 1
    assert capsys.readouterr().out.count("cannot") == len(ACTIONS)


def test_the_stand_in_keeps_to_the_limits(stand_in):
    q = stand_in.read().q
    time = np.linspace(0, 1, 50)

    def to(change, seconds=1.0):
        return Trajectory(seconds * time, q + time[:, None] * np.asarray(change))

    for trajectory, words in (
        (Trajectory(time, to(np.zeros(7)).q + 0.1), "does not start"),
        (to([0, 3.0, 0, 0, 0, 0, 0], 10.0), "limits"),
        (to([1.0, 0, 0, 0, 0, 0, 0], 0.1), "faster"),
    ):
        with pytest.raises(MotionRefused, match=words):
            stand_in.follow(trajectory)
        assert stand_in.read().q is q
    heard = []
    stand_in.listen(heard.append)
    stand_in.follow(to([0.1] * 7))
    np.testing.assert_allclose(stand_in.read().q, q + 0.1)
    assert len(heard) == 100
    np.testing.assert_allclose(heard[50].dq, 0.1, rtol=0.1)
    assert heard[-1].time == pytest.approx(4.0)


def test_the_stand_in_grips_what_is_declared(stand_in):
    assert stand_in.grip(0.06, 0.05, 0.3) is GripResult.REACHED
    assert stand_in.read().effort == 0
    assert stand_in.grip(0.02, 0.05, 0.3) is GripResult.STALLED
    assert stand_in.read().opening == pytest.approx(0.9 * 0.056)
    assert stand_in.grip(0.085, 0.15, np.inf) is GripResult.REACHED
    assert [move.kind for move in stand_in.moves] == ["gripper"] * 3
