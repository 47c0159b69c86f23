"""The thesis' own learning and planning for many objects at once: readings taken for fresh draws."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from dynamics.errors import InvalidInput
from estimation.network import MATERIAL, Network
from estimation.sensor import ClassSensor
from selection.planner import ActionModel
from selection.thesis_modes import (
    JOKER,
    ThesisProperty,
    emulated,
    material_gain,
    pmf_of,
    property_gain,
    thesis_properties,
    update,
)
from selection.trials.objects import Luck
from selection.trials.policies import SAMPLES

_AT_ONCE = 60_000


class ThesisBeliefs:
    """N beliefs about the material as the thesis keeps them; the joker stands where ``unknown`` would.

    Args:
        network: the reference, with an unknown class.
        count: number of beliefs.
        prior: probabilities of the materials and of ``joker``.
        bins: of the working windows.
    """

    def __init__(self, network: Network, count: int, prior: Mapping[str, float], bins: int = 1001) -> None:
        self.properties: dict[str, ThesisProperty] = {
            prop.name: ThesisProperty(prop.name, prop.means, prop.sds, prop.noise, prop.low, prop.high, bins)
            for prop in thesis_properties(network)
        }
        self.pmf = np.tile(pmf_of(network, {JOKER: 0.0} | dict(prior)), (count, 1))

    def probabilities(self, variable: str) -> np.ndarray:
        """Return P(material), the joker last, shape (N, M + 1)."""
        if variable != MATERIAL:
            raise InvalidInput("thesis beliefs: variable", variable, MATERIAL)
        return self.pmf

    def update(self, rows: np.ndarray, quantity: str, z: np.ndarray, sd: np.ndarray | float) -> None:
        """Update some PMFs (Eqs. 3.10 and 3.17); the sd is the one that planning assumes."""
        self.pmf[rows] = update(self.pmf[rows], self.properties[quantity], z)

    def update_output(self, rows: np.ndarray, sensor: ClassSensor, outcome: np.ndarray) -> None:
        """Refuse: the thesis has no classifiers."""
        raise InvalidInput("thesis beliefs", "a classifier", "sensors of properties")


@dataclass(frozen=True)
class ThesisMode:
    """Optimization mode 1, 2 or 3, literally; it goes with `ThesisBeliefs`.

    Attributes:
        mode: 1, 2 or 3.
    """

    mode: int
    stops: bool = True
    priced: bool = False

    @property
    def name(self) -> str:
        """What it is called in tables."""
        return f"thesis mode {self.mode}"

    def scores(
        self,
        beliefs: ThesisBeliefs,
        rows: np.ndarray,
        actions: Sequence[ActionModel],
        done: np.ndarray,
        luck: Luck,
    ) -> np.ndarray:
        """Return the mode's gains."""
        found = np.zeros((len(rows), len(actions)))
        for i, action in enumerate(actions):
            prop = beliefs.properties[action.sensors[0].property]  # type: ignore[union-attr]
            if self.mode != 2:
                picks, errors = luck.uniform(rows, SAMPLES), luck.normal(rows, SAMPLES)
                pmf = beliefs.pmf[rows]
                found[:, i] += material_gain(pmf, prop, emulated(pmf, prop, picks, errors))
            if self.mode != 1:
                size = max(1, _AT_ONCE // prop.bins)
                for start in range(0, len(rows), size):
                    part = rows[start : start + size]
                    found[start : start + size, i] += property_gain(beliefs.pmf[part], prop)
        return found
