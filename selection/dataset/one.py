"""One object of a dataset: drawn, explored and kept, under a temporary name until all of it is on disk."""

from __future__ import annotations

import json
import os
import shutil
import socket
import tempfile
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import cast

import numpy as np

from dynamics.errors import InvalidInput, PalpateError
from dynamics.objects import DeclaredObject, read_declared
from dynamics.robot import Robot, SampleSink
from dynamics.signals import Sample
from estimation.network import Network
from estimation.recording import CannotRecord, RunWriter
from estimation.recording.files import sync_folder, to_toml, write_atomically
from estimation.recording.timeless import forget_wall_clock
from selection.actions import ACTIONS, Action
from selection.actions.hand import Hand
from selection.arguments import parser, robot_request
from selection.configuration import configuration
from selection.dataset.random_objects import RandomObject, Ranges, Sampler
from selection.exploration import Exploration, Settings, Watcher
from selection.result import result_of
from selection.robots import OpenedRobot, RobotRequest, open_robot, simulated_at_rest
from selection.tape import Tape

OBJECT, FAILURE, RESULT, STREAM = "object.toml", "failure.json", "result.json", "run.mcap"
_SEED_BITS = 52  # so that a robot's seed stays exact wherever it is written


@dataclass(frozen=True)
class Setup:
    """What all objects of a dataset share.

    Attributes:
        seed: of the series.
        reference: name or file of what is known of materials.
        noise: of the simulated sensors, as `selection.run` takes it.
        price, confidence, budget: when an exploration stops, as there.
        poisson: the largest Poisson's ratio drawn [-].
    """

    seed: int = 0
    reference: str = "soft-cubes"
    noise: str = "default"
    price: float = 0.005
    confidence: float = 0.99
    budget: float = float("inf")
    poisson: float = 0.0


@dataclass(frozen=True)
class Job:
    """One object to explore.

    Attributes:
        root: folder of the dataset.
        index: number of the object.
        setup: shared by all.
    """

    root: Path
    index: int
    setup: Setup

    @property
    def folder(self) -> Path:
        """Where it is kept when it is complete."""
        return self.root / "objects" / f"{self.index:06d}"


@dataclass(frozen=True)
class Outcome:
    """How the exploration of an object went.

    Attributes:
        index: number of the object.
        failed: actions that failed, each with its reason.
        error: why there is no result; empty where there is one.
    """

    index: int
    failed: tuple[str, ...]
    error: str


Inspector = Callable[[OpenedRobot, Path], Watcher]


class Ignoring:
    """Watches nothing."""

    def begins(self, belief: object) -> None:
        """Ignore what is believed beforehand."""

    def decides(self, decision: object) -> None:
        """Ignore a decision."""

    def learns(self, step: object) -> None:
        """Ignore a step."""


def explore_object(job: Job, inspect: Inspector | None = None, actions: Sequence[Action] = ACTIONS) -> Outcome:
    """Explore one object and keep it in its folder, which appears when everything in it is on disk.

    What goes wrong in the exploration is part of the data and kept as ``failure.json``; what goes wrong with the
    disk is raised.

    Args:
        job: which object.
        inspect: makes a watcher for a robot that writes what it sees to a folder.
        actions: the repertoire.

    Raises:
        CannotRecord: if the disk does not take it.
    """
    temporary = job.folder.with_name(f".{job.index:06d}.{socket.gethostname()}-{os.getpid()}")
    shutil.rmtree(temporary, ignore_errors=True)
    try:
        error = _explored(job, temporary, inspect, actions)
        sync_folder(temporary)
        try:
            os.rename(temporary, job.folder)
        except OSError:
            if not job.folder.exists():
                raise
            shutil.rmtree(temporary)  # another process has been faster; equal seeds give equal data
        sync_folder(job.folder.parent)
    except OSError as problem:
        raise CannotRecord(f"{job.folder}: {problem.strerror or problem}") from problem
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
    return Outcome(job.index, failed_actions(job.folder), error)


def failed_actions(folder: Path) -> tuple[str, ...]:
    """Return the actions that failed in a complete exploration, each with its reason."""
    path = folder / RESULT
    if not path.exists():
        return ()
    done = json.loads(path.read_text(encoding="utf-8"))["actions"]
    return tuple(f"{one['action']}: {'; '.join(one['notes'])}" for one in done if not one["ok"])


