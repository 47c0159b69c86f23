"""The loop: what it sees, what it believes, and that failures on the object do not end it."""

import dataclasses
import math

import numpy as np
import pytest

from dynamics.errors import ActionFailed
from dynamics.objects import read_declared
from dynamics.robot import Robot
from estimation.conclude import density_of
from estimation.measurement import Measurement
from estimation.network import Network
from estimation.size import SizeEstimate
from estimation.weighing import measure_weighing
from models import objects
from selection.actions import Squeeze, Weigh
from selection.actions.hand import Hand
from selection.display import Silent
from selection.exploration import Exploration, Settings
from selection.tape import Tape
from sim.robot import MujocoRobot
from sim.sensors import SensorModel
from sim.truth import read_truth

FILE = objects.FOLDER / "soft-cube.toml"
DECLARED = read_declared(FILE)
TRUTH = read_truth(FILE)
NETWORK = Network.from_file("soft-cubes")
SETTINGS = Settings(confidence=0.99, price=0.005)
PROTOCOL = tuple(name for name in dir(Robot) if not name.startswith("_"))


class OnlyTheProtocol:
    """A robot of which nothing is reachable but what the protocol names."""

    def __init__(self, robot):
        members = {name: getattr(robot, name) for name in PROTOCOL if name not in ("arm", "gripper")}
        members |= {"arm": robot.arm, "gripper": robot.gripper}
        self.__dict__.update(members)


def explore(robot, actions=None, declared=DECLARED):
    exploration = Exploration(robot, declared, NETWORK, None, SETTINGS, Silent(), *([actions] if actions else []))
    exploration.explore()
    return exploration


def test_exploration_needs_nothing_but_the_protocol():
    # By squeezing; weighing is done with nothing but the protocol in the last test below.
    open_robot = explore(MujocoRobot(TRUTH, seed=3), actions=(Squeeze(),))
    closed = explore(OnlyTheProtocol(MujocoRobot(TRUTH, seed=3)), actions=(Squeeze(),))
    assert closed.belief.to_json() == open_robot.belief.to_json()
    assert [s.measurements for s in closed.steps] == [s.measurements for s in open_robot.steps]


def test_only_the_truth_of_the_simulator_changes_what_is_found():
    # The same declaration, another truth: what is measured follows the truth, so it can come from nowhere else.
    heavier = dataclasses.replace(TRUTH, mass=0.4, young_modulus=200e3)
    exploration = explore(MujocoRobot(heavier, SensorModel.none()), actions=(Weigh(), Squeeze()))
    found = {m.property: m.mean for step in exploration.steps for m in step.measurements}
    assert found["mass"] == pytest.approx(0.4, rel=0.001)


@dataclasses.dataclass
class Clumsy:
    """An action that fails, after closing on the object and lifting it."""

    name: str = "clumsy"

    def model(self, network):
        return dataclasses.replace(Weigh().model(network), name=self.name, seconds=1.0)

    def perform(self, hand):
        hand.gate()
        hand.grasp(self.name)
        hand.lift(0.03)
        raise ActionFailed("clumsy", "it failed on purpose")

    def measure(self, readings):
        raise AssertionError


def test_a_failed_action_is_reported_and_the_run_goes_on():
    exploration = explore(MujocoRobot(TRUTH, seed=1), actions=(Clumsy(), Squeeze()))
    first, second = exploration.steps[0], exploration.steps[1]
    assert (first.action, first.ok, first.measurements) == ("clumsy", False, ())
    assert "clumsy" in first.notes[0]
    assert first.belief.probabilities("material") == pytest.approx(
        exploration._blank.probabilities("material"), abs=1e-2
    )
    assert (second.action, second.ok) == ("squeeze", True)


class Notes(Silent):
    """Keeps what was decided."""

    def __init__(self):
        self.decisions = []

    def decides(self, decision):
        self.decisions.append(decision)


