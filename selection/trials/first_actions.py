"""The first action that the thesis' modes plan (its Tables 4.4 and 4.10)."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from dynamics.errors import InvalidInput
from estimation.network import Network
from selection.trials.beliefs import Beliefs
from selection.trials.objects import Luck
from selection.trials.policies import Exact
from selection.trials.protocol import (
    CONTEXTS,
    JOKER_WEIGHT,
    LETTERS,
    Context,
    action_models,
    prior_of,
    with_errors,
)
from selection.trials.thesis_learning import ThesisBeliefs, ThesisMode

JOKER = "joker"


@dataclass(frozen=True)
class FirstAction:
    """What is done first in one context.

    Attributes:
        policy: of whom.
        context: where.
        counts: how often every letter came, over all true materials and draws.
    """

    policy: str
    context: Context
    counts: tuple[tuple[str, int], ...]

    @property
    def letter(self) -> str:
        """The usual one."""
        return max(self.counts, key=lambda pair: pair[1])[0]

    @property
    def share(self) -> float:
        """How usual it is."""
        return max(count for _, count in self.counts) / sum(count for _, count in self.counts)


def first_actions(network: Network, policy: ThesisMode | Exact, draws: int, seed: int) -> tuple[FirstAction, ...]:
    """Return the first actions in every context, for every material as the truth.

    Args:
        network: the reference; if it brings measurement errors that are to be kept, see `real_first_actions`.
        policy: plans.
        draws: plans per material, for modes that sample.
        seed: of the sampling.
    """
    return tuple(
        _first(policy, context, [(with_errors(network, context, t), t) for t in _truths(network)], draws, seed)
        for context in CONTEXTS
    )


def real_first_actions(
    network: Network, policy: ThesisMode | Exact, draws: int, seed: int
) -> tuple[FirstAction, ...]:
    """Return the first actions with the network's own measurement errors: correct, incorrect, uniform prior."""
    own = network.with_unknown(JOKER_WEIGHT)
    return tuple(
        _first(policy, context, [(own, truth) for truth in _truths(network)], draws, seed)
        for context in CONTEXTS[:3]
    )


def _truths(network: Network) -> range:
    return range(len(network.materials))


def _first(
    policy: ThesisMode | Exact, context: Context, worlds: list[tuple[Network, int]], draws: int, seed: int
) -> FirstAction:
    counts: Counter[str] = Counter(dict.fromkeys(LETTERS.values(), 0))
    for world, truth in worlds:
        prior = prior_of(world, context, truth)
        actions = action_models(world, world)
        rows, luck = np.arange(draws), Luck(seed, 4, range(draws))
        done = np.zeros((draws, len(actions)), dtype=int)
        if isinstance(policy, ThesisMode):
            learner = ThesisBeliefs(world, draws, prior | {JOKER: 1 - sum(prior.values())})
            scores = policy.scores(learner, rows, actions, done, luck)
        else:
            known = {name: share / sum(prior.values()) for name, share in prior.items()}
            scores = policy.scores(Beliefs(world, draws, known), rows, actions, done, luck)
        if not np.all(np.isfinite(scores)):
            raise InvalidInput("first actions: scores", float(np.min(scores)), "finite numbers")
        for best in scores.argmax(axis=1).tolist():
            counts[LETTERS[actions[best].name]] += 1
    return FirstAction(policy.name, context, tuple(counts.items()))
