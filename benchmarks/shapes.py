"""Stiffness of objects of every shape from the signals of the simulated gripper, without sensor noise.

    ratio    estimated over true modulus, in the whole scene: grasp, squeeze, and what the estimate makes of it

``python -m benchmarks.shapes [--fidelity uniform|indentation] [--shape NAME ...] [--json]``; half a minute each.
"""

from __future__ import annotations

import argparse
import json
import sys

from dynamics.errors import PalpateError
from dynamics.objects import DeclaredObject, read_declared
from dynamics.shapes import SHAPES
from estimation.size import SizeEstimate
from models import objects
from selection.actions import Readings, Squeeze
from selection.actions.hand import Hand
from selection.tape import Tape
from sim.robot import MujocoRobot
from sim.sensors import SensorModel
from sim.truth import TrueObject

SIZES = {
    "box": (0.05, 0.06, 0.07),
    "cylinder": (0.06, 0.06, 0.08),
    "sphere": (0.06, 0.06, 0.06),
    "ellipsoid": (0.08, 0.06, 0.05),
}
OBJECTS = ((5e3, 0.004), (5e4, 0.1), (3e5, 0.2), (1e6, 0.5))  # Pa, kg
POISSON = 0.3  # as the estimate takes it to be; it acts in the fidelity with indentation alone


def thing(shape: str, young: float, mass: float) -> TrueObject:
    known = read_declared(objects.locate("soap-bar"))
    if shape != "mesh":
        known = DeclaredObject(shape, shape, SIZES[shape], 0.0005, known.position, known.yaw)  # type: ignore[arg-type]
    return TrueObject(known, known.size, mass, young, POISSON, 0.8, 0.002, "unknown")


def ratio(truth: TrueObject, fidelity: str) -> float | str:
    try:
        robot = MujocoRobot(truth, SensorModel.none(), 0, fidelity)  # type: ignore[arg-type]
        tape = Tape(robot)
        hand = Hand(robot, truth.declared, tape)
        Squeeze().perform(hand)
        size = SizeEstimate.declared(truth.declared)
        found = Squeeze().measure(Readings(robot, tape.take(), truth.shape, size, hand.edge))
    except PalpateError as error:
        return str(error)
    moduli = [m.mean for m in found.measurements if m.property == "elasticity"]
    return moduli[0] / truth.young_modulus if moduli else "; ".join(found.notes)


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.shapes")
    parser.add_argument("--fidelity", choices=("uniform", "indentation"), default="uniform")
    parser.add_argument("--shape", nargs="+", choices=SHAPES, default=SHAPES)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args(arguments)
    table = {}
    for shape in options.shape:
        table[shape] = {
            f"{young:g}": ratio(thing(shape, young, mass), options.fidelity) for young, mass in OBJECTS
        }
        if not options.json:
            row = "  ".join(
                f"{e} Pa: {v if isinstance(v, str) else format(v, '.3f')}" for e, v in table[shape].items()
            )
            print(f"{shape:>10}  {row}", flush=True)
    if options.json:
        print(json.dumps({"fidelity": options.fidelity, "ratio": table}))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
