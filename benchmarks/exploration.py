"""Explorations over the whole range of stiffness and mass: one table of what comes out wrong, and by how much.

Every action of the repertoire is done once, with the arm in the full scene, on every cube that friction can carry.
Errors are shares of the truth, and in brackets stated standard deviations.

``python -m benchmarks.exploration [--json] [--seed N] [--noise default|none] [--workers N] [--keep FILE]``

With ``--keep`` what is done is kept in a file, and not done again by the next call.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import sys
import time
from pathlib import Path

import numpy as np

from estimation.network import Network
from estimation.parallel import in_parallel
from models import objects
from selection.actions import ACTIONS, Action
from selection.display import Silent
from selection.exploration import Exploration, Settings
from sim.robot import MujocoRobot
from sim.sensors import SensorModel
from sim.truth import TrueObject, read_truth

MODULI = (5e3, 2e4, 5e4, 2e5, 1e6)  # Pa
MASSES = (0.004, 0.02, 0.1, 0.4, 1.0)  # kg
HELD_STRAIN = 0.35  # compression of a grasp
SAFETY = 1.2
COLUMNS = {"elasticity": ("E", 1e-3, "kPa"), "mass": ("m", 1e3, "g"), "friction": ("mu", 1.0, "")}
TWO_SIDED = 1.96


@dataclasses.dataclass(frozen=True)
class Cell:
    """One cube of the grid, and how to explore it."""

    modulus: float
    mass: float
    noise: str
    seed: int

    @property
    def key(self) -> str:
        return f"{self.modulus:g} Pa, {self.mass:g} kg, noise {self.noise}, seed {self.seed}"


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--noise", choices=("default", "none"), default="default")
    parser.add_argument("--workers", type=int, default=1, help="processes; 0 for one a core")
    parser.add_argument("--keep", type=Path, metavar="FILE")
    given = parser.parse_args(arguments)
    held = [(e, m) for e in MODULI for m in MASSES if can_be_held(base_object(e, m))]
    # Every cube meets another start of the sensors: with one for all, its gain would be in every cell alike.
    cells = [Cell(*cube, given.noise, len(held) * given.seed + number) for number, cube in enumerate(held)]
    done = json.loads(given.keep.read_text()) if given.keep is not None and given.keep.exists() else {}
    missing = [cell for cell in cells if cell.key not in done]
    for number, row in in_parallel(explore, missing, given.workers):
        done[missing[number].key] = row
        if given.keep is not None:
            given.keep.write_text(json.dumps(done, indent=1))
        print(f"{missing[number].key}: {row['wall_seconds']:.0f} s", file=sys.stderr)
    rows = [done[cell.key] for cell in cells]
    summary = {name: summarised(rows, name) for name in COLUMNS if any(row["found"].get(name) for row in rows)}
    if given.json:
        print(json.dumps({"rows": rows, "summary": summary}, indent=2))
        return 0
    print("\n".join(table(rows)))
    for name, one in summary.items():
        print(
            f"{name}: {one['count']} of {len(rows)} measured; error median {100 * one['median']:.1f} %, "
            f"worst {100 * one['worst']:.1f} %; {100 * one['covered']:.0f} % within 1.96 sd"
        )
    return 0


def table(rows: list[dict]) -> list[str]:
    """Return the table: a line a modulus, a column a mass, the errors of every property in each cell."""
    lines = ["error of what was found, in % of the truth (and in stated standard deviations)"]
    masses = sorted({row["true"]["mass"] for row in rows})
    lines.append(f"{'':>12}" + "".join(f"{1e3 * mass:>20g} g" for mass in masses))
    for modulus in sorted({row["true"]["elasticity"] for row in rows}):
        cells = {row["true"]["mass"]: row for row in rows if row["true"]["elasticity"] == modulus}
        for name, (short, _, _) in COLUMNS.items():
            if not any(row["found"].get(name) for row in rows):
                continue
            title = f"{modulus / 1e3:g} kPa  {short}"
            lines.append(f"{title:>12}" + "".join(f"{shown(cells.get(mass), name):>22}" for mass in masses))
    for row in rows:
        for note in row["failed"]:
            true = row["true"]
            lines.append(f"  {true['elasticity'] / 1e3:g} kPa, {1e3 * true['mass']:g} g: {note}")
    return lines


def shown(row: dict | None, name: str) -> str:
    """Return the error of a property in a cell: a dot where friction cannot carry the cube, a dash for nothing."""
    if row is None:
        return "."
    if not row["found"].get(name):
        return "-"
    error, in_sds = errors(row, name)
    return f"{100 * error:+.1f} ({in_sds:+.1f})"


def errors(row: dict, name: str) -> tuple[float, float]:
    """Return the error of a property, as a share of the truth and in stated standard deviations."""
    mean, sd = row["found"][name]
    true = row["true"][name]
    return mean / true - 1, (mean - true) / sd


def summarised(rows: list[dict], name: str) -> dict[str, float]:
    both = np.array([errors(row, name) for row in rows if row["found"].get(name)])
    return {
        "count": len(both),
        "median": float(np.median(np.abs(both[:, 0]))),
        "worst": float(np.max(np.abs(both[:, 0]))),
        "covered": float(np.mean(np.abs(both[:, 1]) <= TWO_SIDED)),
    }


def base_object(modulus: float, mass: float) -> TrueObject:
    """Return the default cube with another modulus [Pa] and mass [kg]."""
    return dataclasses.replace(read_truth(objects.locate("soft-cube")), young_modulus=modulus, mass=mass)


def can_be_held(truth: TrueObject) -> bool:
    """Tell whether friction can carry the object at the strain of a grasp: 2 mu E A strain >= safety m g."""
    area = truth.size[0] * truth.size[2]
    grip = truth.young_modulus * area * HELD_STRAIN
    return 2 * truth.friction * min(grip, 18.0) >= SAFETY * 9.81 * truth.mass


def explore(cell: Cell) -> dict:
    """Do every action once on one cube; a warning of the physics ends the benchmark with an error."""
    truth = base_object(cell.modulus, cell.mass)
    noise = SensorModel() if cell.noise == "default" else SensorModel.none()
    started = time.perf_counter()
    exploration = Exploration(
        MujocoRobot(truth, noise, cell.seed),
        truth.declared,
        Network.from_file("soft-cubes"),
        None,
        Settings(price=0.0, confidence=1.0),
        Silent(),
        tuple(OnlyOnce(action) for action in ACTIONS),
    )
    exploration.explore()
    measured = {m.property: (m.mean, m.sd) for step in exploration.steps for m in step.measurements}
    return {
        "true": {"elasticity": truth.young_modulus, "mass": truth.mass, "friction": truth.friction},
        "found": {name: measured.get(name) for name in COLUMNS},
        "seconds": exploration.seconds,
        "wall_seconds": time.perf_counter() - started,
        "failed": [f"{step.action}: {'; '.join(step.notes)}" for step in exploration.steps if step.notes],
    }


class OnlyOnce:
    """An action that is done once, whatever it would still teach."""

    def __init__(self, action: Action) -> None:
        self.name, self.perform, self.measure = action.name, action.perform, action.measure
        self._model = action.model

    def model(self, network: Network):
        found = self._model(network)
        return None if found is None else dataclasses.replace(found, repeat_cap=1)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
