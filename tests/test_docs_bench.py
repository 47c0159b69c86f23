"""The example of docs/bench.md runs and does what it says."""

import re
from pathlib import Path

from estimation.squeezing import measure_squeeze
from tests.sim.objects import block


def test_example_of_the_bench():
    text = (Path(__file__).parents[1] / "docs" / "bench.md").read_text(encoding="utf-8")
    example = re.search(r"```python\n(.*?)```", text, re.DOTALL)
    assert example is not None
    names = {"truth": block(5e4, 0.1)}
    exec(example[1], names)
    # The calibrated block feels as stiff under pads as finite elements say, 1.94 +- 0.06.
    assert 1.85 < names["kappa"] < 2.03
    bench = names["bench"]
    estimate, _ = measure_squeeze(bench.gripper, "box", (0.056,) * 3, names["phases"], poisson=0.0)
    assert abs(estimate.young_modulus / 5e4 - 1) < 0.05
    assert bench.truth.young_modulus == 2e5
