"""A dataset of explorations that take a moment: the hand only nods over the object."""

import sys
from pathlib import Path

from estimation.measurement import Measurement
from selection.actions import Findings, Weigh
from selection.dataset.folder import Dataset
from selection.dataset.one import Job, Outcome, Setup, explore_object

SETUP = Setup(seed=3, noise="none")


class Nod:
    """Goes to the gate, and says that the mass is what the arm's clock shows."""

    name = "weigh"

    def model(self, network):
        return Weigh().model(network)

    def perform(self, hand):
        with hand.tape.phase(self.name, "hold"):
            hand.gate()

    def measure(self, readings):
        return Findings((Measurement("mass", 0.01 + readings.robot.read().time / 1e3, 1e-3, "kg"),))


def nod(job: Job) -> Outcome:
    return explore_object(job, actions=(Nod(),))


def nod_or_die(job: Job) -> Outcome:
    """Explore an object; the process that meets number 1 ends there."""
    if job.index == 1:
        import os

        job.folder.with_name(f".{job.index:06d}.here").mkdir(exist_ok=True)
        os._exit(1)
    return nod(job)


def fail(job: Job) -> Outcome:
    """Explore an object by an action that has a bug."""

    class Broken(Nod):
        def perform(self, hand):
            raise ZeroDivisionError("a bug")

    return explore_object(job, actions=(Broken(),))


if __name__ == "__main__":
    with Dataset.open(Path(sys.argv[1]), SETUP) as dataset:
        for outcome in dataset.explore(int(sys.argv[2]), workers=2, work=nod):
            print(outcome.index, flush=True)
