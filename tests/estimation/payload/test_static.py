"""The payload estimate against numpy, against the truth of simulated readings, and against bad input."""

import numpy as np
import pytest

from dynamics.arm import Arm
from dynamics.errors import InvalidInput
from dynamics.signals import JointReadings
from estimation.payload import JointNoise, estimate_payload
from estimation.payload.batch import design_matrix, estimate_batch

SD = np.array([0.4] * 4 + [0.15] * 3)
MASS, CENTER = 0.8, np.array([0.02, -0.01, 0.05])
PAYLOAD = np.concatenate([[MASS], MASS * CENTER])


@pytest.fixture(scope="module")
def arm():
    return Arm.gen3()


@pytest.fixture(scope="module")
def poses():
    return np.random.default_rng(0).uniform(-1.5, 1.5, (8, 7))


def torques(arm, poses, payload):
    return np.array([arm.gravity(q) + arm.payload_regressor(q) @ payload for q in poses])


def pair(arm, poses, rng, sd=SD, bias=0.3, time=False):
    """Return a tare and a load of single readings."""
    found = []
    for index, payload in enumerate((0 * PAYLOAD, PAYLOAD)):
        tau = torques(arm, poses, payload) + bias + rng.normal(size=(len(poses), arm.nv)) * sd
        stamps = index * len(poses) + np.arange(len(poses), dtype=float)
        found.append(JointReadings(poses, tau, time=stamps if time else None))
    return found


def with_torque(readings, tau):
    return JointReadings(readings.q, tau, time=readings.time)


def test_without_outliers_equals_numpy(arm, poses):
    tare, load = pair(arm, poses, np.random.default_rng(1))
    found = estimate_payload(arm, tare, load, JointNoise(SD, outlier_rate=0.0))
    body = np.array([arm.payload_regressor(q) for q in poses]).reshape(56, 4)
    own = np.array([arm.gravity(q) for q in poses])
    rows = np.hstack([np.block([[0 * body, body], [body, body]]), np.tile(np.eye(7), (16, 1))])
    rows = np.vstack([rows / np.tile(SD, 16)[:, None], np.eye(15) / 100])
    right = np.concatenate([(tare.tau - own).ravel(), (load.tau - own).ravel()]) / np.tile(SD, 16)
    expected = np.linalg.lstsq(rows, np.concatenate([right, np.zeros(15)]), rcond=None)[0]
    np.testing.assert_allclose(found.parameters, expected[:4], atol=1e-10)
    np.testing.assert_allclose(found.covariance, np.linalg.inv(rows.T @ rows)[:4, :4], atol=1e-10)


@pytest.mark.parametrize("rate", [0.0, 0.05])
def test_batch_equals_the_graph(arm, poses, rate):
    rng = np.random.default_rng(2)
    own = torques(arm, poses, 0 * PAYLOAD)
    pairs = [pair(arm, poses, rng) for _ in range(5)]
    pairs = [(t, with_torque(r, r.tau + 8 * (rng.random(r.tau.shape) < 0.03))) for t, r in pairs]
    torque = np.array([np.concatenate([t.tau - own, r.tau - own]).ravel() for t, r in pairs])
    batch = estimate_batch(design_matrix(arm, poses, poses), torque, SD, rate)
    for (tare, load), parameters, covariance in zip(pairs, batch.parameters, batch.covariance, strict=True):
        single = estimate_payload(arm, tare, load, JointNoise(SD, outlier_rate=rate))
        np.testing.assert_allclose(single.parameters, parameters, atol=1e-7)
        np.testing.assert_allclose(single.covariance, covariance, atol=1e-7)


def test_same_pose_tare_cancels_a_wrong_arm(arm, poses):
    """Whatever the arm's model gets wrong at a pose, tare and load share it."""
    tare, load = pair(arm, poses, np.random.default_rng(3))
    wrong = np.random.default_rng(4).normal(size=tare.tau.shape) * 2
    noise = JointNoise(SD, outlier_rate=0.0)
    right = estimate_payload(arm, tare, load, noise)
    biased = estimate_payload(arm, with_torque(tare, tare.tau + wrong), with_torque(load, load.tau + wrong), noise)
    np.testing.assert_allclose(biased.parameters, right.parameters, atol=1e-5)


