"""A bank of simulated readings: full physics once, so that every policy can be tried on the same readings."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dynamics.errors import ActionFailed, InvalidInput, MotionRefused, PalpateError
from dynamics.objects import DeclaredObject, read_declared
from dynamics.robot import Robot
from estimation.measurement import Measurement
from estimation.size import SizeEstimate
from selection.trials.specimens import Specimen, on_disk
from selection.trials.sweep import Arrays, Machines, Progress, Store, sweep

log = logging.getLogger(__name__)

ATTEMPTS = 3
"""Times that an action through the emulator is begun before its robot's error counts."""


@dataclass(frozen=True)
class BankJob:
    """One action on one object, by a robot of its own.

    Attributes:
        specimen: the object.
        action: name of the action.
        turn: number of the reading.
        seed: of the bank.
        robot: ``sim``, or ``emulator`` for the same simulation behind the arm's protocol.
    """

    specimen: Specimen
    action: str
    turn: int
    seed: int
    robot: str = "sim"

    @property
    def name(self) -> str:
        """What tells it from every other reading."""
        kind = "bank" if self.robot == "sim" else self.robot
        return f"{kind}-{self.specimen.name}-{self.action}-{self.turn}"


@dataclass(frozen=True)
class Reading:
    """What an action brought.

    Attributes:
        measurements: none where it failed, or told nothing.
        edge: which edge of the object a measured width is.
        seconds: robot time [s].
        failure: why it failed, or an empty text.
    """

    measurements: tuple[Measurement, ...]
    edge: int
    seconds: float
    failure: str = ""


Bank = dict[tuple[str, str], tuple[Reading, ...]]
"""Readings by name of the object and of the action."""


def values_of(bank: Bank, specimen: str, action: str, quantity: str) -> np.ndarray:
    """Return what an action read of a quantity of an object, shape (readings,).

    Raises:
        InvalidInput: if it never read it.
    """
    readings = bank[specimen, action]
    values = [m.mean for reading in readings for m in reading.measurements if m.property == quantity]
    if not values:
        failures = [reading.failure for reading in readings]
        raise InvalidInput(f"readings of {specimen} by {action}", failures, f"at least one of {quantity}")
    return np.array(values)


def run_job(job: BankJob) -> Arrays:
    """Do one action on a robot of its own, and measure."""
    from selection.robots import RobotRequest, open_robot

    seed = int(np.random.SeedSequence([job.seed, 5, *job.name.encode()]).generate_state(1)[0])
    with on_disk(job.specimen) as path:
        declared = read_declared(path)
        if job.robot == "emulator":
            return _arrays(_emulated(path, declared, job.action, seed))
        robot = open_robot(job.robot, RobotRequest(path, seed=seed)).robot
        try:
            return _arrays(_read(robot, declared, job.action))
        finally:
            robot.close()


def _emulated(path: Path, declared: DeclaredObject, action: str, seed: int) -> Reading:
    """Read through the emulator, again where the arm stopped: on a busy machine its clock may outrun it."""
    from selection.trials.emulated import emulated_robot

    for attempt in range(ATTEMPTS):
        try:
            with emulated_robot(path, seed + attempt) as opened:
                return _read(opened.robot, declared, action)
        except InvalidInput:
            raise
        except PalpateError as error:
            if attempt == ATTEMPTS - 1:
                raise
            log.warning("%s of %s: %s; once more", action, declared.name, error)
    raise AssertionError("unreachable")


def _read(robot: Robot, declared: DeclaredObject, name: str) -> Reading:
    from selection.actions import ACTIONS, Readings
    from selection.actions.hand import Hand
    from selection.tape import Tape

    action = next(action for action in ACTIONS if action.name == name)
    tape = Tape(robot)
    hand = Hand(robot, declared, tape)
    start, failure = robot.read().time, ""
    measurements: tuple[Measurement, ...] = ()
    try:
        action.perform(hand)
        readings = Readings(robot, tape.take(), declared.shape, SizeEstimate.declared(declared), hand.edge)
        measurements = action.measure(readings).measurements
    except (ActionFailed, MotionRefused, InvalidInput) as error:
        failure = str(error)
    return Reading(measurements, hand.edge, robot.read().time - start, failure)


def simulated_bank(
    specimens: Sequence[Specimen],
    actions: Sequence[str],
    turns: int,
    seed: int,
    store: Store | None = None,
    machines: Machines | None = None,
    progress: Progress | None = None,
    robot: str = "sim",
) -> Bank:
    """Simulate readings that are not in the store yet, and return all.

    Args:
        specimens: the objects.
        actions: names of the actions.
        turns: readings of every action on every object.
        seed: of the bank.
        store, machines, progress: as for `sweep`.
        robot: as for `BankJob`.
    """
    jobs = [
        BankJob(specimen, action, turn, seed, robot)
        for turn in range(turns)
        for specimen in specimens
        for action in actions
    ]
    found: dict[tuple[str, str], list[Reading]] = {}
    results = sweep(f"readings by the {robot}", run_job, jobs, store, machines, progress)
    for job, arrays in zip(jobs, results, strict=True):
        found.setdefault((job.specimen.name, job.action), []).append(_reading(arrays))
    return {key: tuple(readings) for key, readings in found.items()}


def _arrays(reading: Reading) -> Arrays:
    return {
        "property": np.array([m.property for m in reading.measurements], dtype="U32"),
        "unit": np.array([m.unit for m in reading.measurements], dtype="U32"),
        "mean": np.array([m.mean for m in reading.measurements]),
        "sd": np.array([m.sd for m in reading.measurements]),
        "edge": np.array(reading.edge),
        "seconds": np.array(reading.seconds),
        "failure": np.array(reading.failure),
    }


def _reading(arrays: Arrays) -> Reading:
    rows = zip(*(arrays[key].tolist() for key in ("property", "mean", "sd", "unit")), strict=True)
    measurements = tuple(Measurement(name, mean, sd, unit) for name, mean, sd, unit in rows)
    return Reading(measurements, int(arrays["edge"]), float(arrays["seconds"]), str(arrays["failure"]))
