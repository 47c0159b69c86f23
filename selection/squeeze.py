"""Squeeze an object on the bench: ``python -m selection.squeeze``."""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dynamics.command_line import FAILED, ended
from selection.squeeze_arguments import object_text, parser, strokes_of, take_preset

if TYPE_CHECKING:
    from dynamics.bench import SqueezeBench, Stroke
    from dynamics.objects import DeclaredObject
    from selection.robots import OpenedBench
    from selection.squeezes import Squeezed


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return its exit code."""
    command = parser()
    given = command.parse_args(arguments)
    if given.list:
        return _list()
    return ended(command.prog, lambda: _squeeze(given))


def _squeeze(given: argparse.Namespace) -> int:
    """Check everything, then squeeze and show; nothing is written before all of it is known to be usable."""
    from estimation.recording import RunWriter
    from selection.squeeze_display import lines, result_of
    from selection.squeeze_plot import plot
    from selection.squeezes import rate_term, squeeze_all

    take_preset(given)
    with _object(given) as (text, mesh, declared, opened):
        bench = opened.bench
        strokes = strokes_of(given, declared, bench.edge)
        directory = given.out or Path("runs") / f"{time.strftime('%Y%m%d-%H%M%S')}-{declared.name}"
        config = configuration(given, text, bench, strokes) | mesh
        with RunWriter.create(directory, config, declared.name) as run:
            squeezes: list[Squeezed] = []
            for squeezed in squeeze_all(bench, declared, strokes, run):
                squeezes.append(squeezed)
                if not given.quiet:
                    print("\n".join(lines(len(squeezes), squeezed, opened.truth, opened.rigid)), flush=True)
            rate = rate_term(squeezes)
            run.finish(result_of(declared.name, squeezes, rate, opened.truth))
        pictures: tuple[Path, ...] = ()
        if not given.no_pictures:
            pictures = plot(directory, squeezes, opened.truth, f"{declared.name}, {given.plates}")
    if not given.quiet:
        if rate is not None:
            kind = "depends on the strain rate" if rate.significant else "does not depend on the strain rate"
            print(
                f"{kind}: E = {rate.modulus / 1e3:.4g} kPa (rate / {rate.reference:.3g} /s)^p, "
                f"p = {rate.exponent:.4f} +- {rate.exponent_sd:.4f}"
            )
        print(f"recorded in {directory}" + "".join(f", {path.name}" for path in pictures))
    return 0 if any(s.estimate is not None for s in squeezes) else FAILED


@contextmanager
def _object(given: argparse.Namespace) -> Iterator[tuple[str, dict[str, Any], DeclaredObject, OpenedBench]]:
    """Open the bench with the object that is asked for; what is refused is told by the object's name."""
    from dynamics.errors import InvalidInput
    from dynamics.objects import read_declared
    from estimation.reestimation import mesh_of, write_mesh
    from selection.robots import BenchRequest, open_bench

    source, text = object_text(given)
    changed, mesh = text != source.read_text(encoding="utf-8"), mesh_of(source)
    with tempfile.TemporaryDirectory(prefix="palpate-") as folder:
        path = source
        if changed:
            path = Path(folder) / source.name
            path.write_text(text, encoding="utf-8")
            write_mesh(path.parent, mesh.get("object_mesh", {}))
        try:
            request = BenchRequest(
                path, given.plates, "fast" if given.fast else "accurate", given.fidelity, given.noise, given.seed
            )
            opened, declared = open_bench(request), read_declared(path)
        except InvalidInput as error:
            if not changed:
                raise
            where = error.where.replace(str(path), f"{given.object}, as changed")
            raise InvalidInput(where, error.found, error.valid) from None
        yield text, mesh, declared, opened


def configuration(
    given: argparse.Namespace, text: str, bench: SqueezeBench, strokes: list[Stroke]
) -> dict[str, Any]:
    """Return what the squeezes were asked for, enough to repeat and to re-estimate them."""
    from estimation.reestimation import describe_bench
    from selection.result import versions
    from selection.squeezes import stroke_table

    return {
        "object": given.object,
        "object_file": text,
        "preset": given.preset,
        "robot": "bench",
        "plates": given.plates,
        "fidelity": given.fidelity,
        "setting": "fast" if given.fast else "accurate",
        "noise": given.noise,
        "seed": given.seed,
        "strokes": [stroke_table(stroke) for stroke in strokes],
        **describe_bench(bench.gripper, bench.edge),
        "versions": versions(),
    }


def _list() -> int:
    from models import objects
    from selection.squeeze_presets import PRESETS

    print("objects:")
    for name in objects.names():
        print(f"  {name:<15} {objects.about(name)}")
    print("presets:")
    for one in PRESETS.values():
        print(f"  {one.name:<15} {one.about}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
