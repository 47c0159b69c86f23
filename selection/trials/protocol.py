"""The thesis' protocol (chapter 4): contexts of prior and measurement, ten steps, the letters C, W, D and U."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from estimation.belief import CORRECT, DIVERGED, UNDECIDED, WEAK
from estimation.network import Network
from estimation.sensor import Sensor
from selection.planner import ActionModel
from selection.thesis_modes import JOKER
from selection.trials.beliefs import Beliefs
from selection.trials.explore import Limits, Trace, explore
from selection.trials.objects import Luck, Objects, trial_rng
from selection.trials.policies import Exact, Fixed, PerNode, Policy, Random
from selection.trials.thesis_learning import ThesisBeliefs, ThesisMode

PRIORS = ("correct", "incorrect", "uniform")
MEASUREMENTS = ("proper", "noisy")
STEPS = 10
THRESHOLD = 0.6
"""P of the most probable class from which the thesis speaks of convergence."""
PEAK = 0.7
JOKER_WEIGHT = 0.05
FACTORS = {"proper": 1.5, "noisy": 3.5}
"""Measurement errors in units of the true material's reference sd: the thesis says 1 to 2, and above 3."""
PERTURBATION = {"density": 20.0, "elasticity": 10e9}
"""Ends of the uniform perturbation of a measurement [SI]: 20 bins of 1 kg/m^3, 10 of 1 GPa."""
LETTERS = {"weigh": "W", "squeeze": "S"}
SECONDS = {"weigh": 68.0, "squeeze": 30.0}
"""What the simulated arm takes for them [s], to count with where nothing moves."""


@dataclass(frozen=True)
class Context:
    """A row and a column of the thesis' tables.

    Attributes:
        prior: ``correct``, ``incorrect`` or ``uniform``.
        measurement: ``proper`` or ``noisy``.
    """

    prior: str
    measurement: str

    @property
    def name(self) -> str:
        """Both in words."""
        return f"{self.prior} prior, {self.measurement} measurement"


CONTEXTS = tuple(Context(prior, measurement) for measurement in MEASUREMENTS for prior in PRIORS)
"""In the thesis' order, 1 to 6."""


def prior_of(network: Network, context: Context, truth: int) -> dict[str, float]:
    """Return the prior of a context: a peak on the truth, or on the material after it, or none.

    The thesis prints no numbers; these leave 0.05 to the joker and 0.7 of the rest to the peak.
    """
    names = network.materials
    if context.prior == "uniform":
        shares = {name: 1.0 / len(names) for name in names}
    else:
        peak = truth if context.prior == "correct" else (truth + 1) % len(names)
        rest = (1 - PEAK) / (len(names) - 1)
        shares = {name: PEAK if i == peak else rest for i, name in enumerate(names)}
    return {name: (1 - JOKER_WEIGHT) * share for name, share in shares.items()}


def with_errors(network: Network, context: Context, truth: int) -> Network:
    """Return the network with the measurement errors of a context: so many of the true material's sds."""
    sensors = []
    for name, sensor in network.sensors:
        assert isinstance(sensor, Sensor)
        sd = FACTORS[context.measurement] * network.property(sensor.property).sds[truth]
        sensors.append((name, replace(sensor, sd=sd, relative_sd=0.0)))
    return replace(network.with_unknown(JOKER_WEIGHT), sensors=tuple(sensors))


def policies(network: Network) -> tuple[Policy | ThesisMode, ...]:
    """Return what the thesis' modes are compared with, and the modes."""
    return (
        *(ThesisMode(mode) for mode in (1, 2, 3)),
        *(Exact(target) for target in ("material", *network.property_names, "everything")),
        Random(),
        Fixed(),
        PerNode(),
    )


def action_models(network: Network, sensors: Network) -> tuple[ActionModel, ...]:
    """Return one action a sensor, as often as wanted."""
    return tuple(ActionModel(name, (sensors.sensor(name),), SECONDS[name]) for name, _ in network.sensors)


def virtual_trials(
    network: Network, context: Context, policy: Policy | ThesisMode, trials: Sequence[int], seed: int
) -> Trace:
    """Run trials of one cell; the true material goes round with the number of the trial.

    Args:
        network: the reference, such as ``thesis-3.1-erratum``.
        context: of the cell.
        policy: chooses.
        trials: numbers of the trials.
        seed: of the study.
    """
    count = len(network.materials)
    traces: list[Trace] = []
    places: list[int] = []
    for truth in range(count):
        group = [trial for trial in trials if trial % count == truth]
        if group:
            traces.append(_same_truth(network, context, policy, truth, group, seed))
            places.extend(i for i, trial in enumerate(trials) if trial % count == truth)
    return Trace.of([trace.arrays() for trace in traces]).ordered(np.argsort(places))


def _same_truth(
    network: Network, context: Context, policy: Policy | ThesisMode, truth: int, trials: Sequence[int], seed: int
) -> Trace:
    world = with_errors(network, context, truth)
    objects = perturbed(world, truth, trials, seed)
    return run_cell(world, objects, prior_of(network, context, truth), policy, trials, seed)


def run_cell(
    world: Network,
    objects: Objects,
    prior: dict[str, float],
    policy: Policy | ThesisMode,
    trials: Sequence[int],
    seed: int,
    steps: int = STEPS,
) -> Trace:
    """Explore objects with a policy and the learning that goes with it: the thesis' for its modes, exact else."""
    luck = Luck(seed, 1, trials)
    actions = action_models(world, world)
    limits = Limits(steps)
    if isinstance(policy, ThesisMode):
        learner = ThesisBeliefs(world, len(trials), prior | {JOKER: 1 - sum(prior.values())})
        return explore(objects, learner, actions, policy, luck, limits)[0]  # type: ignore[arg-type]
    known = {name: share / sum(prior.values()) for name, share in prior.items()}
    return explore(objects, Beliefs(world, len(trials), known), actions, policy, luck, limits)[0]


def perturbed(world: Network, truth: int, trials: Sequence[int], seed: int, turns: int = STEPS) -> Objects:
    """Return objects that read as their material's means, perturbed uniformly at every reading (section 4.1)."""
    count = len(trials)
    luck = np.stack([trial_rng(seed, 0, trial).random((len(world.sensors), turns)) for trial in trials])
    readings, sds = {}, {}
    for i, (name, sensor) in enumerate(world.sensors):
        assert isinstance(sensor, Sensor)
        mean = world.property(sensor.property).means[truth]
        readings[name] = mean + PERTURBATION[sensor.property] * (2 * luck[:, i] - 1)
        sds[name] = np.full((count, turns), sensor.sd)
    return Objects(world, np.full(count, truth), np.zeros(count, dtype=int), readings, sds)


def letters(trace: Trace, step: int = -1) -> np.ndarray:
    """Return how every trial ended: C, W, D or U, as `Belief.outcome` has them, shape (N,)."""
    sure = trace.top[:, step] >= THRESHOLD
    right, unknown = trace.right[:, step], trace.unknown[:, step]
    wrong = np.where(unknown | sure, DIVERGED, UNDECIDED)
    return np.where(right, np.where(sure, CORRECT, WEAK), wrong)
