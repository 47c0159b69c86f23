"""A default run, made once for all processes of the tests: it is looked at from several sides."""

import fcntl
import json
import os

import pytest

from selection.run import main


@pytest.fixture(scope="session")
def default_run(tmp_path_factory):
    own = tmp_path_factory.getbasetemp()
    shared = own.parent if "PYTEST_XDIST_WORKER" in os.environ else own
    directory = shared / "default"
    with (shared / "default.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (directory / "result.json").exists():
            assert main(["--out", str(directory), "--quiet"]) == 0
    return directory


@pytest.fixture(scope="session")
def default_result(default_run):
    return json.loads((default_run / "result.json").read_text())
