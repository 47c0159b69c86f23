"""What is lost between two squeezes is told from their work, how far an object comes back from its unloading."""

import numpy as np
import pytest

from dynamics.signals import Phase, Sample
from estimation.springing import comes_back, elastic_readings, lost_work

STEP = 2e-4  # m a sample
AIR = 0.05  # A


def phases(*strokes, force, noise=0.0, tick=0.0, seed=0):
    """Return phases of closing pads, each from an opening to another; a name of None only opens."""
    draw = np.random.default_rng(seed)
    made, deepest, time = [], np.inf, 0.0
    for number, (name, start, end) in enumerate(strokes):
        opening = np.arange(start, end, -STEP if end < start else STEP)
        effort = []
        for x in opening:
            effort.append(AIR + force(x, deepest) + noise * draw.normal())
            deepest = min(deepest, x)
        if tick:
            opening = np.round(opening / tick) * tick
        samples = []
        for x, current in zip(opening, effort, strict=True):
            time += 0.01
            samples.append(Sample(time, np.zeros(7), np.zeros(7), np.zeros(7), float(x), float(current)))
        made.append(Phase("squeeze", name, number, tuple(samples)))
    return made


def elastic(x, _):
    """A spring 50 mm wide: 20 A/m."""
    return max(20 * (0.05 - x), 0.0)


def clay(x, deepest):
    """The same that flows at 0.1 A, and comes back by 5 mm."""
    return min(max(20 * (min(deepest, x) + 0.005 - x), 0.0), 0.1)


TWICE = (
    ("grasp", 0.052, 0.040),
    ("compress", 0.040, 0.030),
    ("release", 0.030, 0.036),
    ("compress", 0.036, 0.030),
)


@pytest.mark.parametrize(("noise", "tick"), [(0.0, 0.0), (0.01, 3.7e-4)])
def test_a_spring_loses_nothing_and_clay_most(noise, tick):
    assert lost_work(phases(*TWICE, force=elastic, noise=noise, tick=tick), AIR, tick) < 0.1
    # From 50 to 30 mm: 0.1 A 17.5 mm of it went in, 0.1 A 2.5 mm comes out.
    lost = lost_work(phases(*TWICE, force=clay, noise=noise, tick=tick), AIR, tick)
    assert lost == pytest.approx(1 - 0.25 / 1.75, abs=0.06)


def test_nothing_is_said_of_pads_that_have_not_let_go():
    assert lost_work(phases(*TWICE[:2], force=clay), AIR, 0.0) == 0.0
    assert comes_back(phases(*TWICE[:2], force=clay), AIR, 0.0) == 0.0


@pytest.mark.parametrize("let_go", [0.0015, 0.003, 0.006])
def test_clay_comes_back_as_far_as_its_unloading_says(let_go):
    cycle = (*TWICE[:2], ("release", 0.030, 0.030 + let_go), ("compress", 0.030 + let_go, 0.030))
    back = comes_back(phases(*cycle, force=clay), AIR + 0.02, 0.0)
    # 20 A/m from 0.1 A down to 0.02 A, as far as a line through so little is believed
    assert 0.0 < back <= 0.004 + 2e-4
    if let_go > 0.002:
        assert back == pytest.approx(0.004, abs=3e-4)


def test_elastic_are_the_readings_up_to_where_it_was_pressed():
    made = phases(*TWICE, force=clay)
    assert [len(readings) for readings in elastic_readings(made)] == [pytest.approx(29, abs=1)]
    assert all(np.all(readings.opening > 0.030) for readings in elastic_readings(made))
