"""Damaged logs are read or refused, and nothing else happens; `python -m benchmarks.fuzz` does this for hours."""

import random
from pathlib import Path

import numpy as np
import pytest

from dynamics.errors import PalpateError
from dynamics.signals import Sample
from estimation.ipalm import from_json, from_list
from estimation.readers import read_log
from estimation.recording import RunWriter

COUNT = 250
LIST = """[{"object_name": "item", "measurements":
 [{"name": "density", "value": {"sigma": 1, "mean": 7, "units": "kg"}}]}]"""
DOCUMENT = """{"measurement": {"object_instance": {"dataset": "ycb", "other": {}}, "setup": {"arm": "a"},
 "sensor_outputs": {}}, "entries": [{"type": "size", "name": "x", "repository": null,
 "values": [{"name": "x", "mean": 1, "std": 2}]}]}"""


def damaged(seed: bytes, number: int) -> bytes:
    chance = random.Random(number)
    data = bytearray(seed)
    for _ in range(chance.choice((1, 1, 2, 8))):
        at = chance.randrange(len(data))
        if chance.random() < 0.2:
            del data[max(at, 1) :]
        elif chance.random() < 0.3:
            data[at : at + 4] = chance.choice((b"\xff" * 4, b"\0" * 4, b"\xff\xff\xff\x7f", b"nan,", b"1e999"))
        else:
            data[at] = chance.randrange(256)
    return bytes(data)


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """Return a small good log of every kind that needs no library of others to be made."""
    folder = tmp_path_factory.mktemp("good")
    numbers = np.random.default_rng(0).normal(size=(30, 23))
    with RunWriter.create(folder / "run", {}, "cube") as run:
        for k, r in enumerate(numbers):
            run.sample(Sample(k / 100, r[:7], r[7:14], r[14:21], float(r[21]), float(r[22])))
    np.savez(folder / "log.npz", time=np.arange(30) / 100, q=numbers[:, :7], tau=numbers[:, 7:14])
    rows = ["time," + ",".join(f"q{n}" for n in range(1, 8))]
    rows += [f"{k / 100}," + ",".join(map(repr, r[:7].tolist())) for k, r in enumerate(numbers)]
    return {
        ".mcap": (folder / "run" / "run.mcap").read_bytes(),
        ".npz": (folder / "log.npz").read_bytes(),
        ".csv": "\n".join(rows).encode(),
    }


@pytest.mark.parametrize("ending", [".mcap", ".npz", ".csv"])
def test_damaged_logs(tmp_path: Path, logs: dict[str, bytes], ending: str) -> None:
    path = tmp_path / f"log{ending}"
    read = unnamed = 0
    for number in range(COUNT):
        path.write_bytes(damaged(logs[ending], number))
        try:
            read += bool(len(read_log(path).samples))
        except PalpateError as error:
            unnamed += str(path) not in str(error)
    assert unnamed == 0
    assert read or ending == ".npz"  # archives bear a checksum


@pytest.mark.parametrize("kind", ["list", "document"])
def test_damaged_documents(kind: str) -> None:
    text, read = {"list": (LIST, from_list), "document": (DOCUMENT, from_json)}[kind]
    refused = 0
    for number in range(4 * COUNT):
        try:
            read(damaged(text.encode(), number).decode("utf-8", "replace"))
        except PalpateError:
            refused += 1
    assert 0 < refused < 4 * COUNT
