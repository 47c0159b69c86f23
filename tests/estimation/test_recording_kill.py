"""A run that is killed at a random moment keeps what it announced and all but the last samples, and can go on.

Started as a script, this file is the victims' parent: it forks writers that announce what they have written, and
kills them. Forking from a process of its own keeps the threads of the test runner out of it.
"""

import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from dynamics.signals import Sample
from estimation.measurement import Measurement
from estimation.recording import RunWriter, read_recording

KILLS = 60
AT_ONCE = 6
RATE = 1000  # samples a second
LOSS = 0.5  # s of samples that a kill may cost


def number(k: int) -> float:
    return float(np.sin(k))


def sample(k: int) -> Sample:
    row = np.full(7, number(k))
    return Sample(k / RATE, row, row + 1, row + 2, abs(number(k)), float(k))


def write_until_killed(directory: Path, announce: int) -> None:
    """Write a run at 1 kHz; a line to ``announce`` for all that a caller may rely on."""
    run = RunWriter.create(directory, {}, "cube")
    start = time.monotonic()
    decided = measured = 0
    for k in range(60 * RATE):
        while time.monotonic() - start < k / RATE:
            time.sleep(0.0005)
        run.sample(sample(k))
        if k % 400 == 150:
            run.decision(k / RATE, {"number": decided})
            decided += 1
        if k % 400 == 300:
            run.measurement(k / RATE, "weigh", Measurement("mass", 1 + measured, 0.1, "kg"))
            measured += 1
        if k % 10 == 0:
            os.write(announce, json.dumps([k, decided, measured]).encode() + b"\n")


def kill_many(folder: Path, kills: int) -> None:
    """Fork, kill and report writers, a few at a time; each dies some time after its first sample."""
    chance = random.Random(20)
    for first in range(0, kills, AT_ONCE):
        running = []
        for trial in range(first, min(first + AT_ONCE, kills)):
            reading, writing = os.pipe()
            process = os.fork()
            if process == 0:
                os.close(reading)
                write_until_killed(folder / str(trial), writing)
                os._exit(1)
            os.close(writing)
            pipe = os.fdopen(reading, "rb")
            begun = pipe.readline()
            running.append((trial, process, pipe, begun, time.monotonic() + chance.uniform(0.0, 0.9)))
        for _, process, _, _, due in sorted(running, key=lambda one: one[4]):
            time.sleep(max(0.0, due - time.monotonic()))
            os.kill(process, signal.SIGKILL)
            os.waitpid(process, 0)
        for trial, _, pipe, begun, _ in running:
            with pipe:
                last = (begun + pipe.read()).splitlines()[-1]
            print(json.dumps([trial, json.loads(last)]), flush=True)


def test_a_kill_costs_half_a_second_of_samples_and_nothing_announced(tmp_path: Path) -> None:
    command = [sys.executable, __file__, str(tmp_path), str(KILLS)]
    path = os.pathsep.join(sys.path)
    done = subprocess.run(
        command, capture_output=True, text=True, check=True, env={**os.environ, "PYTHONPATH": path}
    )
    reports = [json.loads(line) for line in done.stdout.splitlines()]
    assert len(reports) == KILLS
    lost = []
    for trial, announced in reports:
        newest, decided, measured = announced
        directory = tmp_path / str(trial)
        recording = read_recording(directory)
        samples = recording.samples
        wanted = np.array([number(k) for k in range(len(samples))])
        assert np.array_equal(samples.q.ravel(), np.repeat(wanted, 7))
        assert np.array_equal(samples.effort, np.arange(len(samples)))
        assert [entry.data["number"] for entry in recording.decisions][:decided] == list(range(decided))
        found = [one.measurement.mean for one in recording.measurements]
        assert found[:measured] == [1.0 + n for n in range(measured)]
        assert len(list((directory / "measurements").glob("*-mass.json"))) >= measured
        lost.append(newest + 1 - len(samples))
        with RunWriter.resume(directory) as run:
            run.decision(0.0, {"number": "resumed"})
        resumed = read_recording(directory)
        assert resumed.measurements[: len(recording.measurements)] == recording.measurements
        assert [entry.data for entry in resumed.decisions[:-1]] == [entry.data for entry in recording.decisions]
        assert resumed.decisions[-1].data["number"] == "resumed"
        assert np.array_equal(resumed.samples.q, samples.q)
    assert max(lost) <= LOSS * RATE


if __name__ == "__main__":
    kill_many(Path(sys.argv[1]), int(sys.argv[2]))
