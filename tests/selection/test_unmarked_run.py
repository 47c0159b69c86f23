"""A simulated run whose marks are lost is estimated again from what the robot did."""

import math
from dataclasses import replace

import pytest

from estimation.recording import read_recording
from estimation.reestimation import known_of, reestimate


def test_phases_of_a_whole_run_are_found(default_run, default_result):
    """Tares are made with the gripper nearly as far closed as on the object, which is let go without a motion."""
    run = read_recording(default_run)
    recorded = {one.measurement.property: one.measurement for one in run.measurements}
    bare = replace(run, marks=(), decisions=(), measurements=(), beliefs=())
    again = reestimate(bare, known_of(run.config))
    found = {one.property: one for action in again.actions for one in action.measurements}
    assert set(found) == {"mass", "elasticity", "width"}
    for name, one in found.items():
        assert abs(one.mean - recorded[name].mean) < 2 * math.hypot(one.sd, recorded[name].sd), name
    assert found["elasticity"].mean == pytest.approx(recorded["elasticity"].mean, rel=0.03)
    truth = default_result["truth"]["properties"]["mass"]["value"]
    assert found["mass"].sd < 0.005
    assert found["mass"].mean == pytest.approx(truth, abs=3 * found["mass"].sd)
