"""Looking and listening: where the camera goes, what it changes in the belief, and that runs keep it."""

import dataclasses
import json

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from dynamics.objects import read_declared
from estimation.network import Network
from estimation.recording import RunWriter, read_recording
from estimation.reestimation.batch import Request
from estimation.reestimation.report import changes, report_of
from models import objects
from selection.actions import Observe, Sound, repertoire
from selection.actions.hand import Hand
from selection.actions.observe import viewing_poses
from selection.display import Silent
from selection.exploration import Exploration, Settings
from selection.eyes import drawn_senses
from selection.robots import RobotRequest, open_robot
from selection.run import main
from selection.tape import Tape
from sim.robot import MujocoRobot
from sim.sensors import SensorModel
from sim.truth import read_truth

FILE = objects.FOLDER / "foam-block.toml"
DECLARED, TRUTH = read_declared(FILE), read_truth(FILE)
NETWORK = Network.from_file("household")
SENSES = drawn_senses(NETWORK, {"category": "block", "material": "foam"}, seed=1)


def exploration(robot, actions, confidence=0.99):
    return Exploration(robot, DECLARED, NETWORK, None, Settings(confidence=confidence), Silent(), actions)


@pytest.mark.parametrize(("position", "yaw"), [((0.5, 0.0), 0.0), ((0.45, -0.25), 40.0)])
def test_the_camera_sees_the_object(position, yaw):
    declared = dataclasses.replace(DECLARED, position=position, yaw=np.radians(yaw))
    robot = MujocoRobot(dataclasses.replace(TRUTH, declared=declared), SensorModel.none())
    hand = Hand(robot, declared, Tape(robot))
    (q,) = hand.plan_through(viewing_poses(hand), 1)
    # The camera by another way: its place in the bracelet, as the maker gives it from the flange.
    model, data = robot.arm.model, robot.arm.model.createData()
    pin.framesForwardKinematics(model, data, robot.arm.configuration(q))
    bracelet = data.oMf[model.getFrameId("bracelet_link")]
    eye = bracelet.act(np.array([0.0, -0.05639, -0.061525 + 0.00305]))
    ray = bracelet.rotation @ [0.0, 0.0, -1.0]
    top = np.array([*position, DECLARED.size[2]])
    assert ray == pytest.approx([0, 0, -1], abs=1e-6)
    assert np.degrees(np.arctan2(np.hypot(*(top - eye)[:2]), eye[2] - top[2])) < 15  # of a field of some 25
    assert 0.2 < eye[2] - top[2] < 0.4
    # and nothing of arm and gripper stands before the corners of its top
    hand.gate()
    hand.go(q)
    hand.settle()
    c, s = np.cos(declared.yaw), np.sin(declared.yaw)
    start = eye + 0.03 * ray  # outside of the vision module
    for along, across in ((0.0, 0.0), (0.025, 0.025), (0.025, -0.025), (-0.025, 0.025), (-0.025, -0.025)):
        corner = top + np.array([c * along - s * across, s * along + c * across, 0.0])
        way = np.linalg.norm(corner - start)
        hit = np.zeros(1, np.int32)
        free = mujoco.mj_ray(robot._model, robot._data, start, (corner - start) / way, None, 1, -1, hit)
        assert free < 0 or free > 0.95 * way, (along, across, free, way)


def test_a_look_teaches_the_category_and_through_it_the_material():
    robot = MujocoRobot(TRUTH, SensorModel.none())
    explored = exploration(robot, (Observe(SENSES["observe"]),))
    before = explored.belief
    explored.explore()
    (step,) = explored.steps
    (seen,) = step.observations
    assert (step.action, step.ok, step.measurements) == ("observe", True, ())
    assert seen == SENSES["observe"].perceive()
    rise = explored.belief.probabilities("category")[seen.best] / before.probabilities("category")[seen.best]
    assert rise > 5
    expected = before.update_class("category", seen.by_class).probabilities("material")
    assert explored.belief.probabilities("material") == pytest.approx(expected)
    assert explored.stopped_because == "all actions used up"


