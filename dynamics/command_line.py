"""How a command line ends: its exit codes, and one line for what went wrong."""

from __future__ import annotations

import sys
from collections.abc import Callable

from dynamics.errors import InvalidInput, MotionRefused, NoRobot, PalpateError

WRONG_INPUT = 2
FAILED = 1
STOPPED_BY_HAND = 130


def ended(prog: str, work: Callable[[], int], hint: str = "") -> int:
    """Do the work of a command line; return its exit code, or say on one line why it could not be done.

    Args:
        prog: name of the command.
        work: what it does; returns an exit code.
        hint: what to say besides when it was interrupted.
    """
    try:
        return work()
    except (InvalidInput, MotionRefused, NoRobot) as error:
        print(f"{prog}: {error}", file=sys.stderr)
        return WRONG_INPUT
    except PalpateError as error:
        print(f"{prog}: {error}", file=sys.stderr)
        return FAILED
    except KeyboardInterrupt:
        return interrupted(prog, hint)


def interrupted(prog: str, hint: str = "") -> int:
    """Say on one line that a command was interrupted; return its exit code, and make the interpreter keep to it.

    CPython remembers a Ctrl-C that came while it ran code from a string, as dataclasses do, and in the end
    dies of the signal whatever became of it (``run_eval_code_obj`` in its ``pythonrun.c``). The next such code
    clears that.

    Args:
        prog: name of the command.
        hint: what to say besides.
    """
    exec("")
    print(f"{prog}: interrupted{hint and '; '}{hint}", file=sys.stderr)
    return STOPPED_BY_HAND
