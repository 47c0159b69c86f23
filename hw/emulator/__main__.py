"""Serve an emulated arm: ``python -m hw.emulator``."""

from __future__ import annotations

import argparse
import logging
import os
import signal
import sys
from types import FrameType

from dynamics.errors import PalpateError, UnknownName
from hw.credentials import PASSWORD, USER
from hw.emulator.backend import Backend
from hw.emulator.faults import FAULTS, Fault
from hw.kortex.ports import TCP_PORT, UDP_PORT
from models.robot import REVISIONS

BACKENDS = ("kinematic", "mujoco")


def main(arguments: list[str] | None = None) -> int:
    """Serve until interrupted; return the exit status."""
    given = _parser().parse_args(arguments)
    logging.basicConfig(level=logging.INFO if given.verbose else logging.WARNING, format="%(asctime)s %(message)s")
    try:
        faults = [Fault.parse(text) for text in given.fault]
        users = {os.environ.get(USER, "admin"): os.environ.get(PASSWORD, "admin")}
        _serve(_backend(given), given, users, faults)
    except PalpateError as error:
        sys.stderr.write(f"python -m hw.emulator: {error}\n")
        return 2
    return 0


def _serve(backend: Backend, given: argparse.Namespace, users: dict[str, str], faults: list[Fault]) -> None:
    from hw.emulator.server import Emulator, Settings

    settings = Settings(given.host, given.port, given.udp_port, users, seed=given.seed)
    emulator = Emulator(backend, settings, faults)

    def end(number: int, frame: FrameType | None) -> None:
        emulator.end()

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, end)
    sys.stdout.write(f"ready: TCP {given.host}:{emulator.tcp_port}, UDP {given.host}:{emulator.udp_port}\n")
    sys.stdout.flush()
    emulator.serve()


def _backend(given: argparse.Namespace) -> Backend:
    """Return the robot that the arguments name."""
    if given.backend == "mujoco":
        return _simulated(given)
    from hw.emulator.kinematic import Block, KinematicRobot

    block = None if given.width == 0 else Block(given.width, given.stiffness, given.mass)
    return KinematicRobot(
        given.revision, not given.no_vision, block, torque_noise=given.torque_noise, seed=given.seed
    )


def _simulated(given: argparse.Namespace) -> Backend:
    """Return the simulation with an object on its table."""
    from hw.emulator.robot_backend import RobotBackend
    from models import objects
    from sim.robot import MujocoRobot
    from sim.sensors import SensorModel
    from sim.truth import read_truth

    try:
        truth = read_truth(objects.locate(given.object))
    except KeyError:
        raise UnknownName("--object", given.object, (*objects.names(), "or the path of a TOML file")) from None
    noise = SensorModel.none() if given.noise == "none" else SensorModel()
    robot = MujocoRobot(truth, noise, given.seed, revision=given.revision, vision=not given.no_vision)
    return RobotBackend(robot)


def _parser() -> argparse.ArgumentParser:
    faults = (f"  {name}{words}" if words[0] == "=" else f"  {name}: {words}" for name, words in FAULTS.items())
    names = "\n".join(faults)
    parser = argparse.ArgumentParser(
        prog="python -m hw.emulator",
        description="Serve an emulated Gen3 with a 2F-85 over the Kortex protocol.",
        epilog=f"Faults, each with an optional @SECONDS into the next motion:\n{names}\n"
        f"User and password come from {USER} and {PASSWORD}, admin and admin if unset.",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--host", default="127.0.0.1", help="address to listen at (%(default)s)")
    parser.add_argument("--port", type=int, default=TCP_PORT, help="TCP port, 0 for any (%(default)s)")
    parser.add_argument("--udp-port", type=int, default=UDP_PORT, help="UDP port, 0 for any (%(default)s)")
    parser.add_argument("--revision", choices=REVISIONS, default="V12", help="hardware of the arm (%(default)s)")
    parser.add_argument("--no-vision", action="store_true", help="an arm without the vision module")
    parser.add_argument(
        "--backend", choices=BACKENDS, default="kinematic", help="robot behind the server (%(default)s)"
    )
    parser.add_argument("--object", default="soft-cube", metavar="NAME|FILE", help="mujoco: what is on the table")
    parser.add_argument("--noise", choices=("default", "none"), default="default", help="mujoco: of the sensors")
    parser.add_argument(
        "--width", type=float, default=0.05, help="kinematic: block between the fingers [m], 0 for none"
    )
    parser.add_argument(
        "--stiffness", type=float, default=5000.0, help="kinematic: of the block [N/m] (%(default)s)"
    )
    parser.add_argument("--mass", type=float, default=0.3, help="kinematic: of the block [kg] (%(default)s)")
    parser.add_argument(
        "--torque-noise", type=float, default=0.0, help="kinematic: of a torque sample [N m] (%(default)s)"
    )
    parser.add_argument("--fault", action="append", default=[], metavar="NAME[=VALUE][@S]", help="see below")
    parser.add_argument("--seed", type=int, default=0, help="of noise and lost datagrams (%(default)s)")
    parser.add_argument("--verbose", action="store_true", help="tell of connections and faults")
    return parser


if __name__ == "__main__":
    sys.exit(main())
