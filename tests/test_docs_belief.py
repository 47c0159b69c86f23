"""The examples of the manual on beliefs and references run."""

import re
from pathlib import Path

from estimation.network import Network
from selection.eyes import read_vision

DOCS = Path(__file__).parents[1] / "docs"


def test_planning_example(capsys):
    (block,) = re.findall(r"```python\n(.*?)```", (DOCS / "belief.md").read_text(), re.S)
    exec(block, {})
    assert capsys.readouterr().out == "weigh\n"


def test_vision_example(tmp_path):
    (block,) = re.findall(r"```json\n(.*?)```", (DOCS / "references.md").read_text(), re.S)
    path = tmp_path / "seen.json"
    path.write_text(block)
    assert read_vision(path, Network.from_file("household")).perceive().best == "mug"
