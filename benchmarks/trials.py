"""Time virtual trials of ten steps: ``python -m benchmarks.trials [--json] [--trials N] [--workers N]``."""

from __future__ import annotations

import argparse
import json
import resource
import sys
import time
from collections.abc import Sequence

import numpy as np

from estimation.network import Network
from selection.trials.protocol import CONTEXTS, STEPS, policies
from selection.trials.statistics import wilson
from selection.trials.sweep import Machines, pieces, sweep
from selection.trials.virtual_study import REFERENCE, VirtualJob, run_job

CHUNK = 2000
SHARES = (0.25, 0.5, 1.0)


def timed(policy: int, trials: int, workers: int) -> dict[str, float | str]:
    """Run trials of one policy, a sixth in every context, and say how long they took."""
    each = trials // len(CONTEXTS)
    jobs = [
        VirtualJob(REFERENCE, context, policy, first, count, 0)
        for context in range(len(CONTEXTS))
        for first, count in pieces(each, CHUNK)
    ]
    start, used = time.perf_counter(), processor_seconds()
    found = sweep("timing", run_job, jobs, machines=Machines(workers))
    seconds = time.perf_counter() - start
    used = processor_seconds() - used
    right = int(sum(part["right"][:, -1].sum() for part in found))
    count = sum(len(part["right"]) for part in found)
    low, high = wilson(right, count)
    return {
        "policy": policies(Network.from_file(REFERENCE))[policy].name,
        "trials": count,
        "steps": STEPS,
        "actions done": int(sum(np.sum(part["choices"] >= 0) for part in found)),
        "seconds": round(seconds, 2),
        "processor seconds": round(used, 2),
        "us a step": round(1e6 * seconds / count / STEPS, 2),
        "most probable right": f"{right / count:.4f} [{low:.4f}, {high:.4f}]",
    }


def processor_seconds() -> float:
    """Return what this process and its ended children used: what the clock shows on a machine of its own."""
    kinds = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    return sum(usage.ru_utime + usage.ru_stime for usage in map(resource.getrusage, kinds))


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="benchmarks.trials", description=__doc__)
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--trials", type=int, default=100_000, help="of every policy (default 100000)")
    parser.add_argument("--workers", type=int, default=2, help="processes (default 2)")
    parser.add_argument("--policy", default="exact, material", help="which, or 'all'")
    options = parser.parse_args(arguments)
    names = [policy.name for policy in policies(Network.from_file(REFERENCE))]
    chosen = names if options.policy == "all" else [options.policy]
    rows = []
    for name in chosen:
        shares = SHARES if options.policy != "all" else (1.0,)
        for share in shares:
            rows.append(timed(names.index(name), int(share * options.trials), options.workers))
            if not options.json:
                print(rows[-1], flush=True)
    if options.json:
        json.dump(rows, sys.stdout, indent=1)


if __name__ == "__main__":
    main()
