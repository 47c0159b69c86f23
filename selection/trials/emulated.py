"""A simulated arm behind the Kortex protocol, in a process of its own, opened as the real one is."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from dynamics.errors import InvalidInput
from selection.robots import OpenedRobot, RobotRequest, open_robot

_LOGIN = {"PALPATE_KORTEX_USER": "admin", "PALPATE_KORTEX_PASSWORD": "admin"}
"""What the emulator of this machine asks for."""
_READY = re.compile(r"ready: TCP \S+:(\d+), UDP \S+:(\d+)")
_PATIENCE = 10.0  # s for it to end by itself


@contextmanager
def emulated_robot(object_file: Path, seed: int) -> Iterator[OpenedRobot]:
    """Start the emulator with an object on its table, and yield the robot that its client sees.

    It runs in real time.

    Args:
        object_file: what is on the table.
        seed: of its noise.

    Raises:
        InvalidInput: if the emulator does not start.
        PalpateError: if the robot cannot be opened.
    """
    command = [sys.executable, "-m", "hw.emulator", "--backend", "mujoco", "--object", str(object_file)]
    command += ["--port", "0", "--udp-port", "0", "--seed", str(seed)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=os.environ | _LOGIN) as server:
        try:
            line = server.stdout.readline() if server.stdout else ""
            ready = _READY.match(line)
            if ready is None:
                raise InvalidInput("emulator: first line", line, "ready: TCP HOST:PORT, UDP HOST:PORT")
            request = RobotRequest(object_file, host="127.0.0.1", load_spread="face", yes=True)
            request = replace(request, tcp_port=int(ready[1]), udp_port=int(ready[2]))
            with _login():
                opened = open_robot("kortex", request)
            try:
                yield opened
            finally:
                opened.robot.close()
        finally:
            server.terminate()
            try:
                server.wait(_PATIENCE)
            except subprocess.TimeoutExpired:
                server.kill()


@contextmanager
def _login() -> Iterator[None]:
    """Log in as the emulator expects, and leave the environment as it was."""
    before = {name: os.environ.get(name) for name in _LOGIN}
    os.environ.update(_LOGIN)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
