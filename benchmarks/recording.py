"""What recording costs the robot's loop and one core, and what reading a long recording costs.

``python -m benchmarks.recording --json`` prints cpu_share (of one core, for a stream at 1 kHz of 17 channels and
of the 23 that a sample has), worst_block_ms (longest call from the loop), read_s, read_mb (10 minutes at 1 kHz).
"""

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from dynamics.signals import Sample
from estimation.recording import RunWriter

RATE = 1000
SECONDS = 30.0
MINUTES = 10


def samples(count: int, nv: int, seed: int = 0) -> list[Sample]:
    random = np.random.default_rng(seed)
    walk = np.cumsum(random.normal(0, 1e-3, (count, 3 * nv + 2)), axis=0)
    return [
        Sample(k / RATE, r[:nv], r[nv : 2 * nv], r[2 * nv : 3 * nv], float(r[-2]), float(r[-1]))
        for k, r in enumerate(walk)
    ]


def stream(folder: Path | None, series: list[Sample]) -> tuple[float, float, float]:
    """Run a robot's loop at 1 kHz; return CPU seconds, and the worst and mean time of a recording call [ms]."""
    run = None if folder is None else RunWriter.create(folder, {}, "cube")
    worst = total = 0.0
    used = time.process_time()
    start = time.perf_counter()
    for k, one in enumerate(series):
        due = start + k / RATE
        while (left := due - time.perf_counter()) > 0:
            time.sleep(left)
        if run is not None:
            before = time.perf_counter()
            run.sample(one)
            took = time.perf_counter() - before
            worst, total = max(worst, took), total + took
    used = time.process_time() - used
    if run is not None:
        run.close()
    return used, worst * 1e3, total / len(series) * 1e3


READ = """
import json, resource, sys, time
from pathlib import Path
from estimation.recording import read_recording
start = time.perf_counter()
recording = read_recording(Path(sys.argv[1]))
took = time.perf_counter() - start
print(json.dumps([len(recording.samples), took, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024]))
"""


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.recording", description=__doc__)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--seconds", type=float, default=SECONDS)
    parser.add_argument("--minutes", type=float, default=MINUTES)
    given = parser.parse_args()
    figures: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for channels, nv in ((17, 5), (23, 7)):  # 3 a joint and 2 of the gripper
            series = samples(round(given.seconds * RATE), nv)
            idle, _, _ = stream(None, series)
            used, worst, mean = stream(folder / f"run-{channels}", series)
            figures[f"cpu_share_{channels}"] = (used - idle) / given.seconds
            figures[f"worst_block_ms_{channels}"] = worst
            figures[f"mean_block_ms_{channels}"] = mean
        count = round(given.minutes * 60 * RATE)
        block = samples(10_000, 7)
        size = 0
        with RunWriter.create(folder / "long", {}, "cube") as run:
            for k in range(count):
                one = block[k % len(block)]
                run.sample(Sample(k / RATE, one.q, one.dq, one.tau, one.opening, one.effort))
        size = (folder / "long" / "run.mcap").stat().st_size
        command = [sys.executable, "-c", READ, str(folder / "long")]
        read = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
    figures |= {"samples": read[0], "read_s": read[1], "read_mb": read[2], "bytes_per_sample": size / count}
    figures["writer_peak_mb"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    if given.json:
        print(json.dumps(figures))
    else:
        for name, value in figures.items():
            print(f"{name:22} {value:.4g}")


if __name__ == "__main__":
    main()
