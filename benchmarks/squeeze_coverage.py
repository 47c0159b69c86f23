"""Are intervals of moduli honest, and how narrow? Squeezes simulated once, their sensors drawn many times over.

    ratio     median of estimated over true modulus
    rms       root mean square of ln(estimate / truth)
    sd        median of the stated relative standard deviation
    reading   median of the part of it that is not common calibration
    coverage  share of 95 % intervals with the truth in them; a bound counts if the truth is over it

``python -m benchmarks.squeeze_coverage [--draws N] [--moduli PA ...] [--mass KG] [--json]``
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import math
import sys
from typing import Any

import numpy as np

from benchmarks.stiffness_in_simulation import OBJECT
from dynamics.errors import PalpateError
from dynamics.gripper import ParallelGripper
from dynamics.signals import Phase
from estimation.squeezing import measure_squeeze
from selection.actions import Squeeze
from selection.actions.hand import Hand
from selection.tape import Tape
from sim.robot import MujocoRobot
from sim.sensors import SensorModel, Sensors
from sim.truth import read_truth

MOVING = ("air", "grasp", "compress", "release", "probe")  # phases in which the gripper moves
PERIOD = 0.01  # s


class Told:
    """A robot whose gripper is described otherwise: it squeezes as one with coarse readings would."""

    def __init__(self, robot: MujocoRobot, gripper: ParallelGripper) -> None:
        self._robot, self.gripper = robot, gripper

    def __getattr__(self, name: str) -> Any:
        return getattr(self._robot, name)


def read_with(phases: tuple[Phase, ...], model: SensorModel, seed: int, newtons_per_ampere: float) -> list[Phase]:
    """Return the phases as sensors of a seed would have reported them."""
    sensors = Sensors(model, np.random.default_rng(seed), len(phases[0].samples[0].q), PERIOD)
    swallowed = model.grip_friction / newtons_per_ampere
    read = []
    for phase in phases:
        samples = []
        for true in phase.samples:
            current = max(true.effort - swallowed, 0.0) if phase.name in MOVING else None
            samples.append(sensors.sample(true.time, true.q, true.dq, true.tau, true.opening, current))
        read.append(dataclasses.replace(phase, samples=tuple(samples)))
    return read


def row(modulus: float, mass: float, draws: int) -> dict[str, float]:
    """Return the figures of one modulus."""
    model = SensorModel()
    truth = dataclasses.replace(read_truth(OBJECT), young_modulus=modulus, mass=mass)
    gripper = MujocoRobot(truth, model).gripper
    robot = Told(MujocoRobot(truth, SensorModel.none()), gripper)
    tape = Tape(robot)  # type: ignore[arg-type]
    Squeeze().perform(Hand(robot, truth.declared, tape))  # type: ignore[arg-type]
    phases = tape.take()
    found, inside = [], 0
    for seed in range(draws):
        drawn = read_with(phases, model, seed, gripper.force_per_ampere)
        try:
            estimate, _ = measure_squeeze(gripper, "box", truth.size, drawn, poisson=0.0)
        except PalpateError:
            continue
        inside += estimate.interval[0] <= modulus <= estimate.interval[1]
        found.append((estimate.young_modulus, estimate.sd, estimate.reading_sd))
    table = np.array(found).reshape(-1, 3)
    table = table[np.isfinite(table).all(axis=1)]
    if not len(table):
        table = np.full((1, 3), math.nan)
    return {
        "young_modulus": modulus,
        "answers": len(found),
        "moduli": int(np.isfinite(table[:, 0]).sum()),
        "ratio": float(np.median(table[:, 0])) / modulus,
        "rms": math.sqrt(float(np.mean(np.log(table[:, 0] / modulus) ** 2))),
        "sd": float(np.median(table[:, 1] / table[:, 0])),
        "reading": float(np.median(table[:, 2] / table[:, 0])),
        "coverage": inside / max(len(found), 1),
    }


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.squeeze_coverage")
    parser.add_argument("--draws", type=int, default=64)
    parser.add_argument("--moduli", type=float, nargs="+", default=[5e4, 3e5, 1e6])
    parser.add_argument("--mass", type=float, default=0.1)
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args(arguments)
    rows = [row(modulus, given.mass, given.draws) for modulus in given.moduli]
    if given.json:
        json.dump(rows, sys.stdout, indent=2)
        return 0
    for one in rows:
        print(
            f"{one['young_modulus']:9.0f} Pa  {one['moduli']} moduli of {one['answers']}  "
            f"ratio {one['ratio']:.3f}  "
            f"rms {one['rms']:.3f}  sd {one['sd']:.3f}  "
            f"reading {one['reading']:.3f}  coverage {one['coverage']:.3f}"
        )
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
