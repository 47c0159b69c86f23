"""Open the real arm for a command line: login from the environment or a prompt, the first motion confirmed."""

from __future__ import annotations

import sys
from pathlib import Path

from dynamics.gripper import ParallelGripper, robotiq_2f85
from hw.credentials import credentials
from hw.kortex.ports import TCP_PORT, UDP_PORT
from hw.kortex_robot import KortexRobot
from hw.settings import KortexSettings
from hw.torque_tare import TorqueTare
from models.robot import Revision


def connect(
    host: str,
    tcp_port: int = TCP_PORT,
    udp_port: int = UDP_PORT,
    revision: Revision = "V12",
    vision: bool = True,
    gripper: ParallelGripper | None = None,
    tare: Path | None = None,
    dry_run: bool = False,
    yes: bool = False,
) -> KortexRobot:
    """Connect to the arm.

    Args:
        host: name or address.
        tcp_port, udp_port: where it listens.
        revision, vision: which arm it is.
        gripper: as its user knows it; a 2F-85 as it comes if None.
        tare: file of a tare of the torque sensors.
        dry_run: plan and validate, and move nothing.
        yes: do not ask before the first motion.

    Raises:
        PalpateError: if the login, the tare or the connection is of no use.
    """
    settings = KortexSettings(
        revision=revision,
        vision=vision,
        gripper=gripper or robotiq_2f85(),
        tcp_port=tcp_port,
        udp_port=udp_port,
        tare=None if tare is None else TorqueTare.load(tare),
        dry_run=dry_run,
    )
    return KortexRobot(host, credentials(), settings, (lambda question: True) if yes else ask)


def ask(question: str) -> bool:
    """Ask a person; nobody there means no."""
    sys.stdout.write(f"{question} [yes/no] ")
    sys.stdout.flush()
    return sys.stdin.readline().strip().lower() in ("y", "yes")
