"""A command ends with the exit code of what happened, and says it on one line."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from dynamics.command_line import ended
from dynamics.errors import ActionFailed, InvalidInput, MotionRefused, NoRobot

ROOT = Path(__file__).parents[2]
INTERRUPTED = """
import sys
from dynamics.command_line import ended
def work():
    {work}
    raise AssertionError("was not interrupted")
if __name__ == "__main__":
    sys.exit(ended("cmd", work, "go on with: cmd"))
"""
KILL = "import os, signal; os.kill(os.getpid(), signal.SIGINT); [i for i in range(1000)]"


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (InvalidInput("here", 1, "2"), 2),
        (MotionRefused("too far"), 2),
        (NoRobot("nobody there"), 2),
        (ActionFailed("dropped", "it is gone"), 1),
    ],
)
def test_an_error_is_one_line_and_a_code(capsys, error, code):
    def work() -> int:
        raise error

    assert ended("cmd", work) == code
    assert capsys.readouterr().err == f"cmd: {error}\n"


def test_what_works_says_nothing(capsys):
    assert ended("cmd", lambda: 0) == 0
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("work", [KILL, f"exec({KILL!r})"], ids=["in code", "in code from a string"])
def test_ctrl_c_is_one_line_and_130(tmp_path, work):
    (tmp_path / "cmd.py").write_text(INTERRUPTED.format(work=work))
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, "-m", "cmd"], cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=60
    )
    assert done.stderr == "cmd: interrupted; go on with: cmd\n"
    assert done.returncode == 130
