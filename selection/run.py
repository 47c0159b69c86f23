"""Explore one object: ``python -m selection.run``."""

from __future__ import annotations

import argparse
import hashlib
import math
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

if TYPE_CHECKING:
    from dynamics.robot import Robot
    from estimation.network import Network
    from selection.display import Lines, LiveTable, Silent
    from selection.exploration import Exploration
    from selection.robots import Truth

WRONG_INPUT = 2
FAILED = 1
STOPPED_BY_HAND = 130

DEFAULT_OBJECT = "soft-cube"
DEFAULT_REFERENCE = "soft-cubes"


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return its exit code."""
    parser = _parser()
    given = parser.parse_args(arguments)
    if given.list:
        return _list()
    from dynamics.errors import InvalidInput, MotionRefused, PalpateError

    try:
        return _explore(given)
    except (InvalidInput, MotionRefused) as error:
        print(f"{parser.prog}: {error}", file=sys.stderr)
        return WRONG_INPUT
    except PalpateError as error:
        print(f"{parser.prog}: {error}", file=sys.stderr)
        return FAILED
    except KeyboardInterrupt:
        print(f"{parser.prog}: interrupted", file=sys.stderr)
        return STOPPED_BY_HAND


def _parser() -> argparse.ArgumentParser:
    parser = _OneLineParser(
        prog="python -m selection.run", description="Explore an object until it is known well enough."
    )
    parser.add_argument("--object", default=DEFAULT_OBJECT, metavar="NAME|FILE.toml", help="object on the table")
    parser.add_argument(
        "--reference", default=DEFAULT_REFERENCE, metavar="NAME|FILE.json", help="what is known of materials"
    )
    parser.add_argument(
        "--prior",
        metavar="uniform|NAME=P,...",
        help="probabilities of materials beforehand; what is not named shares the rest",
    )
    parser.add_argument(
        "--seed", type=_seed, default=0, metavar="N", help="of everything random in the simulation"
    )
    parser.add_argument("--out", type=Path, metavar="DIR", help="run directory (default: runs/<time>-<object>)")
    parser.add_argument(
        "--noise", default="default", metavar="default|none|FILE", help="errors of the simulated sensors"
    )
    parser.add_argument(
        "--confidence",
        type=_probability,
        default=0.99,
        metavar="P",
        help="stop when a material is as probable as this",
    )
    parser.add_argument(
        "--budget", type=_seconds, default=math.inf, metavar="SECONDS", help="robot time to spend at most"
    )
    parser.add_argument(
        "--price", type=_seconds, default=0.005, metavar="BITS", help="what a second of robot time is worth"
    )
    parser.add_argument("--robot", default="sim", metavar="sim|kortex", help="which robot explores")
    parser.add_argument("--resume", type=Path, metavar="DIR", help="go on with an interrupted run")
    parser.add_argument("--list", action="store_true", help="list objects and references, and end")
    parser.add_argument("--quiet", action="store_true", help="print nothing but errors")
    return parser


class _OneLineParser(argparse.ArgumentParser):
    """Reports wrong arguments on one line."""

    def error(self, message: str) -> NoReturn:
        self.exit(WRONG_INPUT, f"{self.prog}: {message}\n")


def _explore(given: argparse.Namespace) -> int:
    """Check everything, then explore; nothing is written before all of it is known to be usable."""
    from dynamics.objects import read_declared
    from estimation.network import Network
    from estimation.recording import RunWriter, read_recording
    from selection.exploration import Exploration, Settings
    from selection.result import result_of
    from selection.robots import RobotRequest, open_robot

    if given.resume is not None:
        _take_up(given)
    object_file = _object_file(given.object)
    network = Network.from_file(given.reference)
    prior = parse_prior(given.prior, network)
    declared = read_declared(object_file)
    opened = open_robot(given.robot, RobotRequest(object_file, given.noise, given.seed))
    settings = Settings("material", given.price, given.confidence, given.budget)
    watcher = _watcher(given.quiet)
    try:
        # A trial without a recording refuses what cannot be done before there is a directory.
        exploration = Exploration(opened.robot, declared, network, prior, settings, watcher)
        past = read_recording(given.resume) if given.resume is not None else None
        directory = given.resume or given.out or Path("runs") / f"{time.strftime('%Y%m%d-%H%M%S')}-{declared.name}"
        names = opened.robot.arm.joint_names
        if past is None:
            run = RunWriter.create(directory, _config(given, object_file, opened.robot), declared.name, names)
        else:
            run = RunWriter.resume(directory, names)
        with run:
            exploration.record(run)
            if past is not None:
                exploration.recall([(m.action, m.measurement) for m in past.measurements], _spent(past.decisions))
            try:
                exploration.explore()
            except BaseException:
                opened.robot.stop()
                raise
            run.finish(result_of(exploration, declared.name, opened.truth))
    finally:
        watcher.close()
        opened.robot.close()
    if not given.quiet:
        _report(exploration, opened.truth, directory)
    return 0


def parse_prior(text: str | None, network: Network) -> Mapping[str, float] | None:
    """Return the prior over materials that an argument means, or None for the reference's own.

    Args:
        text: ``uniform``, or ``NAME=P,...``; materials not named share what is left evenly.
        network: gives the names.

    Raises:
        InvalidInput: for text of another form, or probabilities that are not between 0 and 1 or exceed 1.
        UnknownName: for a material that the reference does not list.
    """
    from dynamics.errors import InvalidInput, UnknownName

    if text is None:
        return None
    listed = network.materials
    given: dict[str, float] = {}
    for part in text.split(",") if text != "uniform" else ():
        name, separator, value = part.partition("=")
        if not separator:
            raise InvalidInput("--prior", part, "uniform, or NAME=P,... such as " + f"{listed[0]}=0.7")
        if name not in network.classes("material"):
            raise UnknownName("--prior", name, network.classes("material"))
        try:
            given[name] = float(value)
        except ValueError:
            raise InvalidInput(f"--prior: {name}", value, "a probability between 0 and 1") from None
        if not 0 <= given[name] <= 1:
            raise InvalidInput(f"--prior: {name}", value, "a probability between 0 and 1")
    rest = [name for name in listed if name not in given]
    left = 1 - sum(given.values())
    if left < -1e-9 or (left > 1e-9 and not rest):
        raise InvalidInput("--prior", text, f"probabilities that sum to {'at most ' if rest else ''}1")
    return given | {name: max(left, 0.0) / len(rest) for name in rest}


def _object_file(name: str) -> Path:
    from dynamics.errors import UnknownName
    from models import objects

    try:
        return objects.locate(name)
    except KeyError:
        raise UnknownName("--object", name, (*objects.names(), "or the path of a TOML file")) from None


def _config(given: argparse.Namespace, object_file: Path, robot: Robot) -> dict[str, Any]:
    """Return the resolved configuration, enough to repeat or to resume the run."""
    from estimation.reestimation.description import describe
    from models.robot import gen3_mjcf
    from selection.result import versions

    return {
        "object": given.object,
        "object_file": object_file.read_text(encoding="utf-8"),
        "reference": given.reference,
        "prior": given.prior or "",
        "seed": given.seed,
        "noise": given.noise,
        "confidence": given.confidence,
        "budget_s": given.budget if math.isfinite(given.budget) else "none",
        "price_bits_per_s": given.price,
        "robot": given.robot,
        "model_sha256": hashlib.sha256(gen3_mjcf().encode()).hexdigest(),
        **describe(robot.arm, robot.gripper),
        "versions": versions(),
    }


def _take_up(given: argparse.Namespace) -> None:
    """Fill in the arguments of the run that is resumed."""
    from dynamics.tables import Table, read_toml

    path = given.resume / "config.toml"
    kept = Table(str(path), read_toml(path))
    for key in ("object", "reference", "noise", "robot"):
        setattr(given, key, kept.text(key))
    given.prior = kept.text("prior") or None
    given.seed = int(kept.number("seed"))
    given.confidence, given.price = kept.number("confidence"), kept.number("price_bits_per_s")


def _spent(decisions: Any) -> float:
    """Return the robot time between the first decision and the last, which found out what came before it [s]."""
    return decisions[-1].time - decisions[0].time if decisions else 0.0


def _watcher(quiet: bool) -> LiveTable | Lines | Silent:
    from selection.display import Lines, LiveTable, Silent

    if quiet:
        return Silent()
    return LiveTable() if sys.stdout.isatty() else Lines(sys.stdout)


def _report(exploration: Exploration, truth: Truth | None, directory: Path) -> None:
    """Print what the object was found to be, next to what it is if that is known."""
    from selection.display import likeliest, spoken

    name, probability = likeliest(exploration.belief)[0]
    really = f" (truth: {truth.material})" if truth else ""
    print(f"\nIt is most likely {name}, P = {probability:.3f}{really}; {exploration.seconds:.0f} s of robot time.")
    for quantity in exploration.belief.network.quantities:
        marginal = exploration.belief.marginal(quantity)
        value = spoken(marginal.mean, marginal.sd, marginal.unit)
        true = ""
        if truth and quantity in truth.properties:
            true = f"   (truth: {spoken(truth.properties[quantity], 0.0, truth.units[quantity])})".replace(
                " +- 0", ""
            )
        print(f"  {quantity:<11} {value}{true}")
    print(f"Kept in {directory}")


def _list() -> int:
    from models import objects, references

    print("objects:")
    for name in objects.names():
        print(f"  {name:<15} {objects.about(name)}")
    print("references:")
    for name in references.names():
        print(f"  {name}")
    return 0


def _probability(text: str) -> float:
    value = _number(text)
    if not 0 < value <= 1:
        raise argparse.ArgumentTypeError(f"{text!r} is not a probability in (0, 1]")
    return value


def _seed(text: str) -> int:
    if not text.isascii() or not text.isdigit() or len(text) > 18:
        raise argparse.ArgumentTypeError(f"{text!r} is not a seed: a whole number from 0 to 10^18")
    return int(text)


def _seconds(text: str) -> float:
    value = _number(text)
    if value < 0:
        raise argparse.ArgumentTypeError(f"{text!r} is negative")
    return value


def _number(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number") from None
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text!r} is not a finite number")
    return value


if __name__ == "__main__":
    sys.exit(main())
