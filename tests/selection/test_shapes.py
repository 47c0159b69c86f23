"""Objects of every shape, anywhere on the table: refused before anything moves, or weighed and squeezed."""

import dataclasses
import math

import numpy as np
import pytest

import sim.robot
from dynamics.errors import InvalidInput
from estimation.bounds import bound_of
from estimation.size import SizeEstimate
from models import objects
from selection.actions import Readings, Squeeze, Weigh
from selection.actions.hand import Hand
from selection.actions.reach import find_grasp, free_space
from selection.robots import RobotRequest, open_robot, simulated_at_rest
from selection.tape import Tape
from sim.robot import MujocoRobot
from sim.sensors import SensorModel
from sim.truth import read_truth
from tests.sim.objects import thing

SHAPED = ("rubber-ball", "foam-cylinder", "sponge-ellipsoid", "soap-bar", "steel-block", "clay-cube")


@pytest.fixture(scope="module")
def rest():
    return simulated_at_rest()


@pytest.mark.parametrize("yaw", [-2.8, -1.2, 0.0, 0.4, 1.5, 2.9])
@pytest.mark.parametrize("position", [(0.35, -0.25), (0.5, 0.0), (0.42, 0.3), (0.6, 0.15)])
def test_any_yaw_can_be_grasped_within_reach(rest, position, yaw):
    arm, gripper, still = rest
    for shape in ("box", "ellipsoid"):
        declared = thing(shape, position=position, yaw=yaw).declared
        pose, gate = find_grasp(gripper, free_space(arm, declared, still.q), declared, still.q)
        np.testing.assert_allclose(pose[:2, 3], position)
        # The pads' line of closing, the tool's y, is along the shorter side.
        closing = declared.pose()[:2, :2].T @ pose[:2, 1]
        assert abs(closing[1 if declared.size[1] < declared.size[0] else 0]) == pytest.approx(1.0)
        assert arm.within_limits(gate)


@pytest.mark.parametrize("yaw", [-0.9, 0.0, 0.5])
def test_round_objects_are_closed_on_along_their_axes_where_the_arm_can(rest, yaw):
    arm, gripper, still = rest
    declared = thing("cylinder", position=(0.45, 0.1), yaw=yaw).declared
    pose, _ = find_grasp(gripper, free_space(arm, declared, still.q), declared, still.q)
    assert max(abs(declared.pose()[:2, :2].T @ pose[:2, 1])) == pytest.approx(1.0)


@pytest.mark.parametrize("position", [(0.85, 0.3), (0.0, 0.0), (-0.2, 0.8), (0.05, 0.05)])
def test_pose_out_of_reach_is_refused_before_the_simulation_starts(tmp_path, monkeypatch, position):
    def started(*_args, **_kwargs):
        raise AssertionError("the simulation was started")

    monkeypatch.setattr(sim.robot, "MujocoRobot", started)
    path = tmp_path / "far.toml"
    path.write_text(
        f"[declared]\nsize_m = [0.05, 0.05, 0.05]\nposition_m = {list(position)}\n"
        "[truth]\nmass_kg = 0.1\nyoung_modulus_pa = 5e4\n"
    )
    with pytest.raises(InvalidInput, match=r"far.toml.*position_m.*reach"):
        open_robot("sim", RobotRequest(path))


def handled(truth, actions, fidelity="uniform", noise=None):
    """Return the findings of actions on an object, by the action's name."""
    robot = MujocoRobot(truth, noise or SensorModel.none(), 0, fidelity)
    tape = Tape(robot)
    hand = Hand(robot, truth.declared, tape)
    found = {}
    for action in actions:
        tape.take()
        action.perform(hand)
        size = SizeEstimate.declared(truth.declared)
        found[action.name] = action.measure(Readings(robot, tape.take(), truth.shape, size, hand.edge))
    return found


def test_a_ball_gives_its_modulus_to_the_hand():
    truth = read_truth(objects.locate("rubber-ball"))
    found = {m.property: m for m in handled(truth, [Squeeze()])["squeeze"].measurements}
    assert found["elasticity"].mean == pytest.approx(truth.young_modulus, rel=0.03)
    assert found["width"].mean == pytest.approx(truth.size[1], abs=2e-4)


def test_steel_is_a_bound():
    truth = read_truth(objects.locate("steel-block"))
    findings = handled(truth, [Squeeze()], noise=SensorModel())["squeeze"]
    assert "elasticity" not in {m.property for m in findings.measurements}
    quantity, bound, unit = bound_of(findings.measurements[0])
    assert (quantity, unit) == ("elasticity", "Pa")
    assert 1e5 < bound < truth.young_modulus


def test_clay_is_held_between_squeezes_and_found_again_after_them():
    truth = read_truth(objects.locate("clay-cube"))
    robot = MujocoRobot(truth, SensorModel())
    tape = Tape(robot)
    hand = Hand(robot, truth.declared, tape)
    Squeeze().perform(hand)
    assert hand.present_width < 0.75 * truth.size[1]
    size = SizeEstimate.declared(truth.declared)
    findings = Squeeze().measure(Readings(robot, tape.take(), truth.shape, size, hand.edge))
    (elasticity,) = findings.measurements
    assert elasticity.mean == pytest.approx(truth.young_modulus, abs=3 * elasticity.sd)
    assert "of the work of pressing it is lost" in findings.notes[0]
    hand.grasp("weigh")  # not missed, though it is narrower than a grasp closes on what springs back


@pytest.mark.slow
@pytest.mark.parametrize("name", SHAPED)
@pytest.mark.parametrize(("position", "yaw"), [((0.42, -0.2), 0.6), ((0.55, 0.12), -2.0), ((0.4, 0.28), 1.4)])
def test_every_shape_is_weighed_and_squeezed_wherever_it_stands(name, position, yaw):
    truth = read_truth(objects.locate(name))
    truth = dataclasses.replace(truth, declared=dataclasses.replace(truth.declared, position=position, yaw=yaw))
    found = handled(truth, [Weigh(), Squeeze()])
    assert found["weigh"].measurements[0].mean == pytest.approx(truth.mass, rel=2e-3, abs=2e-5)
    moduli = [m.mean for m in found["squeeze"].measurements if m.property == "elasticity"]
    if truth.is_rigid:
        assert not moduli
    else:
        assert moduli[0] == pytest.approx(truth.young_modulus, rel=0.06)
    if truth.yield_strain:
        assert any("spring back" in note for note in found["squeeze"].notes)
    assert math.isfinite(found["weigh"].measurements[0].sd)


@pytest.mark.slow
@pytest.mark.parametrize("young", [2e4, 6e5])
@pytest.mark.parametrize("shape", ["box", "cylinder", "sphere", "ellipsoid", "mesh"])
def test_what_sinks_in_gives_back_its_modulus(shape, young):
    truth = dataclasses.replace(thing(shape, young, 0.06 if young < 1e5 else 0.3, yaw=1.1), poisson=0.3)
    found = {m.property: m for m in handled(truth, [Squeeze()], "indentation")["squeeze"].measurements}
    assert found["elasticity"].mean == pytest.approx(young, rel=0.1)
