"""Made-up squeezes: what a gripper would report of a known material, noise, steps and spikes included."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dynamics.compression import Geometry
from dynamics.gripper import ParallelGripper
from dynamics.signals import Phase, Sample

Array = NDArray[np.float64]

RATE = 100.0  # Hz
HELD = 0.05  # A; a locked gripper's current
AIR = 0.09  # A; closing in air


@dataclass(frozen=True)
class Squeeze:
    """How a made-up squeeze is done.

    Attributes:
        modulus: of the object [Pa].
        geometry: of the object, with its true width.
        start: opening before closing [m].
        step: of a compression [m].
        max_force: at which the gripper stops [N].
        max_strain: at which the action ends.
        gain: true force per ampere over the gripper's.
        current_sd, relative_sd: noise of a current reading [A, -].
        spike_rate: share of readings with a current spike.
        quantised: whether opening and current are reported in the gripper's steps.
    """

    modulus: float
    geometry: Geometry
    start: float = 0.064
    step: float = 0.002
    max_force: float = 60.0
    max_strain: float = 0.2
    gain: float = 1.0
    current_sd: float = 0.01
    relative_sd: float = 0.02
    spike_rate: float = 0.0
    quantised: bool = True


def squeeze(plan: Squeeze, gripper: ParallelGripper, rng: np.random.Generator) -> tuple[Phase, ...]:
    """Return the phases of a squeeze as a gripper would report them."""
    maker = _Maker(plan, gripper, rng)
    maker.move("air", gripper.max_opening - 0.002, plan.start)
    maker.move("close", plan.start, 0.0, stop_current=0.05)
    index = 0
    end = plan.geometry.width * (1 - plan.max_strain)
    while maker.opening > end and maker.force(maker.opening) < plan.max_force:
        maker.move("compress", maker.opening, max(maker.opening - plan.step, end), index=index)
        maker.hold("dwell", 0.2, index)
        index += 1
    return tuple(maker.phases)


class _Maker:
    def __init__(self, plan: Squeeze, gripper: ParallelGripper, rng: np.random.Generator) -> None:
        self.plan, self.gripper, self.rng = plan, gripper, rng
        self.phases: list[Phase] = []
        self.opening, self.time = gripper.max_opening - 0.002, 0.0

    def force(self, opening: float) -> float:
        g = self.plan.geometry
        strain = np.array([(g.width - opening) / g.width])
        return float(self.plan.modulus * g.law_of(strain)[0] * g.area)

    def current(self, opening: float, moving: bool) -> float:
        if not moving:
            return HELD
        pressed = max(self.force(opening) - self.gripper.friction_force, 0.0)
        current = AIR + pressed / (self.gripper.force_per_ampere * self.plan.gain)
        current *= 1 + self.plan.relative_sd * self.rng.standard_normal()
        current += self.plan.current_sd * self.rng.standard_normal()
        if self.rng.random() < self.plan.spike_rate:
            current += self.rng.uniform(0.05, 0.5)
        return current

    def sample(self, moving: bool) -> Sample:
        opening, effort = self.opening, self.current(self.opening, moving)
        if self.plan.quantised:
            opening = round(opening / self.gripper.opening_quantum) * self.gripper.opening_quantum
            effort = round(effort / self.gripper.effort_quantum) * self.gripper.effort_quantum
        self.time += 1 / RATE
        none = np.zeros(7)
        return Sample(self.time, none, none, none, opening, effort)

    def move(self, name: str, start: float, end: float, stop_current: float = np.inf, index: int = 0) -> None:
        samples = [self.sample(False)]
        while self.opening > end:
            self.opening = max(self.opening - self.gripper.min_speed / RATE, end)
            samples.append(self.sample(True))
            pressed = self.force(self.opening)
            if pressed > self.plan.max_force or pressed / self.gripper.force_per_ampere > stop_current:
                break
        samples.append(self.sample(False))
        self.phases.append(Phase("squeeze", name, index, tuple(samples)))

    def hold(self, name: str, seconds: float, index: int) -> None:
        samples = tuple(self.sample(False) for _ in range(round(seconds * RATE)))
        self.phases.append(Phase("squeeze", name, index, samples))
