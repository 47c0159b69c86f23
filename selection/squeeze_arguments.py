"""What the command line of the bench takes, what is refused there, and the strokes that follow."""

from __future__ import annotations

import argparse
import math
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any

from selection.arguments import DEFAULT_OBJECT, OneLineParser, _number, object_file, seed

if TYPE_CHECKING:
    from dynamics.bench import Stroke
    from dynamics.objects import DeclaredObject

DEFAULT_SPEED = 0.005  # m/s
DEFAULT_STRAIN = 0.1  # of the object's width, to which it is squeezed
MOST_STRAIN = 0.5
MOST_STROKES = 100


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    made = OneLineParser(
        prog="python -m selection.squeeze",
        description="Squeeze an object between two plates in simulation, and see what its stiffness comes out as.",
    )
    made.add_argument("--object", metavar="NAME|FILE.toml", help=f"what to squeeze (default: {DEFAULT_OBJECT})")
    made.add_argument("--young", type=_positive, metavar="PA", help="Young's modulus in place of the object's")
    made.add_argument("--mass", type=_positive, metavar="KG", help="mass in place of the object's")
    made.add_argument("--size", type=_lengths, metavar="M[,M,M]", help="edges in place of the object's: a box")
    made.add_argument("--preset", metavar="NAME", help="one of the thesis' squeezes; --list shows them")
    made.add_argument(
        "--plates", choices=("pads", "full"), default="pads", help="pads of the 2F-85, or larger ones"
    )
    made.add_argument(
        "--speed", type=_positive, nargs="+", metavar="M/S", help=f"of closing, one or several ({DEFAULT_SPEED})"
    )
    how = made.add_mutually_exclusive_group()
    how.add_argument(
        "--depth",
        type=_positive,
        nargs="+",
        metavar="M",
        help="compression, one or several (a tenth of the width)",
    )
    how.add_argument(
        "--end",
        type=_number,
        nargs="+",
        metavar="M",
        help="place that each plate is driven to, from the middle, negative beyond it; its drive gives",
    )
    made.add_argument("--drive", type=_positive, metavar="N/M", help="stiffness of each plate's drive, for --end")
    made.add_argument("--max-force", type=_positive, default=math.inf, metavar="N", help="at which closing stops")
    made.add_argument("--noise", default="none", metavar="default|none|FILE", help="errors of the sensors")
    made.add_argument("--seed", type=seed, default=0, metavar="N", help="of the sensors' errors")
    made.add_argument("--fidelity", choices=("uniform", "indentation"), default="uniform", help="how it deforms")
    made.add_argument("--fast", action="store_true", help="steps of 4 ms instead of 2")
    made.add_argument("--out", type=Path, metavar="DIR", help="run directory (default: runs/<time>-<object>)")
    made.add_argument("--no-pictures", action="store_true", help="draw nothing")
    made.add_argument("--list", action="store_true", help="list objects and presets, and end")
    made.add_argument("--quiet", action="store_true", help="print nothing but errors")
    return made


def take_preset(given: argparse.Namespace) -> None:
    """Fill in what a preset says.

    Raises:
        InvalidInput: for an unknown preset, or one beside an object or a depth of one's own.
    """
    from dynamics.errors import InvalidInput
    from selection.squeeze_presets import DRIVE, SPEED, preset

    if given.preset is not None:
        chosen = preset(given.preset)
        for name in ("object", "young", "mass", "size", "depth", "end"):
            if getattr(given, name) is not None:
                raise InvalidInput(f"--{name}", getattr(given, name), "nothing beside --preset, which says it")
        given.object, given.end = chosen.object, [chosen.end]
        given.speed = given.speed or [SPEED]
    if given.end is None and given.drive is not None:
        raise InvalidInput("--drive", given.drive, "a drive for --end; with --depth it does not give")
    given.drive = given.drive or (DRIVE if given.end is not None else None)
    given.object = given.object or DEFAULT_OBJECT
    given.speed = given.speed or [DEFAULT_SPEED]


def strokes_of(given: argparse.Namespace, declared: DeclaredObject, edge: int) -> list[Stroke]:
    """Return the strokes that are asked for: every depth or end at every speed.

    Raises:
        InvalidInput: for a speed, depth or end out of range.
    """
    from dynamics.bench import SPEEDS, Stroke
    from dynamics.errors import InvalidInput

    width = declared.size[edge]
    for speed in given.speed:
        if not SPEEDS[0] <= speed <= SPEEDS[1]:
            raise InvalidInput("--speed [m/s]", speed, f"{SPEEDS[0]:g} to {SPEEDS[1]:g}")
    targets = []
    for depth in given.depth or ([] if given.end else [DEFAULT_STRAIN * width]):
        if depth > MOST_STRAIN * width:
            raise InvalidInput("--depth [m]", depth, f"above 0, to {MOST_STRAIN * width:.4g}: half the width")
        targets.append(width - depth)
    for end in given.end or []:
        if not -0.1 <= end < width / 2:
            raise InvalidInput("--end [m]", end, f"-0.1 to {width / 2:.4g}: half the width")
        targets.append(2 * end)
    if len(targets) * len(given.speed) > MOST_STROKES:
        raise InvalidInput("--speed, --depth", len(targets) * len(given.speed), f"at most {MOST_STROKES} squeezes")
    return [
        Stroke(speed, target, stiffness=given.drive, max_force=given.max_force)
        for speed in given.speed
        for target in targets
    ]


def object_text(given: argparse.Namespace) -> tuple[Path, str]:
    """Return the file of the object and its text, with what the arguments put in place of the object's.

    Raises:
        InvalidInput: for an object that is not there or not TOML.
    """
    from dynamics.errors import InvalidInput
    from estimation.recording.files import to_toml

    source = object_file(given.object)
    try:
        text = source.read_text(encoding="utf-8")
        table: dict[str, Any] = tomllib.loads(text)
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise InvalidInput(str(source), str(error), "a TOML file of an object") from None
    declared, truth = dict(table.get("declared", {})), dict(table.get("truth", {}))
    if (given.young, given.mass, given.size) == (None, None, None) and "mesh" not in declared:
        return source, text
    declared.setdefault("name", source.stem)
    if isinstance(declared.get("mesh"), str):  # the text is read elsewhere
        declared["mesh"] = str((source.parent / declared["mesh"]).resolve())
    if given.young is not None:
        truth["young_modulus_pa"] = given.young
    if given.mass is not None:
        truth["mass_kg"] = given.mass
    if given.size is not None:
        if declared.get("shape", "box") != "box":
            raise InvalidInput("--size", given.size, "nothing: its shape is not a box")
        declared["size_m"] = list(given.size)
        truth.pop("size_m", None)
    return source, to_toml("object", {**table, "declared": declared, "truth": truth})


def _positive(text: str) -> float:
    value = _number(text)
    if value <= 0:
        raise argparse.ArgumentTypeError(f"{text!r} is not above 0")
    return value


def _lengths(text: str) -> tuple[float, float, float]:
    values = [_positive(part) for part in text.split(",")]
    if len(values) == 1:
        values *= 3
    if len(values) != 3:
        raise argparse.ArgumentTypeError(f"{text!r} is not one length or three with commas between")
    return values[0], values[1], values[2]
