"""A default run, made once: it is looked at from several sides."""

import json

import pytest

from selection.run import main


@pytest.fixture(scope="session")
def default_run(tmp_path_factory):
    directory = tmp_path_factory.mktemp("runs") / "default"
    assert main(["--out", str(directory), "--quiet"]) == 0
    return directory


@pytest.fixture(scope="session")
def default_result(default_run):
    return json.loads((default_run / "result.json").read_text())