@pytest.mark.parametrize(("height", "rubbed"), [(0.056, True), (0.04, False)])
def test_what_the_object_does_not_allow_is_not_offered(height, rubbed):
    # On a flat object the pads have no way to slide.
    declared = dataclasses.replace(DECLARED, size=(0.056, 0.056, height))
    robot, notes = MujocoRobot(dataclasses.replace(TRUTH, declared=declared)), Notes()
    Exploration(robot, declared, NETWORK, None, Settings(budget=0.0), notes).step()
    offered = [score.name for score in notes.decisions[0].scores]
    assert offered == ["weigh", "squeeze", "rub"][: 2 + rubbed]


def test_what_cannot_be_held_is_reported_as_dropped():
    # 1 kg at 10 kPa and friction 0.2: the grip that the object allows carries less than half its weight.
    slippery = dataclasses.replace(TRUTH, mass=1.0, young_modulus=10e3, friction=0.2)
    exploration = explore(MujocoRobot(slippery, SensorModel.none()), actions=(Weigh(),))
    assert [step.ok for step in exploration.steps] == [False]
    assert exploration.steps[0].notes[0].startswith("dropped")
    assert exploration.stopped_because == "all actions failed"


def test_nothing_between_the_pads_is_reported_as_missed():
    elsewhere = dataclasses.replace(TRUTH, declared=dataclasses.replace(DECLARED, position=(0.5, 0.3)))
    robot = MujocoRobot(elsewhere, SensorModel.none())
    hand = Hand(robot, DECLARED, Tape(robot))
    hand.gate()
    with pytest.raises(ActionFailed, match="missed"):
        hand.grasp("weigh")
    hand.retreat()


@pytest.mark.parametrize(
    ("yaw", "position"), [(30.0, (0.5, 0.0)), (80.0, (0.42, 0.25)), (-60.0, (0.45, -0.3)), (0.0, (0.35, 0.1))]
)
def test_objects_anywhere_in_reach_can_be_grasped(yaw, position):
    declared = dataclasses.replace(DECLARED, yaw=math.radians(yaw), position=position)
    robot = MujocoRobot(dataclasses.replace(TRUTH, declared=declared), SensorModel.none())
    hand = Hand(robot, declared, Tape(robot))
    hand.gate()
    hand.grasp("weigh")
    hand.lift(0.05)
    hand.check_still_held("weigh")
    hand.put_back("weigh")


def test_size_estimate_is_the_product_of_gaussians():
    size = SizeEstimate((0.05, 0.06, 0.07), (1e-3,) * 3).with_edge(1, Measurement("width", 0.062, 0.5e-3, "m"))
    # two readings of 60 and 62 mm with weights 1 and 4
    assert size.mean[1] == pytest.approx((0.060 + 4 * 0.062) / 5)
    assert size.sd[1] == pytest.approx(1e-3 / math.sqrt(5))
    draws = np.random.default_rng(0).normal(size.mean, size.sd, (200_000, 3)).prod(axis=1)
    volume = size.volume()
    assert volume.mean == pytest.approx(draws.mean(), rel=1e-4)
    assert volume.sd == pytest.approx(draws.std(), rel=0.01)


def test_density_of_a_reference_without_mass():
    found = density_of(Measurement("mass", 0.1, 0.001, "kg"), Measurement("volume", 2e-4, 4e-6, "m^3"))
    draws = np.random.default_rng(0)
    ratio = draws.normal(0.1, 0.001, 100_000) / draws.normal(2e-4, 4e-6, 100_000)
    assert found.mean == pytest.approx(500)
    assert found.sd == pytest.approx(ratio.std(), rel=0.02)


def test_weighing_stops_when_the_mass_is_known():
    tours = {}
    for noise in (SensorModel.none(), SensorModel()):
        robot = OnlyTheProtocol(MujocoRobot(TRUTH, noise, seed=2))
        tape = Tape(robot)
        Weigh().perform(Hand(robot, DECLARED, tape))
        phases = tape.take()
        tours[noise] = [phase.name for phase in phases if phase.name in ("tare", "hold")]
        estimate, _ = measure_weighing(robot.arm, phases)
        assert abs(estimate.mass - TRUTH.mass) < 4 * estimate.mass_sd + 1e-4
    exact, noisy = tours.values()
    assert 3 == exact.count("hold") < noisy.count("hold") == 4
    assert exact == ["tare"] * 4 + ["hold"] * exact.count("hold") + ["tare"] * exact.count("hold")
