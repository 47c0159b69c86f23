"""Measure the planner and the belief: ``python -m benchmarks.planner [--json] [--objects N]``."""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from estimation.belief import Belief
from estimation.measurement import Measurement
from estimation.network import Network, Property
from estimation.sensor import Sensor
from selection.baselines import greedy_per_node, random_choice
from selection.channel import forget
from selection.information import information_gain
from selection.lookahead import decide
from selection.planner import ActionModel, PlanState, StopRules, plan
from selection.thesis_modes import MODES, mode_2, planned, pmf_of, thesis_properties
from selection.virtual import VirtualObject

SECONDS = {"mat-vision": 1, "mat-sound": 10, "cat-vision": 1, "density": 20, "elasticity": 15}
SECONDS |= {"volume": 5, "friction": 12}
CAP = 6


BATCHES = 30  # short ones, so that some are not disturbed by what else the machine does


def milliseconds(call: Callable[[], object], budget: float = 0.3) -> float:
    """Return the best time of a call in many short batches [ms]."""
    call()
    start = time.perf_counter()
    call()
    once = max(time.perf_counter() - start, 1e-6)
    count = max(1, int(budget / BATCHES / once))
    times = []
    for _ in range(BATCHES):
        start = time.perf_counter()
        for _ in range(count):
            call()
        times.append((time.perf_counter() - start) / count)
    return round(1e3 * min(times), 4)


def speed() -> dict[str, Any]:
    """Return times per plan: from nothing, and the next one of an exploration, which remembers densities."""
    found: dict[str, Any] = {}
    for scale in ("linear", "log"):
        for materials, count in ((8, 5), (64, 8), (512, 8)):
            belief, actions = random_problem(scale, materials, count)
            reading = Measurement("p0", 3.0, 0.5, "1")

            def first(belief: Belief = belief, actions: tuple[ActionModel, ...] = actions) -> None:
                forget()
                plan(belief, actions)

            found[f"{scale}, {materials} materials, {count} properties"] = {
                "first plan of 5 actions [ms]": milliseconds(first),
                "next plan [ms]": milliseconds(lambda b=belief, a=actions: plan(b, a)),  # type: ignore[misc]
                "update [ms]": milliseconds(lambda b=belief, r=reading: b.update(r).bank),  # type: ignore[misc]
            }
    network = Network.from_file("network-8x10")
    belief, actions = Belief(network), seven_actions(network)
    found["network-8x10"] = {"next plan of 7 actions [ms]": milliseconds(lambda: plan(belief, actions))}
    return found


def random_problem(scale: str, materials: int, count: int) -> tuple[Belief, tuple[ActionModel, ...]]:
    """Return a random network's belief and five actions that read a property each."""
    rng = np.random.default_rng(0)
    properties = tuple(
        Property(
            f"p{i}",
            "material",
            "1",
            scale,
            tuple(rng.uniform(1, 10, materials)),
            tuple(rng.uniform(0.2, 2, materials)),
        )
        for i in range(count)
    )
    names = tuple(f"m{i}" for i in range(materials))
    network = Network("speed", names, properties, (1 / materials,) * materials)
    return Belief(network), tuple(ActionModel(f"p{i}", (Sensor(f"p{i}", 0.5),), 1.0) for i in range(5))


def seven_actions(network: Network) -> tuple[ActionModel, ...]:
    return tuple(
        ActionModel(name, (network.sensor(name),), float(seconds), repeat_cap=1)
        for name, seconds in SECONDS.items()
    )


def closed_loop(policy: str, objects: int) -> dict[str, float]:
    """Explore until P(material) >= 0.95 or six actions, on objects drawn from the published network."""
    network = Network.from_file("network-8x10").without_unknown()
    actions = {action.name: action for action in seven_actions(network)}
    rules = StopRules(confidence=1.0)
    counts, correct, confident = [], [], []
    for i in range(objects):
        thing, rng = VirtualObject(network, np.random.default_rng([11, i])), np.random.default_rng([12, i])
        belief, state = Belief(network), PlanState()
        while len(state.done) < CAP and max(belief.probabilities("material").values()) < 0.95:
            repertoire = tuple(actions.values())
            if policy == "exact":
                name = plan(belief, repertoire, "material", 0.0, state, rules).choice
            elif policy == "per node":
                name = greedy_per_node(belief, repertoire, state)
            else:
                name = random_choice(repertoire, state, rng)
            if name is None:
                break
            belief = thing.learn(belief, network.sensor(name))
            state = state.after(actions[name])
        found = belief.probabilities("material")
        counts.append(len(state.done))
        correct.append(belief.argmax("material") == thing.material)
        confident.append(max(found.values()) >= 0.95)
    return {
        "objects": objects,
        "actions until P >= 0.95, at most 6": round(float(np.mean(counts)), 3),
        "standard error": round(float(np.std(counts) / np.sqrt(objects)), 3),
        "known": round(float(np.mean(confident)), 3),
        "correct": round(float(np.mean(correct)), 3),
    }


