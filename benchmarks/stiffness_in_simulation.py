"""Stiffness from the signals of the simulated gripper, over moduli and masses, without sensor noise.

    ratio    estimated over true modulus
    mass     largest ratio over smallest, over the masses of one modulus, less 1

``python -m benchmarks.stiffness_in_simulation [--fidelity uniform|indentation] [--json]``
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import sys
from pathlib import Path

from dynamics.errors import PalpateError
from dynamics.signals import Phase
from estimation.carried import held_weight
from estimation.squeezing import measure_squeeze
from selection.actions import Squeeze
from selection.actions.hand import Hand
from selection.tape import Tape
from sim.robot import MujocoRobot
from sim.sensors import SensorModel
from sim.truth import read_truth

OBJECT = Path(__file__).parents[1] / "models" / "objects" / "soft-cube.toml"
MODULI = (5e3, 5e4, 3e5, 1e6)
MASSES = (0.004, 0.1, 1.0)


def squeeze(modulus: float, mass: float, fidelity: str) -> tuple[MujocoRobot, tuple[Phase, ...]]:
    truth = dataclasses.replace(read_truth(OBJECT), young_modulus=modulus, mass=mass)
    robot = MujocoRobot(truth, SensorModel.none(), seed=0, fidelity=fidelity)
    tape = Tape(robot)
    Squeeze().perform(Hand(robot, truth.declared, tape))
    return robot, tape.take()


def ratio(modulus: float, mass: float, fidelity: str) -> float | str:
    try:
        robot, phases = squeeze(modulus, mass, fidelity)
        size = read_truth(OBJECT).size
        estimate, _ = measure_squeeze(
            robot.gripper, "box", size, phases, poisson=0.0, weight=held_weight(robot.arm, phases)
        )
    except PalpateError as error:
        return str(error)
    return estimate.young_modulus / modulus


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.stiffness_in_simulation")
    parser.add_argument("--fidelity", choices=("uniform", "indentation"), default="uniform")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args(arguments)
    table = {f"{e:g}": {f"{m:g}": ratio(e, m, options.fidelity) for m in MASSES} for e in MODULI}
    spread = {}
    for modulus, row in table.items():
        found = [v for v in row.values() if isinstance(v, float)]
        spread[modulus] = max(found) / min(found) - 1 if found else None
    if options.json:
        print(json.dumps({"fidelity": options.fidelity, "ratio": table, "mass": spread}))
        return 0
    for modulus, row in table.items():
        print(
            f"{modulus:>8} Pa ", *(f"{m} kg: {v if isinstance(v, str) else f'{v:.4f}'}  " for m, v in row.items())
        )
        print(f"{'':>12} over the masses: {spread[modulus]}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
