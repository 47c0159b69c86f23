"""The manual's example runs."""

import re
from pathlib import Path


def test_the_example_runs() -> None:
    text = (Path(__file__).parents[3] / "docs" / "experiments.md").read_text()
    (block,) = (b for b in re.findall(r"```python\n(.*?)```", text, re.S) if "SLURM" not in b)
    names: dict[str, object] = {}
    exec(block.replace("1000", "60"), names)
    trace = names["trace"]
    accuracy = trace.right.mean(axis=0)  # type: ignore[attr-defined]
    assert len(accuracy) == 8
    assert accuracy[-1] > 0.85
