"""Who logs in: from the environment or a prompt, never from the command line."""

from __future__ import annotations

import getpass
import os
import sys

from dynamics.errors import InvalidInput
from hw.kortex.exchange import Credentials

USER, PASSWORD = "PALPATE_KORTEX_USER", "PALPATE_KORTEX_PASSWORD"


def credentials() -> Credentials:
    """Return user and password from the environment; what is missing there is asked for.

    Raises:
        InvalidInput: if something is missing and there is nobody to ask.
    """
    user, password = os.environ.get(USER), os.environ.get(PASSWORD)
    if (user is None or password is None) and not sys.stdin.isatty():
        missing = USER if user is None else PASSWORD
        raise InvalidInput(
            f"environment variable {missing}", "nothing", f"the arm's login in {USER} and {PASSWORD}"
        )
    if user is None:
        sys.stderr.write("user of the arm: ")
        sys.stderr.flush()
        user = sys.stdin.readline().strip()
    if password is None:
        password = getpass.getpass("password: ")
    return Credentials(user, password)
