"""Fine time steps while an object is rubbed: there and only there, and nothing else changes by them."""

import numpy as np
import pytest

import sim.stepping
from sim.contact import RUBBED, TIMESTEP, contact_law
from sim.stepping import FINER
from tests.sim.grasping import Grasp
from tests.sim.objects import block, thing

FINE = TIMESTEP / FINER


def stiffness(truth, timestep):
    """Return a contact's stiffness by MuJoCo's manual, what falls short of it made up for [N/m]."""
    law = contact_law(truth, timestep, RUBBED)
    d, time = law.impedance, law.time_constant
    return truth.mass / (d * (1 - d) * (time * law.damping_ratio) ** 2) * law.shortfall


@pytest.mark.parametrize("young", [5e3, 1e5, 1e6])
@pytest.mark.parametrize("mass", [0.004, 0.1, 1.0])
def test_a_contact_is_as_stiff_at_either_step(young, mass):
    truth = block(young, mass)
    assert stiffness(truth, FINE) == pytest.approx(stiffness(truth, TIMESTEP), rel=1e-9)


def test_steps_are_fine_while_pads_press_on_what_stands_on_the_table():
    grasp = Grasp(block(1e5, 0.1), 0.2)
    robot = grasp.robot
    assert robot._stepper.timestep == FINE
    grasp.lift(0.03)
    assert robot._stepper.timestep == TIMESTEP
    grasp.to(grasp.pose)
    robot.hold(0.2)
    assert robot._stepper.timestep == FINE
    robot.grip(0.08, 0.1)
    robot.hold(0.1)
    assert robot._stepper.timestep == TIMESTEP
    times = np.array([sample.time for sample in grasp.samples])  # from the closing on
    np.testing.assert_allclose(np.diff(times), 0.01, atol=1e-9)  # samples come as they always do


@pytest.mark.parametrize("truth", [thing("sphere", 5e4), block(1e8, 0.3)], ids=["round", "rigid"])
def test_steps_stay_as_they_are_for_what_cannot_be_rubbed(truth):
    grasp = Grasp(truth, 0.2)
    assert grasp.robot._stepper.timestep == TIMESTEP


def test_what_sensors_read_at_rest_does_not_depend_on_the_step(monkeypatch):
    def read(finer):
        monkeypatch.setattr(sim.stepping, "FINER", finer)
        grasp = Grasp(block(1e5, 0.1), 0.2)
        opening, force = grasp.at_rest()
        return grasp.robot.read().tau, opening, force

    (fine, near, strong), (coarse, far, weak) = read(FINER), read(1)
    # Closing ends on a sample over the limit, so that the two press alike to a sample's way: 0.2 mm, 11 N/mm.
    assert near == pytest.approx(far, abs=2e-4)
    assert strong == pytest.approx(weak, abs=0.2 * 11)
    np.testing.assert_allclose(fine, coarse, atol=0.5)
