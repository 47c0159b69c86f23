"""Look at the arm before trusting it: ``python -m hw.check --host H``."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from dynamics.command_line import interrupted
from dynamics.errors import InvalidInput, PalpateError

if TYPE_CHECKING:
    from hw.kortex_robot import KortexRobot
    from hw.preflight import CheckReport

LOOSE = (4.0, 4.0, 4.0, 4.0, 2.0, 2.0, 2.0)  # N m; public offsets of untared joints reach 2.5
SAFE, UNSAFE, WRONG = 0, 1, 2


def main(arguments: list[str] | None = None) -> int:
    """Connect, read, and print what there is to know; return 0 if the arm is safe to move, 1 if not."""
    given = _parser().parse_args(arguments)
    try:
        return _run(given)
    except PalpateError as error:
        sys.stderr.write(f"python -m hw.check: {error}\n")
        return WRONG
    except KeyboardInterrupt:
        return interrupted("python -m hw.check")


def _run(given: argparse.Namespace) -> int:
    from hw.connect import ask
    from hw.credentials import credentials
    from hw.kortex.errors import CheckFailed
    from hw.kortex_robot import KortexRobot
    from hw.preflight import TOLERANCES
    from hw.settings import KortexSettings
    from hw.torque_tare import TorqueTare

    if not (given.seconds >= 0.1 and given.seconds <= 3600):
        raise InvalidInput("--seconds", given.seconds, "0.1 to 3600")
    tare = None if given.offsets is None else TorqueTare.load(given.offsets)
    settings = KortexSettings(
        revision=given.revision,
        vision=not given.no_vision,
        tcp_port=given.port,
        udp_port=given.udp_port,
        tare=tare,
        dry_run=given.dry_run,
        torque_tolerance=LOOSE if given.tare or given.zero_torques else TOLERANCES,
    )
    confirm = (lambda question: True) if given.yes else ask
    try:
        with KortexRobot(given.host, credentials(), settings, confirm) as robot:
            report = robot.check()
            robot.hold(given.seconds)
            _print(report, robot)
            if given.zero_torques:
                _zero(robot, confirm)
            if given.tare:
                _tare(robot, given.tare)
            return UNSAFE if report.problems else SAFE
    except CheckFailed as error:
        sys.stdout.write("".join(f"  unsafe: {problem}\n" for problem in error.problems))
        return UNSAFE


def _print(report: CheckReport, robot: KortexRobot) -> None:
    out = sys.stdout
    for name, value in report.facts:
        out.write(f"{name + ':':15}{value}\n")
    read = robot.statistics
    out.write(
        f"feedback:      {read.rate:.0f} Hz over {read.seconds:.1f} s, "
        f"longest gap {1000 * read.longest_gap:.0f} ms, {read.repeats} datagrams repeated\n"
    )
    torques = report.torques
    out.write(f"torques [N m]: joint  measured  {torques.revision} model  difference  tolerance\n")
    rows = zip(torques.measured, torques.modelled, torques.tolerance, strict=True)
    for joint, (measured, modelled, tolerance) in enumerate(rows, start=1):
        out.write(
            f"               {joint:5}  {measured:8.2f}  {modelled:9.2f}  {measured - modelled:10.2f}"
            f"  {tolerance:9.2f}\n"
        )
    misfits = ", ".join(f"{name} {misfit:.2f}" for name, misfit in torques.misfit.items())
    out.write(f"misfit [N m]:  {misfits}\n")
    for kind, lines in (("warning", report.warnings), ("unsafe", report.problems)):
        out.write("".join(f"  {kind}: {line}\n" for line in lines))
    out.write("not safe to move\n" if report.problems else "safe to move, as far as this can tell\n")


def _zero(robot: KortexRobot, confirm: object) -> None:
    """Zero the torque sensors, guided."""
    sys.stdout.write(
        "Zeroing the torque sensors\n"
        "  1. take the gripper off: zeroed with it, the sensors are seen to drift\n"
        "  2. bring the arm into the candle pose, all joints at 0, by its joystick or web page\n"
        "  3. let it stand still\n"
    )
    if not callable(confirm) or not confirm("Is the arm in the candle pose, without gripper and still?"):
        sys.stdout.write("nothing was changed\n")
        return
    left = robot.zero_torques()
    sys.stdout.write(f"  torques now: {', '.join(f'{torque:+.3f}' for torque in left)} N m\n")


def _tare(robot: KortexRobot, path: Path) -> None:
    """Move through a few poses and write the offsets of the torque sensors."""
    from hw.torque_tare import fit_tare, visit_poses

    if robot.settings.dry_run:
        raise InvalidInput("--tare", "a dry run", "a run that may move")
    tare = fit_tare(robot.arms, robot.settings.revision, *visit_poses(robot))
    if tare.likelier is not None:
        raise PalpateError(
            f"over {tare.poses} poses the torques are those of a {tare.likelier} arm (misfit "
            f"{tare.misfit[tare.likelier]:.3f} N m), not of a {tare.revision} ({tare.misfit[tare.revision]:.3f} "
            f"N m): give --revision {tare.likelier}; nothing was written"
        )
    tare.save(path)
    sys.stdout.write(f"torque offsets [N m]: {', '.join(f'{torque:+.3f}' for torque in tare.offset)}\n")
    told = f"are those of a {tare.revision} arm" if tare.telling else "do not tell the hardware revision"
    sys.stdout.write(f"the torques {told}; written to {path}\n")


def _parser() -> argparse.ArgumentParser:
    from hw.kortex.ports import TCP_PORT, UDP_PORT
    from models.robot import REVISIONS

    parser = argparse.ArgumentParser(
        prog="python -m hw.check",
        description="Connect to a Gen3, read it, and print state, faults, torques against the model, and what "
        "would be unsafe. The gripper must be empty. Nothing moves unless --tare is given.",
        epilog="User and password come from PALPATE_KORTEX_USER and PALPATE_KORTEX_PASSWORD, or are asked for. "
        "Exit status: 0 safe to move, 1 not, 2 no arm or wrong input.",
    )
    parser.add_argument("--host", required=True, help="name or address of the arm")
    parser.add_argument("--port", type=int, default=TCP_PORT, help="TCP port (%(default)s)")
    parser.add_argument("--udp-port", type=int, default=UDP_PORT, help="UDP port (%(default)s)")
    parser.add_argument("--revision", choices=REVISIONS, default="V12", help="hardware of the arm (%(default)s)")
    parser.add_argument("--no-vision", action="store_true", help="the arm has no vision module")
    parser.add_argument("--seconds", type=float, default=2.0, help="how long to read (%(default)s)")
    parser.add_argument("--offsets", type=Path, metavar="FILE", help="tare of the torque sensors to apply")
    parser.add_argument("--tare", type=Path, metavar="FILE", help="move through six poses and write a tare")
    parser.add_argument("--zero-torques", action="store_true", help="zero the torque sensors in the candle pose")
    parser.add_argument("--dry-run", action="store_true", help="move nothing")
    parser.add_argument("--yes", action="store_true", help="do not ask before the first motion")
    return parser


if __name__ == "__main__":
    sys.exit(main())
