"""Worlds in which criteria differ: eight materials, ten categories, seven sensors, novel objects, costs."""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass, replace

from estimation.network import CATEGORY, MATERIAL, Network
from selection.planner import ActionModel
from selection.trials.beliefs import Beliefs
from selection.trials.explore import Limits, Trace, explore
from selection.trials.objects import Luck, drawn
from selection.trials.policies import Emulating, Exact, Fixed, Lookahead, PerNode, Policy, Random
from selection.trials.sweep import Arrays, Machines, Progress, Store, pieces, sweep

REFERENCE = "network-8x10"
SECONDS = {"mat-vision": 1.0, "mat-sound": 10.0, "cat-vision": 1.0, "density": 20.0, "elasticity": 15.0}
SECONDS |= {"volume": 5.0, "friction": 12.0}
"""Assumed times of the actions [s]: the reference gives none."""
HAPTIC = ("density", "elasticity", "friction")
CHUNK, CHUNK_AHEAD = 250, 20
MOST_AHEAD = 200
"""Objects that two steps ahead are planned for: a trial of it takes a hundred times as long as the others."""


@dataclass(frozen=True)
class World:
    """What is explored, and what may be used for it.

    Attributes:
        name: in tables.
        about: in words.
        novel: share of objects of no listed class, and prior probability of ``unknown``; None for neither.
        price: of time [bits/s].
        budget_seconds: robot time [s].
        grasp_seconds: set-up that density, elasticity and friction share [s].
    """

    name: str
    about: str
    novel: float | None = None
    price: float = 0.0
    budget_seconds: float = math.inf
    grasp_seconds: float = 0.0

    @property
    def network(self) -> Network:
        """The reference, with or without unknown objects."""
        network = Network.from_file(REFERENCE)
        return network.without_unknown() if self.novel is None else network.with_unknown(self.novel)

    @property
    def actions(self) -> tuple[ActionModel, ...]:
        """The repertoire, each action once: a sensor's error is common to all its looks at one object."""
        network = self.network
        plain = tuple(ActionModel(n, (network.sensor(n),), s, repeat_cap=1) for n, s in SECONDS.items())
        if not self.grasp_seconds:
            return plain
        return tuple(
            replace(a, setup="grasp", setup_seconds=self.grasp_seconds) if a.name in HAPTIC else a for a in plain
        )

    @property
    def limits(self) -> Limits:
        """What an exploration may use."""
        return Limits(len(SECONDS), self.price, self.budget_seconds)


WORLDS = (
    World("known objects", "all objects of a listed class; time costs nothing"),
    World("novel objects", "a tenth of the objects of no listed class; time costs nothing", novel=0.1),
    World(
        "costs",
        "a tenth novel; 0.01 bit a second, a grasp of 10 s before density, elasticity or friction, 60 s in all",
        novel=0.1,
        price=0.01,
        budget_seconds=60.0,
        grasp_seconds=10.0,
    ),
)


@dataclass(frozen=True)
class Entry:
    """A policy and how its beliefs are kept.

    Attributes:
        policy: chooses.
        messages: whether material and category learn from each other, as in exact inference; the thesis keeps
            them apart.
    """

    policy: Policy
    messages: bool = True

    @property
    def name(self) -> str:
        """What it is called in tables."""
        return self.policy.name if self.messages else f"{self.policy.name}, no messages"


def entries(world: World) -> tuple[Entry, ...]:
    """Return what is compared in a world; the exact criterion about the material comes first."""
    compared: tuple[Policy, ...] = (
        *(Exact(target) for target in (MATERIAL, CATEGORY, "both", "everything")),
        Lookahead(MATERIAL, world.price, world.budget_seconds),
        *(Emulating(1), Emulating(1, "both"), Emulating(2), Emulating(3)),
        *(Random(), Fixed(), PerNode()),
    )
    apart = tuple(Entry(Emulating(mode), messages=False) for mode in (1, 2, 3))
    return (*(Entry(policy) for policy in compared), *apart)


def without_messages(network: Network) -> Network:
    """Return the network with material and category independent, each with its own marginal."""
    marginal = tuple(
        sum(p * row[m] for p, row in zip(network.prior, network.conditional, strict=True))
        for m in range(len(network.materials))
    )
    return replace(network, conditional=(marginal,) * len(network.categories))


@dataclass(frozen=True)
class HarderJob:
    """Some trials of one policy in one world."""

    world: int
    entry: int
    first: int
    count: int
    seed: int

    @property
    def name(self) -> str:
        """What tells it from every other chunk."""
        return f"harder-{self.world}-{self.entry}-{self.first}-{self.count}"


def run_job(job: HarderJob) -> Arrays:
    """Run a chunk."""
    world = WORLDS[job.world]
    entry, network = entries(world)[job.entry], world.network
    trials = range(job.first, job.first + job.count)
    learner = Beliefs(network if entry.messages else without_messages(network), job.count)
    objects = drawn(network, job.seed, trials, stream=2)
    luck = Luck(job.seed, 3, trials)
    found = explore(objects, learner, world.actions, entry.policy, luck, world.limits, (MATERIAL, CATEGORY))
    return found[0].arrays("material.") | found[1].arrays("category.")


@dataclass(frozen=True, eq=False)
class HarderResult:
    """What one policy did in one world.

    Attributes:
        world: where.
        policy: its name.
        exact_inference: whether messages passed.
        material, category: the trials.
    """

    world: World
    policy: str
    exact_inference: bool
    material: Trace
    category: Trace


def harder_study(
    objects: int,
    seed: int,
    store: Store | None = None,
    machines: Machines | None = None,
    progress: Progress | None = None,
) -> tuple[HarderResult, ...]:
    """Explore the same objects with every policy in every world.

    Args:
        objects: number of objects, common to all policies.
        seed: of everything random.
        store, machines, progress: as for `sweep`.
    """
    jobs = [
        HarderJob(w, e, first, count, seed)
        for w, world in enumerate(WORLDS)
        for e, entry in enumerate(entries(world))
        for first, count in _chunks(entry, objects)
    ]
    # the slow ones last
    jobs.sort(key=lambda job: isinstance(entries(WORLDS[job.world])[job.entry].policy, Lookahead))
    parts: defaultdict[tuple[int, int], list[Arrays]] = defaultdict(list)
    for job, arrays in zip(jobs, sweep("harder world", run_job, jobs, store, machines, progress), strict=True):
        parts[job.world, job.entry].append(arrays)
    return tuple(
        HarderResult(
            WORLDS[w],
            entries(WORLDS[w])[e].name,
            entries(WORLDS[w])[e].messages,
            Trace.of(arrays, "material."),
            Trace.of(arrays, "category."),
        )
        for (w, e), arrays in parts.items()
    )


def _chunks(entry: Entry, objects: int) -> list[tuple[int, int]]:
    if isinstance(entry.policy, Lookahead):
        return pieces(min(objects, MOST_AHEAD), CHUNK_AHEAD)
    return pieces(objects, CHUNK)
