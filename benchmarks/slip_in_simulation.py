"""Friction by the onset of slip in simulation: an object is held over the table and its grip loosened, by steps.

``python -m benchmarks.slip_in_simulation [--seeds N] [--json]``: estimated over true coefficient, without noise
and with the default noise N times, for objects heavy enough to be felt; half a minute for each of them.
"""

from __future__ import annotations

import argparse
import json
import math
import sys

import numpy as np

from benchmarks.friction_in_simulation import thing
from dynamics.errors import PalpateError
from estimation.slipping import measure_slip
from selection.actions.hand import MAX_EFFORT, Hand
from selection.tape import Tape
from sim.robot import MujocoRobot
from sim.sensors import SensorModel

# Coefficient, Pa, kg: those that slip where the gripper can still set the force, 5 N and more.
OBJECTS = ((0.5, 5e4, 1.0), (0.8, 1e5, 1.0), (0.4, 1e5, 1.0), (0.8, 3e5, 1.0), (0.5, 5e4, 0.5), (0.3, 2e5, 0.5))
HEIGHT = 0.008  # m over the table
TIGHTER = 0.004  # m that the pads close in the air, to learn the force of an opening
STEP, DWELL = 0.0002, 0.05  # m, s of the loosening
GONE = 0.5  # share of the weight that is no longer carried, at which to stop


def loosen(friction: float, modulus: float, mass: float, noise: str, seed: int) -> dict[str, object]:
    """Loosen the grip on one object and say how far off the estimate is."""
    row: dict[str, object] = {"friction": friction, "young_modulus": modulus, "mass": mass, "noise": noise}
    truth = thing(friction, modulus, mass)
    robot = MujocoRobot(truth, SensorModel() if noise == "default" else SensorModel.none(), seed)
    tape = Tape(robot)
    hand, slow = Hand(robot, truth.declared, tape), robot.gripper.min_speed
    above = hand.grasp_pose.copy()
    above[2, 3] += HEIGHT
    try:
        hand.gate()
        hand.open_fully()
        hand.line(above)
        hand.settle()
        with tape.phase("slip", "tare") as empty:
            robot.hold(1.0)
        hand.grasp("slip")
        hand.lift(HEIGHT)
        hand.settle()
        with tape.phase("slip", "compress"):
            robot.grip(robot.read().opening - TIGHTER, slow, MAX_EFFORT)
        robot.hold(0.5)
        opening = robot.read().opening
        with tape.phase("slip", "loosen") as loosening:
            while opening < hand.width:
                opening += STEP
                robot.grip(opening, slow, math.inf)
                robot.hold(DWELL)
                if hand.rough_payload(empty, loosening[-10:]) < (1 - GONE) * mass:
                    robot.hold(0.3)
                    break
        hand.retreat()
        found, _ = measure_slip(robot.arm, robot.gripper, tape.take())
    except PalpateError as error:
        return row | {"failed": str(error)}
    return row | {
        "ratio": found.coefficient / friction,
        "relative_sd": found.sd / found.coefficient,
        "score": (found.coefficient - friction) / found.sd,
        "force": found.normal,
    }


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.slip_in_simulation")
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args(arguments)
    draws = [("none", 0), *(("default", seed) for seed in range(1, given.seeds + 1))]
    rows = []
    for thing_ in OBJECTS:
        for noise, seed in draws:
            row = loosen(*thing_, noise, seed)
            rows.append(row)
            if not given.json:
                told = row.get("failed") or (
                    f"ratio {row['ratio']:.3f}  sd {100 * row['relative_sd']:.1f} %  "  # type: ignore[operator,str-format]
                    f"z {row['score']:+.1f}  F {row['force']:.1f} N"
                )
                print(f"mu {thing_[0]}  {thing_[1]:9.0f} Pa  {thing_[2]:5} kg  {noise:7}  {told}", flush=True)
    scores = np.array([row["score"] for row in rows if "score" in row], dtype=float)
    inside = float(np.mean(np.abs(scores) <= 1.96)) if len(scores) else math.nan
    if given.json:
        json.dump({"rows": rows, "coverage": inside}, sys.stdout, indent=2)
    else:
        print(f"measured: {len(scores)} of {len(rows)}; coverage of 95 %: {inside:.3f}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
