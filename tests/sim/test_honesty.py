"""The truth about a simulated object reaches only the simulator and the final comparison."""

import ast
import dataclasses
import importlib.util
import inspect
import shutil
import subprocess
import sys
from enum import Enum
from pathlib import Path

import mujoco
import numpy as np
import pytest

import estimation
import selection
from dynamics.objects import read_declared
from dynamics.robot import Robot
from models import objects
from selection.robots import RobotRequest, open_robot
from sim.robot import MujocoRobot
from sim.sensors import SensorModel, Sensors
from sim.truth import TrueObject, read_truth
from tests.sim.objects import block

SECRET = (TrueObject, mujoco.MjModel, mujoco.MjData, mujoco.MjSpec, Sensors, SensorModel, np.random.Generator)
LEAVES = (str, bytes, int, float, complex, bool, type(None), type, Enum, np.generic)


def reachable(start):
    """Yield everything that public attributes, fields and elements lead to, with the way there."""
    seen, waiting = {}, [("robot", start)]
    while waiting:
        way, thing = waiting.pop()
        if id(thing) in seen:
            continue
        seen[id(thing)] = thing  # kept, so that no id is given twice
        yield way, thing
        if isinstance(thing, LEAVES) or inspect.ismodule(thing) or inspect.isroutine(thing):
            continue
        if isinstance(thing, np.ndarray):
            if thing.base is not None:  # a view leads to what it shares
                waiting.append((f"{way}.base", thing.base))
            continue
        if isinstance(thing, dict):
            waiting += [(f"{way}[{key!r}]", value) for key, value in thing.items()]
        elif isinstance(thing, list | tuple | set | frozenset):
            waiting += [(f"{way}[{i}]", value) for i, value in enumerate(thing)]
        if type(thing).__module__.partition(".")[0] in ("pinocchio", "coal"):
            continue  # the arm's description, made without the object; see below
        for name in dir(thing):
            if not name.startswith("_"):
                waiting.append((f"{way}.{name}", getattr(thing, name)))


@pytest.fixture
def robot():
    robot = MujocoRobot(block(3.21e4, 0.123, friction=0.654), SensorModel(), seed=0)
    robot.hold(0.05)
    return robot


def test_public_attributes_do_not_lead_to_the_truth(robot):
    found = list(reachable(robot))
    assert len(found) > 50  # the walk does get somewhere: the arm, the gripper, a sample
    for way, thing in found:
        assert not isinstance(thing, SECRET), way
        assert not (isinstance(thing, float) and thing in (3.21e4, 0.123, 0.654)), way


def test_the_walk_would_find_a_leak(robot):
    robot.notes = {"hidden": [(block(),)]}
    assert any(isinstance(thing, TrueObject) for _, thing in reachable(robot))


def test_nothing_is_public_but_the_protocol_and_pictures(robot):
    promised = {name for name in dir(Robot) if not name.startswith("_")}
    assert {name for name in dir(robot) if not name.startswith("_")} - promised <= {"cameras", "picture", "show"}
    # What a camera sees is for people: nothing that explores or estimates asks for it.
    shows = {"selection/film.py", "selection/pictures.py"}
    asks = set()
    for package, path in sources():
        nodes = ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if any(isinstance(node, ast.Attribute) and node.attr == "picture" for node in nodes):
            asks.add(f"{package}/{path.name}")
    assert asks <= shows


def test_descriptions_and_first_sample_do_not_depend_on_the_object():
    one, other = (MujocoRobot(truth, SensorModel(), seed=0) for truth in (block(5e3, 0.004), block(1e6, 1.0)))
    assert one.gripper == other.gripper
    q = one.read().q
    np.testing.assert_array_equal(one.arm.gravity(q), other.arm.gravity(q))
    np.testing.assert_array_equal(one.arm.mass_matrix(q), other.arm.mass_matrix(q))
    assert len(one.arm.geometry.geometryObjects) == len(other.arm.geometry.geometryObjects)
    # Nothing has touched the object yet, so nothing that is read may tell of it.
    for robot in (one, other):
        robot.hold(0.1)
    for a, b in zip(dataclasses.astuple(one.read()), dataclasses.astuple(other.read()), strict=True):
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-12)  # one solver for all of it: rounding may differ


def test_samples_are_copies(robot):
    before = robot.read()
    kept = before.q.copy()
    before.q[:] = 0.0  # a listener may scribble on what it got; the robot does not care
    robot.hold(0.05)
    assert np.abs(robot.read().q - kept).max() < 1e-3


def test_declared_part_holds_nothing_of_the_truth(tmp_path):
    for name in objects.names():
        path = objects.locate(name)
        truth = read_truth(path)
        declared = dataclasses.asdict(read_declared(path))
        assert set(declared) == {"name", "shape", "size", "size_sd", "position", "yaw", "source", "mesh"}
        text = path.read_text(encoding="utf-8")
        blind = tmp_path / path.name
        for mesh in path.parent.glob("*.stl"):
            shutil.copy(mesh, tmp_path)
        blind.write_text(text.split("[truth]")[0], encoding="utf-8")
        assert dataclasses.replace(read_declared(blind), source=str(path)) == read_declared(path) == truth.declared


def imported(path):
    """Return the modules that a file imports anywhere in it, also by name."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module or ""
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value.startswith("sim."):
            yield node.value


def sources():
    for package in (estimation, selection):
        for folder in package.__path__:
            yield from ((package.__name__, path) for path in sorted(Path(folder).rglob("*.py")))


def test_only_the_registry_of_robots_imports_the_simulator():
    files = list(sources())
    assert len(files) > 20
    guilty = {
        f"{package}/{path.name}"
        for package, path in files
        for module in imported(path)
        if module == "sim" or module.startswith("sim.")
    }
    assert guilty == {"selection/robots.py"}


def test_nobody_reads_the_truth_from_an_object_file():
    # The word stands only where the comparison at the end is written down or shown, and where objects are made.
    compare = {"result.py", "replay.py", "run_page.py", "run_tables.py", "squeeze_display.py"}
    make = {"random_objects.py", "squeeze_arguments.py"}
    users = set()
    for package, path in sources():
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Constant) and node.value == "truth":
                users.add(f"{package}/{path.name}")
    assert users <= {f"selection/{name}" for name in compare | make}


def test_importing_estimation_does_not_load_the_simulator():
    names = [name for name in ("estimation.weighing", "estimation.squeezing") if importlib.util.find_spec(name)]
    assert names
    code = (
        f"import {', '.join(names)}, sys; print([m for m in sys.modules if m.split('.')[0] in ('sim', 'mujoco')])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_a_robot_that_is_opened_by_name_keeps_the_truth_apart():
    opened = open_robot("sim", RobotRequest(objects.locate("soft-cube"), noise="none"))
    truth = read_truth(objects.locate("soft-cube"))
    assert opened.truth.properties["mass"] == truth.mass
    for way, thing in reachable(opened.robot):
        assert thing is not opened.truth, way
        assert not isinstance(thing, SECRET), way
