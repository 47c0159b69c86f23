"""Explore one object: ``python -m selection.run``."""

from __future__ import annotations

import argparse
import sys
import time
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

from dynamics.command_line import FAILED, ended
from selection.arguments import object_file, parser, robot_request, wants_pictures

if TYPE_CHECKING:
    from estimation.recording import Recording
    from selection.display import Lines, LiveTable, Silent
    from selection.exploration import Exploration
    from selection.stand_in import StandIn


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return its exit code."""
    command = parser()
    given = command.parse_args(arguments)
    if given.list:
        return _list()
    return ended(command.prog, lambda: _explore(given))


def _explore(given: argparse.Namespace) -> int:
    """Check everything, then explore; nothing is written before all of it is known to be usable."""
    from dynamics.errors import UnknownName
    from dynamics.objects import read_declared
    from estimation.belief import Belief
    from estimation.network import Network
    from estimation.novelty import check_name, save_class
    from estimation.prior import parse_prior
    from estimation.recording import RunWriter, read_recording
    from selection.actions import repertoire
    from selection.configuration import configuration, take_up
    from selection.display import report
    from selection.exploration import Exploration, Settings
    from selection.eyes import chosen_senses, read_vision
    from selection.information import targets
    from selection.result import result_of
    from selection.robots import open_robot
    from selection.sights import Sights, Together
    from selection.stand_in import StandIn

    past = saved = None
    if given.resume is not None:
        take_up(given)
        past = read_recording(given.resume)
    source = object_file(given.object)
    network = Network.from_file(given.reference)
    prior = parse_prior(given.prior, network, "--prior")
    if given.target not in targets(network):
        raise UnknownName("--target", given.target, targets(network))
    eyes = None
    if given.vision not in ("default", "none"):
        eyes = read_vision(Path(given.vision), network)
        Belief(network, prior).update_class(eyes.observation.variable, eyes.observation.by_class)
    if given.save_as is not None:
        check_name(network, given.save_as)
    declared = read_declared(source)
    opened = open_robot(given.robot, robot_request(given, source))
    watcher = _watcher(given.quiet, plain=given.dry_run)
    recorded: Path | None = None
    try:
        settings = Settings(given.target, given.price, given.confidence, given.budget, given.lookahead == "auto")
        actions = repertoire(chosen_senses(opened.senses(network), eyes, given.vision, not given.no_vision))
        if given.dry_run:
            stand_in = StandIn(opened.robot, declared, opened.judge)
            exploration = Exploration(stand_in, declared, network, prior, settings, watcher, actions)
            return _rehearse(exploration, stand_in, past, given.quiet)
        sights = Sights(opened, given.view, wants_pictures(given), given.video, _say)
        together = Together(watcher, sights)
        exploration = Exploration(opened.robot, declared, network, prior, settings, together, actions)
        directory = given.resume or given.out or Path("runs") / f"{time.strftime('%Y%m%d-%H%M%S')}-{declared.name}"
        names = opened.robot.arm.joint_names
        if past is None:
            run = RunWriter.create(directory, configuration(given, source, opened.robot), declared.name, names)
        else:
            run = RunWriter.resume(directory, names)
        recorded = None if given.no_report else directory
        with run, closing(sights):
            exploration.record(run)
            exploration.on_phase(sights.phase)
            sights.keep_in(directory)
            if past is not None:
                exploration.recall(past)
            try:
                exploration.explore()
            except BaseException:
                opened.robot.stop()
                raise
            if given.save_as is not None:
                saved = save_class(exploration.belief, given.save_as, directory)
            run.finish(result_of(exploration, declared.name, opened.truth))
    finally:
        watcher.close()
        opened.robot.close()
        if recorded is not None:
            _write_page(recorded)
    if not given.quiet:
        report(exploration, opened.truth, directory, sys.stdout)
        if given.save_as is not None:
            print(_kept(given.save_as, saved))
    return 0


def _write_page(directory: Path) -> None:
    """Write the page of a run, however it ended; the run itself is on disk already."""
    try:
        from selection.reporting import write_run_report

        write_run_report(directory)
    except Exception as error:  # whatever is wrong with a page must not make a run look failed
        print(f"no report.html: {error}; try python -m selection.report {directory}", file=sys.stderr)


def _rehearse(exploration: Exploration, robot: StandIn, past: Recording | None, quiet: bool) -> int:
    """Go through the motions of the next action in thought; tell whether it can be done."""
    from selection.rehearsal import Rehearsed, told

    if past is not None:
        exploration.recall(past)
    status = 0
    for action, phases, problem in exploration.rehearse():
        status = FAILED if problem else 0
        if not quiet:
            print(*told(Rehearsed(action, tuple(robot.moves), phases, problem)), sep="\n")
        robot.moves.clear()
    return status


def _say(line: str) -> None:
    print(line, file=sys.stderr)


def _watcher(quiet: bool, plain: bool) -> LiveTable | Lines | Silent:
    from selection.display import Lines, LiveTable, Silent

    if quiet:
        return Silent()
    return LiveTable() if sys.stdout.isatty() and not plain else Lines(sys.stdout)


def _kept(name: str, file: Path | None) -> str:
    if file is None:
        return f"Nothing was saved as {name}: a listed material explains the object better than none."
    return f"Saved as {name}; to recognise it: --reference {file}"


def _list() -> int:
    from models import objects, references

    print("objects:")
    for name in objects.names():
        print(f"  {name:<15} {objects.about(name)}")
    print("references:")
    for name in references.names():
        print(f"  {name}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
