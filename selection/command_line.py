"""How a command line ends: its exit codes, and one line for what went wrong."""

from __future__ import annotations

import sys
from collections.abc import Callable

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
    from dynamics.errors import InvalidInput, MotionRefused, NoRobot, PalpateError

    try:
        return work()
    except (InvalidInput, MotionRefused, NoRobot) as error:
        print(f"{prog}: {error}", file=sys.stderr)
        return WRONG_INPUT
    except PalpateError as error:
        print(f"{prog}: {error}", file=sys.stderr)
        return FAILED
    except KeyboardInterrupt:
        print(f"{prog}: interrupted{hint and '; '}{hint}", file=sys.stderr)
        return STOPPED_BY_HAND
