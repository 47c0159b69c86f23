"""How fast the simulation is, by the CPU time of one core, so that other work on the machine matters little.

    realtime_factor      simulated over CPU time of a squeeze and a weighing in the full scene at 2 ms and sensors
    step_ratio           CPU time of bare ``mj_step`` over that of the robot, for the same steps of the same model
                         with the same controls, motion by motion in turns
    squeezes_per_second  strokes of one second on the bench in its fast setting, each from rest, moduli changing

``python -m benchmarks.simulation [--json] [--seconds S]``
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import statistics
import sys
import time
from collections.abc import Callable

import mujoco
import numpy as np

from dynamics.bench import Stroke
from dynamics.signals import Sample
from models import objects
from selection.actions import Squeeze, Weigh
from selection.actions.hand import Hand
from selection.tape import Tape
from sim.bench import GAP, SPEED_UP, Bench
from sim.contact import TIMESTEP
from sim.robot import SAMPLE_STEPS, MujocoRobot
from sim.truth import read_truth

CUBE = "soft-cube"
MODULI = (5e3, 2e4, 1e5, 4e5, 1e6)  # Pa
TRAVEL = 0.0056  # m of compression in a stroke of the bench


class Timed(MujocoRobot):
    """A robot that measures its own primitives, and the same steps done without it in turns with them."""

    def __init__(self) -> None:
        self.cpu = self.bare = 0.0
        self.steps, self.simulated = 0, 0.0
        self._done: list[tuple[np.ndarray, float]] = []  # controls, and the time step they were done with
        super().__init__(read_truth(objects.locate(CUBE)))
        self._twin = mujoco.MjData(self._model)

    def _advance(self, controls: np.ndarray) -> None:
        super()._advance(controls)
        self._done.append((controls, self._stepper.timestep))

    def _run(
        self,
        command: Callable[[np.ndarray], tuple[np.ndarray, bool]],
        moving_gripper: bool,
        interrupt: Callable[[Sample], bool] | None = None,
    ) -> bool:
        mujoco.mj_copyData(self._twin, self._model, self._data)
        self._done.clear()
        started = time.process_time()
        result = super()._run(command, moving_gripper, interrupt)
        self.cpu += time.process_time() - started
        model, twin, step, last = self._model, self._twin, mujoco.mj_step, self._stepper.timestep
        control = twin.ctrl
        started = time.process_time()
        for controls, timestep in self._done:
            self._stepper.step_by(timestep)
            count = round(TIMESTEP / timestep)
            for row in controls:
                control[:] = row
                step(model, twin, count)
            self.steps += count * len(controls)
            self.simulated += TIMESTEP * len(controls)
        self.bare += time.process_time() - started
        self._stepper.step_by(last)
        assert np.array_equal(twin.qpos, self._data.qpos), "the twin went another way"
        return result


def full_scene() -> dict[str, float]:
    """Squeeze and weigh the cube once."""
    robot = Timed()
    truth = read_truth(objects.locate(CUBE))
    hand = Hand(robot, truth.declared, Tape(robot))
    for action in (Squeeze(), Weigh()):
        action.perform(hand)
    return {
        "realtime_factor": robot.simulated / robot.cpu,
        "step_ratio": robot.bare / robot.cpu,
        "simulated_seconds": robot.simulated,
        "bare_steps_per_second": robot.steps / robot.bare,
        "timestep": TIMESTEP,
        "steps_a_sample": SAMPLE_STEPS,
        "degrees_of_freedom": robot._model.nv,
    }


def bench(seconds: float) -> dict[str, object]:
    """Do strokes of one simulated second until so much CPU time is spent."""
    cube = dataclasses.replace(read_truth(objects.locate(CUBE)), young_modulus=MODULI[0])
    found = {}
    for plates in ("pads", "full"):
        press = Bench(cube, plates, "fast")
        # There and back by 2 GAP of air and the travel, speeding up and slowing down twice: one second together.
        speed = (2 * GAP + TRAVEL) / (0.5 - SPEED_UP)
        stroke = Stroke(speed, press.width - TRAVEL, dwell=0.0)
        lasted = press.press(stroke).time[-1]
        count, errors = 0, []
        started = time.process_time()
        while time.process_time() - started < seconds:
            modulus = MODULI[count % len(MODULI)]
            press.set_modulus(modulus)
            pressed = press.press(stroke)
            count += 1
            if count <= len(MODULI):
                area = press.truth.volume / press.width
                errors.append(pressed.stiffness() * press.width / (area * modulus) - 1)
        spent = time.process_time() - started
        found[plates] = {
            "strokes_per_second": count / spent,
            "squeezes_per_second": count * lasted / spent,
            "seconds_a_stroke": float(lasted),
            "worst_modulus_error": float(np.max(np.abs(errors))),
        }
    return found


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--seconds", type=float, default=3.0, help="CPU time for each kind of plates")
    parser.add_argument("--repeats", type=int, default=1, help="of the full scene; the median counts")
    given = parser.parse_args(arguments)
    scenes = [full_scene() for _ in range(given.repeats)]
    squeezes = bench(given.seconds)
    figures = {
        "realtime_factor": statistics.median(scene["realtime_factor"] for scene in scenes),
        "step_ratio": statistics.median(scene["step_ratio"] for scene in scenes),
        "squeezes_per_second": min(one["squeezes_per_second"] for one in squeezes.values()),
        "full_scene": scenes,
        "bench": squeezes,
    }
    if given.json:
        print(json.dumps(figures))
        return 0
    print(f"full scene: {figures['realtime_factor']:.1f} times real time")
    print(f"step throughput: {figures['step_ratio']:.3f} of bare mj_step")
    for plates, one in squeezes.items():
        print(
            f"bench, {plates}: {one['squeezes_per_second']:.1f} one-second squeezes a second and core; "
            f"modulus within {100 * one['worst_modulus_error']:.1f} %"
        )
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
