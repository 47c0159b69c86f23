"""Many beliefs at once say what one at a time says."""

from __future__ import annotations

import numpy as np
import pytest

from dynamics.errors import InvalidInput, UnknownName
from estimation.belief import Belief
from estimation.measurement import Measurement
from estimation.network import Network
from estimation.sensor import ClassSensor
from selection.information import information_gain, targets
from selection.trials.beliefs import Beliefs
from selection.trials.gains import information_gains

COUNT = 4
SMALL, LARGE = Network.from_file("thesis-3.1-erratum"), Network.from_file("network-8x10")


def learnt(network: Network, readings: int, seed: int = 0) -> tuple[Beliefs, list[Belief]]:
    """Return the same beliefs kept together and one by one, after different readings each."""
    rng = np.random.default_rng(seed)
    together, single = Beliefs(network, COUNT), [Belief(network)] * COUNT
    for _ in range(readings):
        for i in range(COUNT):
            _, sensor = network.sensors[int(rng.integers(len(network.sensors)))]
            row = np.array([i])
            if isinstance(sensor, ClassSensor):
                index = int(rng.integers(len(sensor.outcomes)))
                together.update_output(row, sensor, np.array([index]))
                single[i] = single[i].update_output(sensor, sensor.outcomes[index])
            else:
                prop = network.property(sensor.property)
                k = int(rng.integers(len(prop.means)))
                z = float(rng.normal(prop.means[k], prop.sds[k]))
                together.update(row, sensor.property, np.array([z]), sensor.sd)
                single[i] = single[i].update(Measurement(sensor.property, z, sensor.sd, prop.unit))
    return together, single


@pytest.mark.parametrize(("network", "readings"), [(SMALL, 1), (SMALL, 7), (LARGE, 2), (LARGE, 9)])
def test_probabilities_agree(network: Network, readings: int) -> None:
    together, single = learnt(network, readings)
    for variable in network.variables:
        expected = [list(belief.probabilities(variable).values()) for belief in single]
        assert np.abs(together.probabilities(variable) - expected).max() < 1e-13


@pytest.mark.parametrize(("network", "readings"), [(SMALL, 0), (SMALL, 3), (LARGE, 2)])
def test_gains_agree(network: Network, readings: int) -> None:
    """Classes to 1e-11 bit; a property, held on a grid that leaves out 1e-12 of the mass, to 1e-8."""
    together, single = learnt(network, readings)
    for _, sensor in network.sensors:
        for target in targets(network):
            found = information_gains(together, sensor, target)
            expected = [information_gain(belief, sensor, target) for belief in single]
            tolerance = 1e-8 if target in network.property_names else 1e-11
            assert np.abs(found - expected).max() < tolerance, (sensor, target)


def test_one_of_many_is_the_belief_itself() -> None:
    together, single = learnt(LARGE, 5)
    for i, belief in enumerate(single):
        assert together.one(i).probabilities("material") == pytest.approx(
            belief.probabilities("material"), abs=1e-13
        )


def test_a_prior_is_the_one_of_belief() -> None:
    prior = {"steel": 0.1, "ceramic": 0.7, "plastic": 0.1, "aluminium": 0.1}
    assert Beliefs(SMALL, 2, prior).probabilities("material")[1] == pytest.approx(
        list(Belief(SMALL, prior).probabilities("material").values())
    )


def test_fifty_sds_away_the_unknown_wins() -> None:
    together = Beliefs(SMALL, 1)
    together.update(np.array([0]), "density", np.array([40e3]), 300.0)
    found = together.probabilities("material")[0]
    assert np.all(np.isfinite(found))
    assert found[-1] > 0.999


def test_what_has_no_closed_form_here_is_refused() -> None:
    network = Network.from_file("soft-cubes")
    together = Beliefs(network, 1)
    with pytest.raises(InvalidInput, match="log"):
        together.update(np.array([0]), "elasticity", np.array([5e4]), 1e3)
    with pytest.raises(InvalidInput, match="relation"):
        information_gains(together, network.sensor("weigh"))
    with pytest.raises(UnknownName, match="target"):
        information_gains(Beliefs(SMALL, 1), SMALL.sensor("weigh"), "colour")
