"""``python -m estimation.store``: list, show, export and learn from the runs of this machine."""

from __future__ import annotations

import argparse
import csv
import io
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from dynamics.command_line import interrupted
from dynamics.errors import InvalidInput, PalpateError
from estimation.ipalm.lists import from_list, to_list
from estimation.recording import read_recording
from estimation.recording.files import write_atomically
from estimation.store import Observation, Run, Store, learn_classes, reference_content

USAGE = """examples:
  python -m estimation.store list foam --since 2026-11
  python -m estimation.store show 20261122-101500-cube
  python -m estimation.store export --format csv --out measurements.csv
  python -m estimation.store learn --class cube=foam --class ball=rubber --out mine.json"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return its exit code."""
    given = _parser().parse_args(arguments)
    try:
        with Store(given.runs) as store:
            store.refresh()
            given.command(store, given)
    except PalpateError as error:
        print(f"estimation.store: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return interrupted("estimation.store")
    except BrokenPipeError:
        return 0
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m estimation.store",
        description="Search, export and learn from the runs of this machine.",
        epilog=USAGE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--runs", type=Path, default=Path("runs"), metavar="DIR", help="folder of runs (default: runs)"
    )
    commands = parser.add_subparsers(required=True)
    listing = commands.add_parser("list", help="runs, oldest first")
    listing.add_argument(
        "text", nargs="?", default="", help="to be found in name, object, material or configuration"
    )
    listing.add_argument("--object", default="", metavar="NAME", help="exactly this object")
    listing.add_argument(
        "--since", default="", metavar="TIME", help="begun at this time or later, such as 2026-11-03"
    )
    listing.add_argument("--json", action="store_true")
    listing.set_defaults(command=_list)
    showing = commands.add_parser("show", help="one run: configuration, measurements, belief")
    showing.add_argument("run")
    showing.add_argument("--json", action="store_true")
    showing.set_defaults(command=_show)
    export = commands.add_parser("export", help="measurements, for others")
    export.add_argument("run", nargs="*", help="runs to export (default: all)")
    export.add_argument("--format", choices=("ipalm", "csv"), default="ipalm")
    export.add_argument("--property", default="", metavar="NAME", help="only this property (csv)")
    export.add_argument("--out", type=Path, metavar="FILE", help="default: standard output")
    export.set_defaults(command=_export)
    learn = commands.add_parser("learn", help="a reference file: mean and sd of every class and property")
    learn.add_argument("--class", dest="classes", action="append", default=[], metavar="OBJECT=MATERIAL")
    learn.add_argument("--also", type=Path, action="append", default=[], metavar="LIST", help="a measurement list")
    learn.add_argument("--name", default="learned")
    learn.add_argument("--out", type=Path, required=True, metavar="FILE")
    learn.set_defaults(command=_learn)
    return parser


def _list(store: Store, given: argparse.Namespace) -> None:
    runs = store.runs(given.text, given.object, given.since)
    if given.json:
        print(json.dumps([_run_data(run) for run in runs], indent=2))
        return
    for run in runs:
        result = f"{run.material} {run.probability:.2f}" if run.material and run.probability is not None else "-"
        seconds = "-" if run.seconds is None else f"{run.seconds:.0f} s"
        started = run.started[:19].replace("T", " ")
        print(f"{run.name:40}  {started:19}  {run.object_name:20}  {run.state:11}  {seconds:>7}  {result}")
    print(f"{len(runs)} runs", file=sys.stderr)


def _show(store: Store, given: argparse.Namespace) -> None:
    run = store.run(given.run)
    recording = None if run.state == "unreadable" else read_recording(store.folder / run.name)
    belief = recording.beliefs[-1].data if recording and recording.beliefs else {}
    found = store.measurements([run.name])
    if given.json:
        listed = [{"time": f.time, "action": f.action, **vars(f.measurement)} for f in found]
        print(json.dumps({**_run_data(run), "measurements": listed, "belief": belief}, indent=2))
        return
    print(f"{run.name}: {run.object_name}, {run.state}, begun {run.started or 'unknown'}")
    if run.problem:
        print(f"  note: {run.problem}")
    for key, value in run.config.items():
        print(f"  {key} = {json.dumps(value)}")
    for one in found:
        m = one.measurement
        print(f"  {one.time:9.2f} s  {one.action:10} {m.property:12} {m.mean:.6g} +- {m.sd:.2g} {m.unit}")
    for variable, values in belief.items():
        if isinstance(values, dict) and all(isinstance(p, int | float) for p in values.values()):
            best = sorted(values.items(), key=lambda item: -item[1])[:5]
            print(f"  {variable}: " + ", ".join(f"{name} {p:.3f}" for name, p in best))


def _export(store: Store, given: argparse.Namespace) -> None:
    runs = [store.run(name).name for name in given.run] or None
    if given.format == "ipalm":
        text = to_list(store.objects(runs))
    else:
        buffer = io.StringIO(newline="")
        table = csv.writer(buffer)
        table.writerow(["run", "object", "time_s", "action", "property", "mean", "sd", "unit"])
        for f in store.measurements(runs, given.property):
            m = f.measurement
            table.writerow([f.run, f.object_name, f.time, f.action, m.property, repr(m.mean), repr(m.sd), m.unit])
        text = buffer.getvalue()
    if given.out is None:
        sys.stdout.write(text)
    else:
        write_atomically(given.out, text)


def _learn(store: Store, given: argparse.Namespace) -> None:
    classes = {}
    for pair in given.classes:
        name, equals, material = pair.partition("=")
        if not (name and equals and material):
            raise InvalidInput("--class", pair, "OBJECT=MATERIAL")
        classes[name] = material
    observed = [(f.object_name, f.measurement) for f in store.measurements()]
    for path in given.also:
        try:
            read = from_list(path.read_text(encoding="utf-8"), str(path))
        except (OSError, UnicodeDecodeError) as error:
            raise InvalidInput(str(path), str(error), "a measurement list") from None
        for note in read.notes:
            print(f"estimation.store: {note}", file=sys.stderr)
        observed += [(item.name, m) for item in read.objects for m in item.measurements]
    rows = [Observation(name, classes.get(name, name), m) for name, m in observed]
    learned = learn_classes(rows)
    content = reference_content(given.name, learned, f"learned from {len(rows)} measurements")
    write_atomically(given.out, json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False) + "\n")
    for one in learned:
        used = "" if one.property in content["properties"] else "  (left out: not known of every class)"
        number = f"{one.objects} objects, {one.readings} readings"
        print(f"{one.material:20} {one.property:12} {one.mean:.6g} +- {one.sd:.2g} {one.unit}  {number}{used}")


def _run_data(run: Run) -> dict[str, Any]:
    return vars(run) | {"config": dict(run.config)}


if __name__ == "__main__":
    sys.exit(main())
