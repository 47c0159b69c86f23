"""A run that ends anywhere is taken up with the belief that its measurements had led to."""

import random
import shutil

import pytest

from dynamics.objects import read_declared
from estimation.network import Network
from estimation.recording import read_recording
from models import objects
from selection.display import Silent
from selection.exploration import Exploration, Settings
from selection.robots import RobotRequest, open_robot
from selection.stand_in import StandIn

CUTS = 60


def test_the_belief_is_that_of_the_run_wherever_it_ends(default_run, tmp_path):
    whole = read_recording(default_run)
    believed = {
        sum(one.row <= entry.row and one.time <= entry.time for one in whole.measurements): entry.data["belief"]
        for entry in whole.beliefs
    }
    assert 0 in believed
    assert len(whole.measurements) in believed
    content = (default_run / "run.mcap").read_bytes()
    chance = random.Random(8)
    ends = [chance.randrange(len(content) // 100, len(content)) for _ in range(CUTS)]
    found = {}
    for number, end in enumerate(ends):
        cut = tmp_path / str(number)
        cut.mkdir()
        shutil.copy(default_run / "config.toml", cut)
        (cut / "run.mcap").write_bytes(content[:end])
        past = read_recording(cut)
        known = len(past.measurements)
        assert past.measurements == whole.measurements[:known]
        found.setdefault(known, past)
    assert len(found) >= 2
    source = objects.locate("soft-cube")
    declared, network = read_declared(source), Network.from_file("soft-cubes")
    robot = StandIn(open_robot("sim", RobotRequest(source)).robot, declared)
    for known, past in found.items():
        exploration = Exploration(robot, declared, network, None, Settings(), Silent())
        exploration.recall(past)
        if known in believed:
            assert exploration.belief.probabilities("material") == pytest.approx(
                believed[known]["material"], abs=1e-12
            )