@pytest.mark.parametrize("robot", ["ur10", "panda"])
def test_other_robots(robot):
    arm = Arm.named(robot)
    poses = np.random.default_rng(5).uniform(-1.5, 0, (6, arm.nv))
    poses = np.clip(poses, arm.lower, arm.upper)
    tare, load = pair(arm, poses, np.random.default_rng(6), sd=0.1)
    found = estimate_payload(arm, tare, load, JointNoise(0.1))
    assert abs(found.mass - MASS) < 4 * found.mass_sd < 0.4
    assert np.all(np.abs(found.center_of_mass - CENTER) < 4 * found.center_of_mass_sd)


def test_single_outliers_and_a_touched_pose_are_found(arm, poses):
    tare, load = pair(arm, poses, np.random.default_rng(7))
    tau = load.tau.copy()
    tau[2, 1] += 10
    tau[5] += np.array([8, -9, 7, 8, -5, 6, 7.0])
    found = estimate_payload(arm, tare, with_torque(load, tau), JointNoise(SD))
    assert found.weights[8 + 2, 1] < 0.01
    assert found.pose_weights[8 + 5] < 0.01
    assert np.delete(found.pose_weights, 8 + 5).min() > 0.5
    untouched = np.arange(8) != 5
    kept = tau[untouched].copy()
    alone = estimate_payload(arm, tare, JointReadings(poses[untouched], kept), JointNoise(SD))
    assert abs(found.mass - alone.mass) < 0.1 * found.mass_sd


def test_drift_chain_covers_where_a_constant_bias_does_not(arm, poses):
    rng, step = np.random.default_rng(8), 0.3
    z = {"chain": [], "constant": []}
    for _ in range(150):
        walk = np.cumsum(rng.normal(size=(16, 7)) * step, axis=0)
        tare, load = pair(arm, poses, rng, time=True)
        tare, load = with_torque(tare, tare.tau + walk[:8]), with_torque(load, load.tau + walk[8:])
        for name, drift in (("chain", step), ("constant", 0.0)):
            found = estimate_payload(arm, tare, load, JointNoise(SD, drift=drift, outlier_rate=0.0))
            z[name].append(abs(found.mass - MASS) / found.mass_sd)
    # binomial: 150 runs at 0.95 stay above 0.89 with 99.9 %
    assert np.mean(np.array(z["chain"]) < 1.96) > 0.89
    assert np.mean(np.array(z["constant"]) < 1.96) < 0.8


def test_estimated_noise_gives_honest_intervals(arm, poses):
    rng = np.random.default_rng(9)
    hits = []
    for _ in range(40):
        tare, load = pair(arm, poses, rng, bias=rng.uniform(-0.5, 0.5, 7))
        found = estimate_payload(arm, tare, load)
        hits.append(abs(found.mass - MASS) < 1.96 * found.mass_sd)
    assert np.mean(hits) > 0.82  # binomial: 40 runs at 0.95, 99.9 %
    assert found.noise_sd[0, :4].mean() == pytest.approx(0.4, rel=0.4)
    assert found.noise_sd[0, 4:].mean() == pytest.approx(0.15, rel=0.4)


def test_order_of_the_poses_does_not_matter(arm, poses):
    tare, load = pair(arm, poses, np.random.default_rng(16))
    turned = np.random.default_rng(17).permutation(8)
    for noise in (JointNoise(SD), None):
        straight = estimate_payload(arm, tare, load, noise)
        shuffled = estimate_payload(arm, tare, JointReadings(poses[turned], load.tau[turned]), noise)
        np.testing.assert_allclose(shuffled.parameters, straight.parameters, atol=1e-7)
        np.testing.assert_allclose(shuffled.covariance, straight.covariance, atol=1e-7)
        np.testing.assert_allclose(shuffled.weights[8:], straight.weights[8:][turned], atol=1e-5)


def test_long_drifting_series_need_a_given_noise(arm, poses):
    tare, load = pair(arm, np.tile(poses, (13, 1)), np.random.default_rng(18))
    with pytest.raises(InvalidInput, match="a given sd"):
        estimate_payload(arm, tare, load, JointNoise(drift=0.1))
    found = estimate_payload(arm, tare, load, JointNoise(SD, drift=0.01))
    assert abs(found.mass - MASS) < 4 * found.mass_sd < 0.1


