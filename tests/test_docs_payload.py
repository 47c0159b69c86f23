"""The examples of the manual run."""

import re
from pathlib import Path

from estimation.payload.estimate import PayloadEstimate


def test_examples_run():
    text = (Path(__file__).parents[1] / "docs" / "payload.md").read_text()
    blocks = [b for b in re.findall(r"```python\n(.*?)```", text, re.S) if "d.csv" not in b]
    assert len(blocks) == 2
    names: dict = {}
    for block in blocks:
        exec(block, names)
    assert isinstance(names["estimate"], PayloadEstimate)
    low, high = names["estimate"].mass_interval
    assert low < 0.5 < high
