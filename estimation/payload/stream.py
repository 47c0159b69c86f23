"""Weigh while the readings come in: an incremental factor graph that always holds the batch answer."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dynamics.arm import Arm
from dynamics.errors import InvalidInput
from dynamics.signals import JointReadings
from estimation.graph import key, linear_container, prior_container
from estimation.payload.checks import check_gravity, check_readings
from estimation.payload.em import HUBER, MAX_ROUNDS, START_ROUNDS, TOLERANCE
from estimation.payload.estimate import PRIOR_SD, PayloadEstimate
from estimation.payload.graph import BIAS_PRIOR_SD, Design, Fit, design_readings
from estimation.payload.holds import reduce_holds
from estimation.payload.noise import JointNoise, quantisation_variance, responsibilities
from estimation.payload.static import summarise

Array = NDArray[np.float64]


class PayloadStream:
    """Payload of readings that come one by one, by gtsam's ISAM2.

    A new reading adds a factor; when an estimate is asked for, readings whose weight has changed have theirs
    exchanged until all weights settle: the answer is that of :func:`estimation.payload.estimate_payload` on
    everything so far.
    """

    def __init__(self, arm: Arm, noise: JointNoise, torque_sign: int = 1) -> None:
        """Start without readings.

        Args:
            arm: the arm, with its gripper.
            noise: of the torques; its sd must be given, and it must not share offsets between poses.
            torque_sign: -1 for sensors that read the reaction.

        Raises:
            InvalidInput: for a noise that a stream cannot work with.
        """
        if noise.sd is None:
            raise InvalidInput("payload stream: noise", "sd None", "a given sd: the first readings cannot tell it")
        if noise.pose_sd is not None and np.any(np.asarray(noise.pose_sd) > 0):
            raise InvalidInput("payload stream: noise", f"pose_sd {noise.pose_sd}", "0 or None")
        if torque_sign not in (-1, 1):
            raise InvalidInput("torque_sign", torque_sign, "1 or -1")
        self._arm, self._noise, self._sign = arm, noise, torque_sign
        sd, quantum = noise.per_joint("sd", arm.nv), noise.per_joint("quantum", arm.nv)
        self._sd: Array = np.sqrt(sd**2 + quantisation_variance(quantum, np.zeros(arm.nv)))
        self._drift = noise.per_joint("drift", arm.nv)
        self._q: list[Array] = []
        self._tau: list[Array] = []
        self._loaded: list[bool] = []
        self._torque: list[Array] = []
        self._tool: list[Array] = []
        self._precision: list[Array] = []
        self._factor: list[int] = []
        self._isam = _new_isam()
        self._start()

    def __len__(self) -> int:
        return len(self._q)

    def add(self, kind: Literal["tare", "load"], q: ArrayLike, tau: ArrayLike) -> None:
        """Take one reading, a pose's mean torque for instance, in order of time.

        Args:
            kind: ``tare`` without the payload, ``load`` with it.
            q, tau: position and torque [rad, N m], (nv,).

        Raises:
            InvalidInput: for a reading that cannot be this arm's.
        """
        if kind not in ("tare", "load"):
            raise InvalidInput("payload stream: kind of reading", kind, "tare, load")
        reading = JointReadings(np.atleast_2d(np.asarray(q, float)), np.atleast_2d(np.asarray(tau, float)))
        check_readings(self._arm, reduce_holds(reading, kind), kind)
        position, torque = reading.q[0], self._sign * reading.tau[0]
        body = self._arm.payload_regressor(position)
        self._q.append(position)
        self._tau.append(torque)
        self._loaded.append(kind == "load")
        self._torque.append(torque - self._arm.gravity(position))
        self._tool.append(np.hstack([body * (kind == "load"), body]))
        self._precision.append(self._sd**-2)
        self._append(len(self) - 1)

    def estimate(self) -> PayloadEstimate:
        """Return the estimate of everything so far; tare rows come before load rows in its arrays.

        Raises:
            InvalidInput: before there is one tare and one load, or if the tares are not this arm's.
        """
        loaded = np.array(self._loaded, bool)
        if not loaded.any() or loaded.all():
            raise InvalidInput("payload stream", f"{(~loaded).sum()} tares, {loaded.sum()} loads", "one of each")
        order = np.argsort(loaded, kind="stable")
        time = np.arange(len(self), dtype=float)
        parts = [
            reduce_holds(JointReadings(np.array(self._q)[i], np.array(self._tau)[i], time=time[i]), "stream")
            for i in (np.flatnonzero(~loaded), np.flatnonzero(loaded))
        ]
        design: Design = design_readings(self._arm, parts[0], parts[1], friction=False)
        check_gravity(design, len(parts[0]))
        self._settle()
        residual = self._residual()
        fit = Fit(self._isam.calculateBestEstimate().atVector(key("x")), residual[order], np.zeros((0, 0)))
        belief = responsibilities(fit.residual, self._sd, self._noise.outlier_rate)
        sd = np.broadcast_to(self._sd, residual.shape).copy()
        return summarise(design, fit, belief, sd, self._noise)

    def known_to(self, mass_sd: float) -> bool:
        """Tell whether the mass is known to a standard deviation [kg], so that weighing can stop."""
        if len(set(self._loaded)) < 2:
            return False
        estimate = self.estimate()
        return "mass" in estimate.identified and estimate.mass_sd <= mass_sd

    def _start(self) -> None:
        import gtsam

        graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
        prior_container(graph, key("x"), np.concatenate([PRIOR_SD, PRIOR_SD]))
        prior_container(graph, key("b"), np.full(self._arm.nv, BIAS_PRIOR_SD))
        values.insert(key("x"), np.zeros(8))
        values.insert(key("b"), np.zeros(self._arm.nv))
        self._isam.update(graph, values)

    @property
    def _walks(self) -> bool:
        return bool(np.any(self._drift > 0))

    def _bias(self, index: int) -> int:
        return key("b", index) if self._walks else key("b")

    def _append(self, index: int) -> None:
        """Add the factor of a new reading, and the step of the bias that leads to it."""
        import gtsam

        graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
        self._add_reading(graph, index)
        if self._walks and index > 0:
            values.insert(self._bias(index), np.zeros(self._arm.nv))
            eye = np.eye(self._arm.nv)
            blocks = {self._bias(index - 1): -eye, self._bias(index): eye}
            linear_container(graph, blocks, np.zeros(self._arm.nv), np.maximum(self._drift, 1e-9))
        self._factor.append(int(self._isam.update(graph, values).getNewFactorsIndices()[0]))

    def _add_reading(self, graph: Any, index: int) -> None:
        blocks = {key("x"): self._tool[index], self._bias(index): np.eye(self._arm.nv)}
        linear_container(graph, blocks, self._torque[index], 1 / np.sqrt(self._precision[index]))

    def _settle(self) -> None:
        """Weigh the readings by the batch's steps from its start: it must not matter in which order they came."""
        rate = self._noise.outlier_rate
        good = np.broadcast_to(self._sd**-2, (len(self), self._arm.nv))
        before = self._reweigh(good)
        if rate == 0:
            return
        for _ in range(START_ROUNDS):
            before = self._reweigh(good / np.maximum(np.abs(before) / self._sd / HUBER, 1.0))
        for _ in range(MAX_ROUNDS):
            after = self._reweigh(responsibilities(before, self._sd, rate).precision)
            if np.max(np.abs(after - before) / self._sd) < TOLERANCE:
                break
            before = after

    def _reweigh(self, precision: Array) -> Array:
        """Exchange the factors whose weights change; return the residuals then [N m], (N, nv)."""
        import gtsam

        change = np.abs(precision / np.array(self._precision) - 1).max(axis=1)
        changed = [int(i) for i in np.flatnonzero(change > 0.1 * TOLERANCE)]
        graph, removed = gtsam.NonlinearFactorGraph(), [self._factor[i] for i in changed]
        for i in changed:
            self._precision[i] = precision[i]
            self._add_reading(graph, i)
        if changed:
            indices = self._isam.update(graph, gtsam.Values(), removed).getNewFactorsIndices()
            for i, slot in zip(changed, indices, strict=True):
                self._factor[i] = int(slot)
        return self._residual()

    def _residual(self) -> Array:
        values = self._isam.calculateBestEstimate()
        tool = values.atVector(key("x"))
        bias = np.array([values.atVector(self._bias(i)) for i in range(len(self))])
        residual: Array = np.array(self._torque) - np.array(self._tool) @ tool - bias
        return residual


def _new_isam() -> Any:
    import gtsam

    parameters = gtsam.ISAM2Params()
    parameters.setOptimizationParams(gtsam.ISAM2GaussNewtonParams(0.0))
    parameters.setFactorization("QR")
    parameters.relinearizeSkip = 1_000_000  # the graph is linear
    return gtsam.ISAM2(parameters)