def test_friction_of_slow_motion_is_told_from_the_payload(arm, poses):
    rng = np.random.default_rng(10)
    coulomb, viscous = rng.uniform(0.5, 1.5, 7), rng.uniform(2, 6, 7)
    q = np.repeat(poses, 2, axis=0)
    readings = []
    for payload in (0 * PAYLOAD, PAYLOAD):
        dq = rng.uniform(0.05, 0.3, q.shape) * rng.choice([-1, 1], q.shape)
        tau = torques(arm, q, payload) + coulomb * np.sign(dq) + viscous * dq + 0.05 * rng.normal(size=q.shape)
        readings.append(JointReadings(q, tau, dq=dq))
    noise = JointNoise(0.05, outlier_rate=0.0)
    found = estimate_payload(arm, *readings, noise, friction=True)
    assert abs(found.mass - MASS) < 4 * found.mass_sd < 0.1
    assert abs(estimate_payload(arm, *readings, noise).mass - MASS) > 4 * found.mass_sd
    with pytest.raises(InvalidInput, match="dq"):
        estimate_payload(arm, JointReadings(q, readings[0].tau), readings[1], noise, friction=True)


def test_gain_errors_count(arm, poses):
    rng = np.random.default_rng(11)
    errors, sds = [], []
    for _ in range(60):
        gain = 1 + 0.05 * rng.normal(size=7)
        tare, load = pair(arm, poses, rng, sd=0.005, bias=0.0)
        tare, load = with_torque(tare, gain * tare.tau), with_torque(load, gain * load.tau)
        found = estimate_payload(arm, tare, load, JointNoise(0.005, outlier_rate=0.0, gain_sd=0.05))
        errors.append(found.mass - MASS)
        sds.append(found.mass_sd)
    # chi-square of 60 squares: within 0.55..1.6 with 99.9 %
    assert 0.55 < np.mean(np.square(errors)) / np.mean(np.square(sds)) < 1.6


def test_hanging_straight_does_not_tell_the_mass(arm):
    rng = np.random.default_rng(12)
    poses = np.zeros((6, 7))
    poses[:, ::2] = rng.uniform(-3, 3, (6, 4))  # only joints with vertical axes turn
    found = estimate_payload(arm, *pair(arm, poses, rng), JointNoise(SD))
    assert "mass" not in found.identified
    assert "not identifiable" in found.verdict
    assert "mass" in found.verdict
    assert np.all(np.isnan(found.center_of_mass))


def test_one_pose_tells_the_mass_but_not_the_center(arm, poses):
    found = estimate_payload(arm, *pair(arm, poses[:1], np.random.default_rng(13)), JointNoise(SD))
    assert found.identified == ("mass",)
    assert found.verdict.startswith("not identifiable from these poses: m c_x")


def test_reversed_sign_is_named_and_fixed(arm, poses):
    tare, load = pair(arm, poses, np.random.default_rng(14))
    straight = estimate_payload(arm, tare, load, JointNoise(SD))
    tare, load = with_torque(tare, -tare.tau), with_torque(load, -load.tau)
    with pytest.raises(InvalidInput, match="torque_sign=-1"):
        estimate_payload(arm, tare, load, JointNoise(SD))
    assert estimate_payload(arm, tare, load, JointNoise(SD), torque_sign=-1).mass == pytest.approx(straight.mass)


def test_bad_input_says_what_is_wrong(arm, poses):
    tare, load = pair(arm, poses, np.random.default_rng(15))
    noise = JointNoise(SD)
    with pytest.raises(InvalidInput, match="degrees"):
        estimate_payload(arm, JointReadings(np.degrees(poses), tare.tau), load, noise)
    with pytest.raises(InvalidInput, match="joint_7"):
        estimate_payload(arm, JointReadings(poses[:, :6], tare.tau[:, :6]), load, noise)
    with pytest.raises(InvalidInput, match="estimate_payload_motion"):
        estimate_payload(arm, JointReadings(poses, tare.tau, dq=np.ones_like(poses)), load, noise)
    exchanged = JointReadings(poses, tare.tau[:, [1, 0, 3, 2, 5, 4, 6]])
    with pytest.raises(InvalidInput, match="another order"):
        estimate_payload(arm, exchanged, load, noise)
    with pytest.raises(InvalidInput, match="no hold"):
        estimate_payload(arm, [], [load], noise)
    with pytest.raises(InvalidInput, match="nan"):
        JointReadings(poses, np.full_like(tare.tau, np.nan))
    with pytest.raises(InvalidInput, match="1 or -1"):
        estimate_payload(arm, tare, load, noise, torque_sign=0)
    with pytest.raises(InvalidInput, match="no reading"):
        estimate_payload(arm, JointReadings(poses[:0], tare.tau[:0]), load, noise)
    assert "exchanged" in estimate_payload(arm, load, tare, noise).verdict
