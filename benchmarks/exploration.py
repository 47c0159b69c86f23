"""Explorations over the whole range of stiffness and mass: what fails, how exact the rest is, how long it takes.

``python -m benchmarks.exploration [--json] [--seed N] [--noise default|none]``
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import sys
import time

from estimation.network import Network
from models import objects
from selection.actions import Squeeze, Weigh
from selection.display import Silent
from selection.exploration import Exploration, Settings
from sim.robot import MujocoRobot
from sim.sensors import SensorModel
from sim.truth import TrueObject, read_truth

MODULI = (5e3, 2e4, 5e4, 2e5, 1e6)  # Pa
MASSES = (0.004, 0.02, 0.1, 0.4, 1.0)  # kg
HELD_STRAIN = 0.35  # compression of a grasp
SAFETY = 1.2


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--noise", choices=("default", "none"), default="default")
    given = parser.parse_args()
    noise = SensorModel() if given.noise == "default" else SensorModel.none()
    cubes = [base_object(modulus, mass) for modulus in MODULI for mass in MASSES]
    rows = [explore(cube, noise, given.seed) for cube in cubes if can_be_held(cube)]
    if given.json:
        json.dump(rows, sys.stdout, indent=2)
        return
    print("E [kPa]  mass [g]  found E [kPa]     found mass [g]    robot s  wall s  failed")
    for row in rows:
        print(
            f"{row['young_modulus'] / 1e3:7.0f}  {row['mass'] * 1e3:8.0f}  {shown(row, 'elasticity', 1e-3):16}  "
            f"{shown(row, 'mass_found', 1e3):16}  {row['seconds']:7.0f}  {row['wall_seconds']:6.1f}  "
            f"{'; '.join(row['failed'])}"
        )


def base_object(modulus: float, mass: float) -> TrueObject:
    """Return the default cube with another modulus [Pa] and mass [kg]."""
    return dataclasses.replace(read_truth(objects.locate("soft-cube")), young_modulus=modulus, mass=mass)


def can_be_held(truth: TrueObject) -> bool:
    """Tell whether friction can carry the object at the strain of a grasp: 2 mu E A strain >= safety m g."""
    area = truth.size[0] * truth.size[2]
    grip = truth.young_modulus * area * HELD_STRAIN
    return 2 * truth.friction * min(grip, 18.0) >= SAFETY * 9.81 * truth.mass


def explore(truth: TrueObject, noise: SensorModel, seed: int) -> dict[str, object]:
    """Weigh and squeeze one object; a warning of the physics ends the benchmark with an error."""
    started = time.perf_counter()
    settings = Settings(price=0.0, confidence=1.0)
    actions = (OnlyOnce(Weigh()), OnlyOnce(Squeeze()))
    exploration = Exploration(
        MujocoRobot(truth, noise, seed),
        truth.declared,
        Network.from_file("soft-cubes"),
        None,
        settings,
        Silent(),
        actions,
    )
    exploration.explore()
    measured = {m.property: (m.mean, m.sd) for step in exploration.steps for m in step.measurements}
    return {
        "young_modulus": truth.young_modulus,
        "mass": truth.mass,
        "elasticity": measured.get("elasticity"),
        "mass_found": measured.get("mass"),
        "seconds": exploration.seconds,
        "wall_seconds": time.perf_counter() - started,
        "failed": [f"{step.action}: {'; '.join(step.notes)}" for step in exploration.steps if step.notes],
    }


class OnlyOnce:
    """An action that is done once, whatever it would still teach."""

    def __init__(self, action: Weigh | Squeeze) -> None:
        self.name, self.perform, self.measure, self._model = (
            action.name,
            action.perform,
            action.measure,
            action.model,
        )

    def model(self, network: Network):
        found = self._model(network)
        return None if found is None else dataclasses.replace(found, repeat_cap=1)


def shown(row: dict[str, object], key: str, factor: float) -> str:
    found = row[key]
    return "-" if found is None else f"{found[0] * factor:.4g} +- {found[1] * factor:.2g}"


if __name__ == "__main__":
    main()
