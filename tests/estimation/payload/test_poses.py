"""Planned poses against brute force, and what they promise against what the estimate then states."""

from itertools import combinations

import numpy as np
import pytest

from dynamics.arm import Arm
from dynamics.errors import InvalidInput
from dynamics.signals import JointReadings
from estimation.payload import JointNoise, estimate_payload
from estimation.payload.poses import _exchange, _mass_variance, plan_poses

SD = np.array([0.4] * 4 + [0.15] * 3)


@pytest.fixture(scope="module")
def arm():
    return Arm.gen3()


def test_exchange_comes_close_to_brute_force(arm):
    rng = np.random.default_rng(0)
    for _ in range(5):
        body = np.array([arm.payload_regressor(q) for q in rng.uniform(-2, 2, (16, 7))])
        information = np.einsum("nji,j,njk->nik", body, 0.5 / SD**2, body)
        best = min(_mass_variance(information[list(c)].sum(axis=0)) for c in combinations(range(16), 4))
        found = _mass_variance(information[_exchange(information, 4)].sum(axis=0))
        assert np.sqrt(found / best) < 1.05


def test_promise_is_kept(arm):
    noise = JointNoise(SD, outlier_rate=0.0)
    plan = plan_poses(arm, 4, noise, np.random.default_rng(1))
    tau = np.array([arm.gravity(q) for q in plan.poses])
    stated = estimate_payload(arm, JointReadings(plan.poses, tau), JointReadings(plan.poses, tau), noise).mass_sd
    assert plan.mass_sd == pytest.approx(stated, rel=1e-6)
    assert plan.mass_sd < 0.75 * plan.random_sd
    assert all(arm.within_limits(q) for q in plan.poses)


def test_with_drift_the_tare_comes_before_and_after(arm):
    plan = plan_poses(arm, 6, JointNoise(SD, drift=0.3), np.random.default_rng(2))
    kinds = [kind for kind, _ in plan.order]
    assert kinds[0] == kinds[-1] == "tare"
    assert sorted(i for kind, i in plan.order if kind == "load") == list(range(6))
    assert plan.mass_sd < plan.sd_by_order["tare, load"]


def test_impossible_plans_are_refused(arm):
    rng = np.random.default_rng(3)
    with pytest.raises(InvalidInput, match="feasible"):
        plan_poses(arm, 2, JointNoise(SD), rng, candidates=10, allowed=lambda q: False)
    with pytest.raises(InvalidInput, match="given sd"):
        plan_poses(arm, 2, JointNoise(), rng)
    with pytest.raises(InvalidInput, match="count"):
        plan_poses(arm, 0, JointNoise(SD), rng)
