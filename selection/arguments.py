"""What the command line of a run takes, and what is refused there."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from dynamics.command_line import WRONG_INPUT

if TYPE_CHECKING:
    from selection.robots import RobotRequest

DEFAULT_OBJECT = "soft-cube"
DEFAULT_REFERENCE = "soft-cubes"


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    made = OneLineParser(
        prog="python -m selection.run",
        description="Explore an object until it is known well enough.",
        epilog="Exit status: 0 done, or with --dry-run: the next action can be done; 1 failed, or the arm is not "
        "safe to move; 2 wrong input or no robot; 130 interrupted.",
    )
    made.add_argument("--object", default=DEFAULT_OBJECT, metavar="NAME|FILE.toml", help="object on the table")
    made.add_argument(
        "--reference", default=DEFAULT_REFERENCE, metavar="NAME|FILE.json", help="what is known of materials"
    )
    made.add_argument(
        "--prior",
        metavar="uniform|NAME=P,...",
        help="probabilities of materials beforehand; what is not named shares the rest",
    )
    made.add_argument("--seed", type=seed, default=0, metavar="N", help="of everything random in the simulation")
    made.add_argument("--out", type=Path, metavar="DIR", help="run directory (default: runs/<time>-<object>)")
    made.add_argument(
        "--noise", default="default", metavar="default|none|FILE", help="errors of the simulated sensors"
    )
    made.add_argument(
        "--target",
        default="material",
        metavar="NAME",
        help="what to learn about: material, category, both, a property, or everything",
    )
    made.add_argument(
        "--fidelity",
        choices=("uniform", "indentation"),
        default="uniform",
        help="a simulated object is strained evenly, or sinks in under the pads",
    )
    made.add_argument(
        "--confidence",
        type=_probability,
        default=0.99,
        metavar="P",
        help="stop when a material is as probable as this",
    )
    made.add_argument(
        "--budget", type=_seconds, default=math.inf, metavar="SECONDS", help="robot time to spend at most"
    )
    made.add_argument(
        "--price", type=_seconds, default=0.005, metavar="BITS", help="what a second of robot time is worth"
    )
    made.add_argument("--robot", default="sim", metavar="sim|kortex", help="which robot explores")
    made.add_argument("--revision", choices=("V12", "BRAKES"), default="V12", help="hardware of the arm")
    made.add_argument("--no-vision", action="store_true", help="the arm has no vision module")
    made.add_argument(
        "--vision",
        default="default",
        metavar="default|none|FILE.json",
        help="what the camera sees: drawn by the reference's confusion matrix, nothing, or as a file says",
    )
    made.add_argument(
        "--lookahead",
        choices=("auto", "never"),
        default="auto",
        help="plan two steps ahead where that is worthwhile, or never (%(default)s)",
    )
    made.add_argument(
        "--save-as",
        metavar="NAME",
        help="keep an object that is no listed material as one, in a copy of the reference",
    )
    made.add_argument("--resume", type=Path, metavar="DIR", help="go on with an interrupted run")
    made.add_argument(
        "--dry-run", action="store_true", help="plan and check the next action; move and write nothing"
    )
    made.add_argument(
        "--view",
        nargs="?",
        type=_speed,
        const=1.0,
        metavar="SPEED",
        help="open a viewer; 1: real time (default)",
    )
    made.add_argument(
        "--pictures",
        action=argparse.BooleanOptionalAction,
        help="keep pictures of a simulated run in it (default: unless --quiet)",
    )
    made.add_argument("--video", type=_video, metavar="FILE.webp|gif|png", help="write a film of a simulated run")
    made.add_argument("--no-report", action="store_true", help="write no report.html, figures and tables")
    made.add_argument("--list", action="store_true", help="list objects and references, and end")
    made.add_argument("--quiet", action="store_true", help="print nothing but errors")
    real = made.add_argument_group("for --robot kortex")
    real.add_argument("--host", default="", metavar="H", help="name or address of the arm")
    real.add_argument("--port", type=_port, default=10000, metavar="N", help="its TCP port (%(default)s)")
    real.add_argument("--udp-port", type=_port, default=10001, metavar="N", help="its UDP port (%(default)s)")
    real.add_argument("--offsets", type=Path, metavar="FILE", help="tare of its torque sensors, by hw.check")
    real.add_argument(
        "--load-spread",
        choices=("pad", "face"),
        default="pad",
        help="pads indent the object, or compress its whole face as in the emulator's simulation",
    )
    real.add_argument("--yes", action="store_true", help="do not ask before the first motion")
    return made


class OneLineParser(argparse.ArgumentParser):
    """Reports wrong arguments on one line."""

    def error(self, message: str) -> NoReturn:
        """Say what is wrong, and end."""
        self.exit(WRONG_INPUT, f"{self.prog}: {message}\n")


def robot_request(given: argparse.Namespace, object_file: Path) -> RobotRequest:
    """Return which robot the arguments ask for."""
    from selection.robots import RobotRequest

    return RobotRequest(
        object_file,
        noise=given.noise,
        seed=given.seed,
        revision=given.revision,
        vision=not given.no_vision,
        host=given.host,
        tcp_port=given.port,
        udp_port=given.udp_port,
        tare=given.offsets,
        load_spread=given.load_spread,
        fidelity=given.fidelity,
        yes=given.yes,
        draws=wants_pictures(given) or given.video is not None,
        dry_run=given.dry_run,
    )


def wants_pictures(given: argparse.Namespace) -> bool:
    """Tell whether the arguments ask for pictures."""
    return bool(not given.quiet if given.pictures is None else given.pictures)


def object_file(name: str) -> Path:
    """Return the file of an object given by name or path.

    Raises:
        UnknownName: if it is neither.
    """
    from dynamics.errors import UnknownName
    from models import objects

    try:
        return objects.locate(name)
    except KeyError:
        raise UnknownName("--object", name, (*objects.names(), "or the path of a TOML file")) from None


def _probability(text: str) -> float:
    value = _number(text)
    if not 0 < value <= 1:
        raise argparse.ArgumentTypeError(f"{text!r} is not a probability in (0, 1]")
    return value


def seed(text: str) -> int:
    """Read the seed of everything random off an argument."""
    if not text.isascii() or not text.isdigit() or len(text) > 18:
        raise argparse.ArgumentTypeError(f"{text!r} is not a seed: a whole number from 0 to 10^18")
    return int(text)


def _port(text: str) -> int:
    if not text.isascii() or not text.isdigit() or not 0 < int(text[:6]) < 1 << 16:
        raise argparse.ArgumentTypeError(f"{text!r} is not a port from 1 to 65535")
    return int(text)


def _speed(text: str) -> float:
    value = _number(text)
    if not 0.01 <= value <= 1000:
        raise argparse.ArgumentTypeError(f"{text!r} is not a speed from 0.01 to 1000")
    return value


def _video(text: str) -> Path:
    path = Path(text)
    if path.suffix.lower() not in (".webp", ".gif", ".png"):
        raise argparse.ArgumentTypeError(f"{text!r} does not end in .webp, .gif or .png")
    if not path.parent.is_dir():
        raise argparse.ArgumentTypeError(f"{text!r} is not in a folder that exists")
    return path


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
