"""Friction by rubbing in simulation, over coefficients, moduli and masses: estimated over true, and its z-score.

``python -m benchmarks.friction_in_simulation [--noise default|none] [--seeds N] [--fidelity uniform|indentation]
[--workers N] [--json]``
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import math
import sys
from statistics import median

from dynamics.errors import PalpateError
from estimation.parallel import in_parallel
from estimation.rubbing import measure_rub
from models import objects
from selection.actions.hand import Hand
from selection.actions.rub import Rub
from selection.tape import Tape
from sim.robot import MujocoRobot
from sim.sensors import SensorModel
from sim.truth import TrueObject, read_truth

COEFFICIENTS = (0.2, 0.35, 0.5, 0.65, 0.8, 1.0)
MODULI = (5e4, 1e5, 3e5, 1e6)  # Pa
MASSES = (0.004, 0.02, 0.1, 1.0)  # kg
Job = tuple[float, float, float, str, str, int]


def thing(friction: float, modulus: float, mass: float) -> TrueObject:
    """Return the default cube with another friction, modulus and mass."""
    cube = read_truth(objects.locate("soft-cube"))
    return dataclasses.replace(cube, friction=friction, young_modulus=modulus, mass=mass)


def rub(job: Job) -> dict[str, object]:
    """Rub one object and say how far off the estimate is."""
    friction, modulus, mass, fidelity, noise, seed = job
    truth = thing(friction, modulus, mass)
    sensors = SensorModel() if noise == "default" else SensorModel.none()
    row: dict[str, object] = {"friction": friction, "young_modulus": modulus, "mass": mass, "seed": seed}
    try:
        robot = MujocoRobot(truth, sensors, seed, fidelity=fidelity)  # type: ignore[arg-type]
        tape = Tape(robot)
        Rub().perform(Hand(robot, truth.declared, tape))
        found, _ = measure_rub(robot.arm, tape.take(), gripper=robot.gripper)
    except PalpateError as error:
        return row | {"failed": str(error)}
    score = (found.coefficient - friction) / found.sd
    return row | {
        "ratio": found.coefficient / friction,
        "relative_sd": found.sd / found.coefficient,
        "score": score,
        "normal": found.normal,
        "seconds": robot.read().time,
    }


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.friction_in_simulation")
    parser.add_argument("--noise", choices=("default", "none"), default="none")
    parser.add_argument("--fidelity", choices=("uniform", "indentation"), default="uniform")
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args(arguments)
    things = [(mu, modulus, mass) for mu in COEFFICIENTS for modulus in MODULI for mass in MASSES]
    # Every rub has draws of its own: the gain of the motor current is one draw, and would be the same in all.
    jobs: list[Job] = [
        (*one, given.fidelity, given.noise, number * given.seeds + seed + 1)
        for number, one in enumerate(things)
        for seed in range(given.seeds)
    ]
    rows = [row for _, row in sorted(in_parallel(rub, jobs, given.workers), key=lambda one: one[0])]
    scores = [row["score"] for row in rows if "score" in row]
    inside = sum(abs(score) <= 1.96 for score in scores) / max(len(scores), 1)  # type: ignore[operator,arg-type]
    if given.json:
        json.dump({"rows": rows, "coverage": inside}, sys.stdout, indent=2)
        return 0
    for row in rows:
        told = row.get("failed") or (
            f"ratio {row['ratio']:.3f}  sd {100 * row['relative_sd']:.1f} %  z {row['score']:+.1f}  "  # type: ignore[operator,str-format]
            f"F {row['normal']:.1f} N  {row['seconds']:.0f} s"
        )
        print(f"mu {row['friction']}  {row['young_modulus']:9.0f} Pa  {row['mass']:5} kg  {told}")
    errors = [abs(row["ratio"] - 1) for row in rows if "ratio" in row]  # type: ignore[operator]
    if errors:
        print(
            f"within 10 %: {sum(e <= 0.1 for e in errors)} of {len(rows)}; median {100 * median(errors):.1f} %; "
            f"coverage of 95 %: {inside:.3f}; "
            f"rms {100 * math.sqrt(sum(e * e for e in errors) / len(errors)):.1f} %"
        )
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
