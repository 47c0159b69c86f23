"""What the simulated sensors do to the truth: a declared, seeded model whose parts can all be set to zero.

The figures of the default are assumptions from public reports on the Gen3 (Kinova-kortex2 issues 38 and 145,
ros_kortex issues 237 and 239: offsets dominate, they change at each start, readings depend on the direction of
motion); no noise figure of its torque sensors is published.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from dynamics.signals import Sample
from dynamics.tables import Table, read_toml

Array = NDArray[np.float64]

_LARGE = 4  # the first four joints have the large actuators


@dataclass(frozen=True)
class SensorModel:
    """Standard deviations and sizes of what the sensors add. Pairs are for the large and the small joints.

    Attributes:
        torque_noise: white noise of a torque sample [N m].
        torque_bias: offset of a joint, drawn once a start [N m].
        torque_drift: random walk of a joint's offset [N m / sqrt(min)].
        torque_hysteresis: half the band between the two directions of motion [N m].
        torque_gain: relative error of a joint's scale, drawn once a start [-].
        hysteresis_width: joint travel over which the reading moves by half the band after a reversal [rad].
        position_noise, velocity_noise: white noise of joint position and velocity [rad, rad/s].
        opening_quantum: step of the reported opening [m].
        effort_quantum: step of the reported gripper current [A].
        effort_noise: white noise of the gripper current [A].
        effort_proportional: white noise in proportion to the current [-].
        effort_gain: relative error of the current's scale, drawn once a start [-].
        grip_friction: pad force that the gripper's own friction swallows [N].
        holding_current: what the current reads while the gripper stands, whatever the force [A].
    """

    torque_noise: tuple[float, float] = (0.1, 0.05)
    torque_bias: tuple[float, float] = (0.2, 0.2)
    torque_drift: float = 0.01
    torque_hysteresis: tuple[float, float] = (0.3, 0.15)
    torque_gain: float = 0.01
    hysteresis_width: float = 0.01
    position_noise: float = 1e-5
    velocity_noise: float = 1e-3
    opening_quantum: float = 0.085 / 227
    effort_quantum: float = 0.01
    effort_noise: float = 0.01
    effort_proportional: float = 0.02
    effort_gain: float = 0.05
    grip_friction: float = 0.5
    holding_current: float = 0.05

    @classmethod
    def none(cls) -> SensorModel:
        """Return sensors that report the truth; standing currents still say nothing of force."""
        kept = ("hysteresis_width", "holding_current")
        zero = {f.name: (0.0, 0.0) if isinstance(f.default, tuple) else 0.0 for f in fields(cls)}
        return cls(**{name: value for name, value in zero.items() if name not in kept})  # type: ignore[arg-type]

    @classmethod
    def from_file(cls, path: Path) -> SensorModel:
        """Read a model from a TOML file whose keys are the attributes; what is left out keeps its default.

        Raises:
            InvalidInput: for an unknown key or a value that is not a number >= 0.
        """
        table = Table(str(path), read_toml(path))
        given: dict[str, float | tuple[float, ...]] = {}
        for field in fields(cls):
            if isinstance(field.default, tuple):
                given[field.name] = table.numbers(field.name, 2, field.default, at_least=0.0)
            else:
                given[field.name] = table.number(field.name, float(field.default), at_least=0.0)  # type: ignore[arg-type]
        table.done()
        return cls(**given)  # type: ignore[arg-type]


class Sensors:
    """The sensors of one start of the robot.

    Args:
        model: how they err.
        rng: where the errors come from.
        joints: how many joints there are.
        period: time between two samples [s].
    """

    def __init__(self, model: SensorModel, rng: np.random.Generator, joints: int, period: float) -> None:
        self.model = model
        self._rng = rng
        self._noise = _per_joint(model.torque_noise, joints)
        self._band = _per_joint(model.torque_hysteresis, joints)
        self._gain = 1 + model.torque_gain * rng.standard_normal(joints)
        self._bias = _per_joint(model.torque_bias, joints) * rng.standard_normal(joints)
        self._walk = model.torque_drift * np.sqrt(period / 60)
        self._effort_gain = 1 + model.effort_gain * rng.standard_normal()
        self._side = np.zeros(joints)
        self._last_q: Array | None = None

    def sample(
        self, time: float, q: Array, dq: Array, tau: Array, opening: float, current: float | None
    ) -> Sample:
        """Return what is reported of a true state.

        Args:
            time: [s].
            q, dq, tau: true joint state, (nv,).
            opening: true opening [m].
            current: motor current that the moving gripper needs for its force [A]; None while it stands.
        """
        model, rng = self.model, self._rng
        if self._last_q is not None:
            # A play operator: the reading moves across the band as the joint turns, and stays when it rests.
            turned = (q - self._last_q) / max(model.hysteresis_width, 1e-9)
            self._side = np.clip(self._side + turned, -1, 1)
        self._last_q = q.copy()
        self._bias = self._bias + self._walk * rng.standard_normal(len(q))
        read_tau = self._gain * tau + self._bias + self._band * self._side
        read_tau = read_tau + self._noise * rng.standard_normal(len(q))
        effort = model.holding_current if current is None else self._effort_gain * max(current, 0.0)
        effort *= 1 + model.effort_proportional * rng.standard_normal()
        effort += model.effort_noise * rng.standard_normal()
        return Sample(
            time=time,
            q=q + model.position_noise * rng.standard_normal(len(q)),
            dq=dq + model.velocity_noise * rng.standard_normal(len(q)),
            tau=read_tau,
            opening=_quantised(opening, model.opening_quantum),
            effort=_quantised(effort, model.effort_quantum),
        )


def _per_joint(pair: tuple[float, float], joints: int) -> Array:
    large = min(_LARGE, joints)
    return np.array([pair[0]] * large + [pair[1]] * (joints - large))


def _quantised(value: float, quantum: float) -> float:
    return round(value / quantum) * quantum if quantum > 0 else value