def calibration(objects: int) -> dict[str, float]:
    """Return how true the probabilities are, a tenth of the objects being of no listed class."""
    network = Network.from_file("thesis-3.1-erratum").with_unknown(0.1)
    p, right, novel, called, pit = [], [], [], [], []
    for i in range(objects):
        thing, belief = VirtualObject(network, np.random.default_rng([31, i])), Belief(network)
        for turn, name in enumerate(["weigh", "squeeze"] * 3):
            belief = thing.learn(belief, network.sensor(name), turn)
        found = belief.probabilities("material")
        best = max(found, key=lambda key: found[key])
        p.append(found[best])
        right.append(best == thing.material)
        novel.append(thing.material == "unknown")
        called.append(best == "unknown")
        pit.append(float(belief.marginal("density").cdf(thing.value("density"))))
    index = np.minimum((np.array(p) * 10).astype(int), 9)
    gap = np.abs(np.bincount(index, np.array(right, float) - np.array(p), minlength=10)).sum() / objects
    is_novel, is_called, spread = np.array(novel), np.array(called), np.array(pit)
    return {
        "objects": objects,
        "expected calibration error": round(float(gap), 4),
        "coverage of 90 % intervals": round(float(np.mean((spread > 0.05) & (spread < 0.95))), 4),
        "recall of novel objects": round(float(is_called[is_novel].mean()), 3),
        "false alarms": round(float(is_called[~is_novel].mean()), 4),
    }


def lookahead(objects: int) -> dict[str, Any]:
    """Return net values of greedy runs and of those that look ahead: bits about the material - price x time."""
    network = Network.from_file("network-8x10").without_unknown()
    plain = seven_actions(network)
    haptic = {"density", "elasticity", "friction"}
    dear = tuple(replace(a, setup="grasp", setup_seconds=90.0) if a.name in haptic else a for a in plain)
    coins, pair = shared_grasp()
    cubes = Network.from_file("soft-cubes")
    cases = {
        "two actions share a grasp of 60 s": (coins, pair, 0.01, StopRules()),
        "three of seven share a grasp of 90 s": (network, dear, 0.01, StopRules()),
        "budget 22 s": (network, plain, 0.0005, StopRules(budget_seconds=22.0)),
        "cubes of unknown size, budget 100 s": (cubes, touching(cubes), 0.0005, StopRules(0.99, 100.0)),
        "no set-up, no budget": (network, plain, 0.01, StopRules()),
    }
    found: dict[str, Any] = {}
    for name, (world, actions, price, rules) in cases.items():
        number = objects * (1 if world is network else 10)  # small problems are quick
        values = {
            policy: np.array([net_value(planner, world, actions, price, rules, i) for i in range(number)])
            for policy, planner in (("greedy", plan), ("looking ahead", decide))
        }
        difference = values["looking ahead"] - values["greedy"]
        found[name] = {
            "objects": number,
            "greedy [bits]": round(float(values["greedy"].mean()), 3),
            "looking ahead [bits]": round(float(values["looking ahead"].mean()), 3),
            "difference [bits]": round(float(difference.mean()), 3),
            "standard error [bits]": round(float(difference.std() / np.sqrt(number)), 3),
        }
    return found


def net_value(
    planner: Callable[..., Any],
    world: Network,
    actions: tuple[ActionModel, ...],
    price: float,
    rules: StopRules,
    seed: int,
) -> float:
    """Return what exploring one object brought, its price taken off [bits]."""
    table = {action.name: action for action in actions}
    thing = VirtualObject(world, np.random.default_rng([41, seed]))
    belief, state = Belief(world), PlanState()
    start = belief.probabilities("material")[thing.material]
    while choice := planner(belief, actions, "material", price, state, rules).choice:
        for sensor in table[choice].sensors:
            belief = thing.learn(belief, sensor)
        state = state.after(table[choice])
    end = belief.probabilities("material")[thing.material]
    return float(np.log2(end / start)) - price * state.spent_seconds