def draw(setup: Setup, index: int) -> tuple[RandomObject, int]:
    """Return an object, and the seed of the robot that explores it."""
    sampler, reaches = _sampler(setup.reference, setup.poisson)
    drawn = sampler.draw(setup.seed, index, reaches)
    state = np.random.SeedSequence(setup.seed, spawn_key=(index, 1)).generate_state(1, np.uint64)
    return drawn, int(state[0] >> np.uint64(64 - _SEED_BITS))


def check_setup(setup: Setup) -> None:
    """Refuse what no object could be explored with, before anything is written.

    Raises:
        InvalidInput: for a reference or sensors that cannot be used.
    """
    drawn, seed = draw(setup, 0)
    with tempfile.TemporaryDirectory(prefix="palpate-") as place:
        source = Path(place) / OBJECT
        source.write_text(to_toml("object", drawn.tables("")), encoding="utf-8")
        opened = open_robot("sim", RobotRequest(source, setup.noise, seed))
        Exploration(opened.robot, read_declared(source), _network(setup.reference), None, Settings(), Ignoring())
        opened.robot.close()


def keep_failure(folder: Path, kind: str, message: str, details: str = "") -> None:
    """Keep why an exploration has no result."""
    content = {"kind": kind, "message": " ".join(message.split()), "traceback": details}
    write_atomically(folder / FAILURE, json.dumps(content, indent=2) + "\n")


def _explored(job: Job, folder: Path, inspect: Inspector | None, actions: Sequence[Action]) -> str:
    """Explore into a folder; return why there is no result, or nothing."""
    folder.mkdir(parents=True)
    text, error = "", ""
    with tempfile.TemporaryDirectory(prefix="palpate-") as place:
        source = Path(place) / OBJECT
        try:
            drawn, seed = draw(job.setup, job.index)
            text = to_toml("object", drawn.tables(f"Object {job.index} of the series with seed {job.setup.seed}."))
            source.write_text(text, encoding="utf-8")
            _explore(job.setup, source, seed, folder, inspect, actions)
        except (CannotRecord, OSError, MemoryError):
            raise
        except Exception as problem:
            message = str(problem).replace(f"{place}/", "")
            details = "" if isinstance(problem, PalpateError) else traceback.format_exc(limit=-8)
            keep_failure(folder, type(problem).__name__, message, details)
            error = f"{type(problem).__name__}: {message}"
    write_atomically(folder / OBJECT, text)
    if (folder / STREAM).exists():
        forget_wall_clock(folder / STREAM)
    return error


def _explore(
    setup: Setup, source: Path, seed: int, folder: Path, inspect: Inspector | None, actions: Sequence[Action]
) -> None:
    """Explore the object of a file as `selection.run` does."""
    asked = ["--object", str(source), "--reference", setup.reference, "--noise", setup.noise]
    given = parser().parse_args([*asked, "--seed", str(seed)])
    given.price, given.confidence, given.budget = setup.price, setup.confidence, setup.budget
    declared = read_declared(source)
    opened = open_robot("sim", robot_request(given, source))
    settings = Settings("material", setup.price, setup.confidence, setup.budget)
    watcher = Ignoring() if inspect is None else inspect(opened, folder)
    network = _network(setup.reference)
    exploration = Exploration(opened.robot, declared, network, None, settings, watcher, actions)
    config = configuration(given, source, opened.robot) | {"object": OBJECT}
    with RunWriter.create(folder, config, declared.name, opened.robot.arm.joint_names) as run:
        exploration.record(run)
        exploration.explore()
        run.finish(result_of(exploration, declared.name, opened.truth))
    opened.robot.close()


class _AtRest:
    """A robot that only stands there: what planning a grasp needs to know."""

    def __init__(self) -> None:
        self.arm, self.gripper, self._sample = simulated_at_rest()

    def listen(self, sink: SampleSink) -> None:
        """Never say anything."""

    def read(self) -> Sample:
        """Return the start."""
        return self._sample


@lru_cache(maxsize=4)
def _network(reference: str) -> Network:
    return Network.from_file(reference)


@lru_cache(maxsize=4)
def _sampler(reference: str, poisson: float) -> tuple[Sampler, Callable[[DeclaredObject], bool]]:
    robot = cast(Robot, _AtRest())

    def reaches(declared: DeclaredObject) -> bool:
        try:
            Hand(robot, declared, Tape(robot))
        except InvalidInput:
            return False
        return True

    return Sampler(_network(reference), Ranges(poisson=(0.0, poisson))), reaches
