"""Calibrate an arm's drives from recorded runs: ``python -m estimation.calibrate --help``."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from dynamics.arm import Arm
    from estimation.payload.drives import Drives
    from estimation.payload.motion_rows import MotionRows

EPILOG = """\
Without --reference or --gain, motor currents tell the links only in amperes: the gains then rest on the
masses of the robot's description, and their stated sd is large.
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Calibrate drive gains, friction and links from runs without a payload."""
    given = _parser().parse_args(arguments)
    from dynamics.command_line import interrupted
    from dynamics.errors import PalpateError

    try:
        _run(given)
    except (PalpateError, OSError) as error:
        sys.stderr.write(f"calibrate: {error}\n")
        return 2
    except KeyboardInterrupt:
        return interrupted("calibrate")
    return 0


def _run(given: argparse.Namespace) -> None:
    import logging

    from estimation.payload.drives_fit import calibrate_drives
    from estimation.payload.motion import estimate_payload_motion
    from estimation.payload.motion_rows import JointLog, motion_rows
    from estimation.readers import LogMap, read_log
    from estimation.reestimation.description import arm_named

    log = logging.getLogger(__name__)
    logging.basicConfig(level=logging.WARNING, format="calibrate: %(message)s")
    arm = arm_named(given.robot, given.tool_frame)
    columns = LogMap.from_file(given.map) if given.map else LogMap()
    rows: dict[str, MotionRows] = {}
    for path in (*given.unloaded, *given.reference, *given.check):
        if path not in rows:
            recording = read_log(path, columns, arm)
            if recording.rejections.count:
                first = "; ".join(recording.rejections.reasons)
                log.warning("%s: %d rows rejected: %s", path, recording.rejections.count, first)
            rows[path] = motion_rows(arm, JointLog.of(recording))
    drives = calibrate_drives(
        arm,
        [rows[path] for path in given.unloaded],
        [rows[path] for path in given.reference],
        given.mass,
        _numbers(given.gain),
    )
    sys.stdout.write(_table(arm, drives))
    for path in given.check:
        payload = estimate_payload_motion(rows[path], drives)
        low, high = payload.mass_interval
        sys.stdout.write(
            f"{Path(path).name}: {payload.mass:.3f} kg, 95 % [{low:.3f}, {high:.3f}]; {payload.verdict}\n"
        )
    if given.output is not None:
        drives.save(given.output)
        sys.stdout.write(f"written to {given.output}\n")


def _numbers(text: str | None) -> list[float] | None:
    from dynamics.errors import InvalidInput

    if text is None:
        return None
    try:
        return [float(value) for value in text.split(",")]
    except ValueError:
        raise InvalidInput("--gain", text, "numbers separated by commas, nan where unknown") from None


def _table(arm: Arm, drives: Drives) -> str:
    unit = "" if drives.effort_kind == "torque" else "N m/A"
    lines = [
        f"{'joint':24s} {'gain ' + unit:>16s} {'sd':>7s} {'Coulomb N m':>12s} {'viscous':>9s} {'noise N m':>10s}"
    ]
    columns = (
        drives.gain,
        drives.gain_sd,
        drives.friction("coulomb"),
        drives.friction("viscous"),
        drives.noise_sd,
    )
    for name, gain, sd, coulomb, viscous, noise in zip(arm.joint_names, *columns, strict=True):
        lines.append(f"{name:24s} {gain:16.3f} {sd:7.3f} {coulomb:12.3f} {viscous:9.3f} {noise:10.3f}")
    return "\n".join(lines) + "\n"


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m estimation.calibrate",
        description=main.__doc__,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--robot", required=True, help="a name such as gen3 or ur10, or a URDF or MJCF file")
    parser.add_argument("--tool-frame", default="", metavar="NAME", help="of a file; it holds the payload")
    parser.add_argument("--map", default="", metavar="FILE", help="what the columns of the logs mean (TOML)")
    parser.add_argument("--unloaded", required=True, nargs="+", metavar="LOG", help="runs without a payload")
    parser.add_argument("--reference", nargs="+", default=[], metavar="LOG", help="runs with a known payload")
    parser.add_argument("--mass", type=float, help="mass of that payload [kg]")
    parser.add_argument("--gain", metavar="K1,K2,...", help="known drive gains [N m/A], nan where unknown")
    parser.add_argument("--check", nargs="+", default=[], metavar="LOG", help="runs whose payload to estimate")
    parser.add_argument("--output", metavar="JSON", help="where to write the calibration")
    return parser


if __name__ == "__main__":
    raise SystemExit(main())