def touching(network: Network) -> tuple[ActionModel, ...]:
    """Return actions on cubes of unknown size: measuring it tells nothing of the material until it is weighed."""
    times = {"weigh": (62.0, 2), "squeeze": (22.0, 1), "rub": (15.0, 1)}
    grasping = tuple(
        ActionModel(name, (network.sensor(name),), seconds, "grasp", 8.0, cap)
        for name, (seconds, cap) in times.items()
    )
    return (*grasping, ActionModel("measure", (network.sensor("measure"),), 5.0, repeat_cap=1))


def shared_grasp() -> tuple[Network, tuple[ActionModel, ...]]:
    """Return two classes and two actions, each of which teaches less than grasping costs."""
    properties = tuple(Property(n, "material", "1", "linear", (0.0, 0.25), (0.1, 0.1)) for n in "xy")
    network = Network("coins", ("a", "b"), properties, (0.5, 0.5), unknown=None)
    actions = tuple(ActionModel(n, (Sensor(n, 0.05),), 1.0, "grasp", 60.0, repeat_cap=1) for n in "xy")
    return network, actions


def gains() -> dict[str, float]:
    """Return exact gains: of two classes in bits (published to 1e-7), of the published network in nats."""
    found = {}
    for mean, exact in ((1.0, 0.48594415), (2.0, 0.91282229)):
        prop = Property("x", "material", "1", "linear", (-mean, mean), (0.6, 0.6))
        belief = Belief(Network("two", ("a", "b"), (prop,), (0.5, 0.5), unknown=None))
        gain = information_gain(belief, Sensor("x", 0.8))
        found[f"I(material; x) of classes at +-{mean:g} [bits], exactly {exact}"] = round(gain, 10)
    network = Network.from_file("network-8x10").without_unknown()
    belief = Belief(network)
    asked = [(n, "material") for n in ("mat-vision", "mat-sound", "density", "elasticity")]
    asked += [("cat-vision", "category"), ("density", "elasticity"), ("mat-sound", "density")]
    return found | {
        f"I({target}; {name}) [nats]": round(
            information_gain(belief, network.sensor(name), target) * float(np.log(2)), 4
        )
        for name, target in asked
    }


def thesis() -> dict[str, Any]:
    """Return the thesis' Table 3.3 (ceramic, ten times one likelihood) and the first actions of Table 4.10."""
    network = Network.from_file("thesis-3.1-erratum").without_unknown()
    prior = {"ceramic": 0.7, "aluminium": 0.15, "plastic": 0.1, "steel": 0.05}
    once = Belief(network, prior).update(Measurement("density", 3150.0, 300.0, "kg/m^3")).probabilities("material")
    belief, column = Belief(network, prior), []
    for _ in range(10):
        belief = belief.update_class("material", {name: once[name] / prior[name] for name in once})
        column.append(round(belief.probabilities("material")["ceramic"], 5))
    cubes = Network.from_file("thesis-3.2")
    properties = thesis_properties(cubes)
    black, white, even = [0.665, 0.1425, 0.1425], [0.1425, 0.665, 0.1425], [0.95 / 3] * 3
    letters = {"density": "W", "elasticity": "S", None: "-"}
    priors = [
        pmf_of(cubes, {**dict(zip(cubes.materials, p, strict=True)), "joker": 0.05}) for p in (black, white, even)
    ]
    found = {
        mode: "".join(letters[planned(mode, pmf, properties, np.random.default_rng(1))] for pmf in priors)
        for mode in MODES
    }
    printed = {"mode 1": "WWW", "mode 2": "WWS", "mode 3": "WWW"}
    agreeing = sum(a == b for mode in MODES for a, b in zip(found[mode], printed[mode], strict=True))
    return {
        "table 3.3, ceramic after 1 to 10 readings": column,
        "table 4.10, first actions for a correct, incorrect and uniform prior": found,
        "table 4.10, entries that agree, of 9": agreeing,
        "gains of mode 2, uniform prior, weigh and squeeze [bits]": [
            round(mode_2(priors[2], prop), 3) for prop in properties
        ],
    }


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="benchmarks.planner", description=__doc__)
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--objects", type=int, default=2000, help="objects per closed loop (default %(default)s)")
    options = parser.parse_args(arguments)
    count = max(options.objects, 20)
    found = {
        "thesis": thesis(),
        "gains": gains(),
        "speed": speed(),
        "closed loop": {
            "exact": closed_loop("exact", count),
            "random": closed_loop("random", count),
            "per node": closed_loop("per node", max(20, count // 20)),
        },
        "calibration": calibration(max(3000, count)),
        "lookahead": lookahead(max(20, count // 100)),
    }
    if options.json:
        print(json.dumps(found, indent=1))
        return
    for topic, rows in found.items():
        print(topic)
        for name, value in rows.items():
            print(f"  {name}: {value}")


if __name__ == "__main__":
    main()