def test_looks_and_sounds_are_kept_and_taken_up_again(tmp_path):
    config = {"reference": "household", "object": "foam-block", "object_file": FILE.read_text()}
    actions = tuple(action for action in repertoire(SENSES) if isinstance(action, Observe | Sound))
    robot = MujocoRobot(TRUTH, SensorModel.none())
    first = exploration(robot, actions)
    run = RunWriter.create(tmp_path / "run", config, "foam-block", robot.arm.joint_names)
    with run:  # no result: as if it had been interrupted
        first.record(run)
        first.explore()
    assert sorted(step.action for step in first.steps) == ["observe", "sound"]
    past = read_recording(tmp_path / "run")
    assert [one.action for one in past.observations] == [step.action for step in first.steps]
    assert tuple(one.observation for one in past.observations) == tuple(
        seen for step in first.steps for seen in step.observations
    )
    again = exploration(MujocoRobot(TRUTH, SensorModel.none()), actions)
    again.recall(past)
    assert again.belief.to_json() == first.belief.to_json()
    again.explore()
    assert again.steps == []
    report = report_of(tmp_path / "run", Request())
    assert changes(report) == 0, report
    files = sorted(path.name for path in (tmp_path / "run" / "measurements").glob("*.json"))
    assert files == ["001-category.json", "002-material.json"] or files == [
        "001-material.json",
        "002-category.json",
    ]
    (tmp_path / "run" / "measurements" / files[0]).unlink()
    RunWriter.resume(tmp_path / "run").close()
    restored = json.loads((tmp_path / "run" / "measurements" / files[0]).read_text())
    assert restored[0]["measurements"][0]["value"]["likelihoods"] == first.steps[0].observations[0].by_class


def test_looking_ahead_is_an_option_where_the_budget_does_not_hold_all_actions():
    robot = MujocoRobot(TRUTH, SensorModel.none())
    horizons = {}
    for lookahead in (False, True):
        settings = Settings(budget=30.0, lookahead=lookahead)
        explored = Exploration(robot, DECLARED, NETWORK, None, settings, Silent(), repertoire(SENSES))
        horizons[lookahead] = next(iter_decisions(explored)).horizon
    assert horizons == {False: 1, True: 2}


def iter_decisions(explored):
    """Yield what the exploration would decide now."""
    told = []
    explored._watcher.decides = told.append
    explored._decide()
    yield from told


def test_the_truth_reaches_the_exploration_through_the_confusion_matrix_alone():
    opened = open_robot("sim", RobotRequest(FILE, noise="none", seed=7))
    senses = opened.senses(NETWORK)
    assert opened.truth is not None
    assert opened.truth.category == "block"
    likely = {tuple(NETWORK.sensor("observe").likelihoods(o).items()) for o in NETWORK.sensor("observe").outcomes}
    assert senses["observe"].perceive().likelihoods in likely
    opened.robot.close()


def test_wrong_files_end_the_command_before_anything_is_written(tmp_path, capsys):
    path = tmp_path / "seen.json"
    path.write_text('{"format": "palpate-vision/1", "likelihoods": {"mug": -1}}')
    common = ["--reference", "household", "--out", str(tmp_path / "run"), "--vision"]
    assert main([*common, str(path)]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert main([*common, str(tmp_path / "none.json")]) == 2
    impossible = {"mug": 1.0} | {name: 0.0 for name in NETWORK.categories if name != "mug"}
    path.write_text(json.dumps({"format": "palpate-vision/1", "likelihoods": impossible}))
    # A mug is never of foam: with that prior nothing that is possible could look so.
    assert main([*common, str(path), "--prior", "foam=1,unknown=0"]) == 2
    assert "possible" in capsys.readouterr().err
    assert not (tmp_path / "run").exists()
