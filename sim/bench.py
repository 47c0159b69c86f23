"""The bench in MuJoCo: an object between two driven plates, without arm, gravity or anything else that errs.

It is the reference for what a squeeze should say: :meth:`Bench.press` returns the true force and opening,
:meth:`Bench.squeeze` what sensors report of them.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Literal

import mujoco
import numpy as np
from mujoco import rollout
from numpy.typing import NDArray

from dynamics.bench import Plates, Stroke
from dynamics.errors import InvalidInput, PalpateError
from dynamics.gripper import ParallelGripper
from dynamics.signals import Phase
from sim.bench_scene import MAX_STRAIN, SIDES, Layout, bench_mjcf, damping_of, layout_of
from sim.bodies import Fidelity, prepare
from sim.calibration import bench_factor
from sim.contact import contact_law, own_stiffness
from sim.sensors import SensorModel, Sensors
from sim.truth import RIGID_ABOVE, TrueObject

Array = NDArray[np.float64]
Phases = tuple[tuple[str, int, int], ...]
Setting = Literal["accurate", "fast"]

TIMESTEPS: dict[Setting, float] = {"accurate": 0.002, "fast": 0.004}  # s
GAP = 0.003  # m from a plate to the object at the start, at least
RIGID_FORCE = 100.0  # N with which a rigid object is pressed at the target
AIR_TIME = 0.2  # s of closing in the air, at least
AIR_SHARE = 0.8  # of the gap that is surely air; the rest belongs to the compression
SPEED_UP = 0.02  # s in which the plates reach their speed
STIFF_DRIVE = 100.0  # stiffness of a drive that does not give, over the object's own
PERIOD = 0.01  # s between samples, at most
LEAST_READINGS = 100  # of a compression, as far as the time step allows
_STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS


class BenchError(PalpateError):
    """The physics engine reported a warning, so nothing it computes can be trusted any more."""


@dataclass(frozen=True)
class Pressed:
    """What truly happened in one stroke, at every step of the simulation.

    Attributes:
        time: from its start [s], (N,).
        opening: distance of the plates [m], (N,).
        force: with which a plate presses, the mean of the two [N], (N,).
        imbalance: largest difference of the two plates' forces [N].
        width: true extent of the object along the closing direction [m].
        phases: name, first row and row after the last of ``air``, ``compress``, ``dwell``, ``release``.
    """

    time: Array
    opening: Array
    force: Array
    imbalance: float
    width: float
    phases: Phases

    def rows(self, name: str) -> slice:
        """Return the rows of a phase."""
        start, stop = next((start, stop) for found, start, stop in self.phases if found == name)
        return slice(start, stop)

    def stiffness(self, low: float = 0.02, high: float = 0.10) -> float:
        """Return the slope of force over compression while closing [N/m], least squares with an intercept.

        The factor by which pads of an area A feel stiffer than a block of that cross-section follows from it:
        kappa = stiffness width / (E A).

        Args:
            low, high: strains between which it is taken.

        Raises:
            InvalidInput: if fewer than 5 readings lie between them.
        """
        loading = self.rows("compress")
        compression = self.width - self.opening[loading]
        inside = (compression >= low * self.width) & (compression <= high * self.width)
        if int(inside.sum()) < 5:
            raise InvalidInput("bench: strains", (low, high), f"a range with 5 readings, not {inside.sum()}")
        x, y = compression[inside], self.force[loading][inside]
        return float(np.sum((x - x.mean()) * y) / np.sum((x - x.mean()) ** 2))


class Bench:
    """Two plates and an object.

    ``accurate`` steps by 2 ms; ``fast`` by 4 ms, for more than 20 one-second strokes a second: its moduli are
    within 0.2 % of the accurate ones at 5 mm/s. The plates are ``pads`` of 22 x 37.5 mm or ``full``, larger than
    the object.

        bench = Bench(truth, "pads", fidelity="indentation")
        pressed = bench.press(Stroke(speed=0.01, target=0.9 * bench.width))
        kappa = pressed.stiffness() * bench.width / (truth.young_modulus * bench.gripper.pad_area)

    Args:
        truth: the object; where it stands does not matter.
        plates: which ones.
        setting: time step.
        fidelity: how the object deforms, see `sim.bodies`.
        noise: what the sensors add; nothing if None.
        seed: of the sensors' errors.
        edge: axis of the object to close along; the shorter of x and y if None.
        factor: by which its cells are too stiff; the calibrated one if None, see `sim.calibration`.
        above: height of the plates' middle over the object's [m].

    Attributes:
        truth: the object, with its modulus as it is now.
        width: true extent of the object along the closing direction [m].
    """

    def __init__(
        self,
        truth: TrueObject,
        plates: Plates = "pads",
        setting: Setting = "accurate",
        fidelity: Fidelity = "uniform",
        noise: SensorModel | None = None,
        seed: int = 0,
        edge: int | None = None,
        factor: float | None = None,
        above: float = 0.0,
    ) -> None:
        self.truth, self.timestep = truth, TIMESTEPS[setting]
        self._edge = (1 if truth.size[1] <= truth.size[0] else 0) if edge is None else edge
        self._layout = layout_of(truth, plates, self._edge, GAP, above)
        self.width = self._layout.width
        noise = noise or SensorModel.none()
        self._gripper = described(self._layout, noise, fidelity)
        self._fidelity: Fidelity = fidelity
        # The calibration is for pads that sink in; a box under plates larger than its faces is strained evenly.
        if factor is None and fidelity == "indentation" and not truth.is_rigid:
            even = plates == "full" and truth.shape == "box"
            factor = 1.0 if even else bench_factor(truth, self._edge)
        self._factor = factor
        self._plates: Plates = plates
        self._sensors = Sensors(noise, np.random.default_rng(seed), 0, PERIOD)
        self._clock = 0.0
        self._count = 0
        self._build(GAP)

    @property
    def gripper(self) -> ParallelGripper:
        """The plates, described as a gripper."""
        return self._gripper

    @property
    def edge(self) -> int:
        """Which edge of the object the plates close on."""
        return self._edge

    def set_modulus(self, young: float) -> None:
        """Give the object another Young's modulus [Pa], its contact law with it, without building it anew.

        Raises:
            InvalidInput: unless it is a number > 0 of a soft body, as the object was.
        """
        if not 0 < young <= RIGID_ABOVE or self.truth.is_rigid:
            raise InvalidInput("bench: Young's modulus [Pa]", young, f"of a soft body, 0 to {RIGID_ABOVE:g}")
        self._model.flex_stiffness[:] *= young / self.truth.young_modulus
        self.truth = dataclasses.replace(self.truth, young_modulus=young)
        law = contact_law(self.truth, self.timestep)
        self._model.flex_solref[:] = [law.time_constant, law.damping_ratio]
        self._model.flex_solimp[:, :2] = law.impedance
        self._model.body_invweight0[:] = self._weights
        prepare(self._model, self.truth, self.timestep)

    def press(self, stroke: Stroke) -> Pressed:
        """Do a stroke on the object at rest and return what truly happened.

        Raises:
            InvalidInput: for a drive that does not give and a target at which the object would be crushed.
            BenchError: if the physics engine warned.
        """
        if stroke.stiffness is None and stroke.target < (1 - MAX_STRAIN) * self.width - 1e-9:
            valid = f"at least {(1 - MAX_STRAIN) * self.width:.4g} m, or a drive that gives"
            raise InvalidInput("stroke: target [m]", stroke.target, valid)
        if stroke.target >= self.width:
            raise InvalidInput("stroke: target [m]", stroke.target, f"less than the object's {self.width:.4g} m")
        gap = max(GAP, AIR_TIME * stroke.speed / 2)
        if gap != self._gap:
            self._build(gap)
        self._set_drives(stroke)
        ways, phases = self._commands(stroke)
        if math.isfinite(stroke.max_force):
            # The plates stop closing where the force is met, which a stroke without a limit tells.
            free = self._run(ways[: phases[1][2]], phases[:2])
            if np.any(free.force >= stroke.max_force):
                ways, phases = self._commands(stroke, int(np.argmax(free.force >= stroke.max_force)) + 1)
        return self._run(ways, phases)

    def squeeze(self, stroke: Stroke) -> tuple[Phase, ...]:
        """Squeeze the object once and return what the sensors read of it."""
        pressed = self.press(stroke)
        loading = pressed.rows("compress")
        wanted = (loading.stop - loading.start) // LEAST_READINGS
        every = min(max(wanted, 1), round(PERIOD / self.timestep))
        friction, per_ampere = self._sensors.model.grip_friction, self._gripper.force_per_ampere
        currents = np.maximum(pressed.force - friction, 0.0) / per_ampere
        none = np.zeros(0)
        phases = []
        for name, start, stop in pressed.phases:
            samples = tuple(
                self._sensors.sample(
                    self._clock + float(pressed.time[row]),
                    none,
                    none,
                    none,
                    float(pressed.opening[row]),
                    float(currents[row]),
                )
                for row in range(start + every - 1, stop, every)
            )
            if samples:
                phases.append(Phase("squeeze", name, self._count, samples))
        self._clock += self.timestep * len(pressed.time)
        self._count += 1
        return tuple(phases)

    def _build(self, gap: float) -> None:
        """Compile the scene with so much air before the plates [m]."""
        self._gap = gap
        self._layout = layout_of(self.truth, self._plates, self._edge, gap, self._layout.above)
        text = bench_mjcf(self.truth, self._layout, self._fidelity, self.timestep, self._factor)
        self._model = mujoco.MjModel.from_xml_string(text)
        self._data = mujoco.MjData(self._model)
        self._weights = self._model.body_invweight0.copy()
        prepare(self._model, self.truth, self.timestep)
        mujoco.mj_forward(self._model, self._data)
        self._start = np.zeros(mujoco.mj_stateSize(self._model, _STATE))
        mujoco.mj_getState(self._model, self._data, self._start, _STATE)

    def _set_drives(self, stroke: Stroke) -> None:
        stiffness = stroke.stiffness
        if stiffness is None:
            stiffness = max(STIFF_DRIVE * own_stiffness(self.truth), 1e5)
            if self.truth.is_rigid:
                stiffness = 2 * RIGID_FORCE / (self.width - stroke.target)
        model = self._model
        model.actuator_gainprm[:, 0] = stiffness
        model.actuator_biasprm[:, 1:3] = -stiffness, -damping_of(stiffness)

    def _commands(self, stroke: Stroke, stop: int | None = None) -> tuple[Array, Phases]:
        """Return the commanded way of a plate at every step [m], (N,), and the phases' rows.

        Args:
            stroke: what is to be done.
            stop: steps after which the plates stop closing; None to reach the target.
        """
        dt, speed = self.timestep, stroke.speed / 2
        closing = _moved(self._layout.start - stroke.target / 2, speed, dt)[:stop]
        way = float(closing[-1])
        opening = way - _moved(way, speed, dt)
        air = int(np.searchsorted(closing, AIR_SHARE * (self._layout.start - self.width / 2)))
        still = round(stroke.dwell / dt)
        ways = np.concatenate([closing, np.full(still, way), opening])
        marks = np.cumsum([0, air, len(closing) - air, still, len(opening)])
        names = ("air", "compress", "dwell", "release")
        rows = [(name, int(a), int(b)) for name, a, b in zip(names, marks[:-1], marks[1:], strict=True)]
        return ways, tuple(row for row in rows if row[2] > row[1])

    def _run(self, commands: Array, phases: Phases) -> Pressed:
        """Drive the plates from the start and return what happened."""
        mujoco.mj_resetData(self._model, self._data)
        control = np.repeat(commands[None, :, None], len(SIDES), axis=2)
        all_states, all_readings = rollout.rollout(self._model, [self._data], self._start[None], control)
        self._check()
        states, readings = all_states[0], all_readings[0]
        # A contact force is that of the step, implicit in the place that the step ends at.
        ways = states[:, [1 + self._model.joint(side).qposadr[0] for side in SIDES]]
        left, right = (readings[:, 1 + self._edge + 4 * side] for side in range(2))
        return Pressed(
            time=self.timestep * np.arange(1.0, len(readings) + 1),
            opening=2 * self._layout.start - ways.sum(axis=1),
            force=(np.abs(left) + np.abs(right)) / 2,
            imbalance=float(np.max(np.abs(left + right))),
            width=self.width,
            phases=phases,
        )

    def _check(self) -> None:
        counts = self._data.warning.number
        if counts.any():
            names = [mujoco.mjtWarning(i).name for i, count in enumerate(counts) if count]
            raise BenchError(f"MuJoCo warned on the bench: {', '.join(names)}")


def described(layout: Layout, noise: SensorModel, fidelity: Fidelity) -> ParallelGripper:
    """Return the plates as a gripper: calibrated as well as the sensors allow, 60 N/A by definition."""
    return ParallelGripper(
        name="bench",
        max_opening=1.0,
        pad_width=layout.face[0],
        pad_length=layout.face[1],
        min_speed=1e-4,
        max_speed=0.3,
        crank_length=0.5,
        crank_offset=0.0,
        crank_height=0.0,
        pad_height=0.0,
        opening_quantum=noise.opening_quantum,
        effort_quantum=noise.effort_quantum,
        force_per_ampere=60.0,
        force_per_ampere_sd=60.0 * noise.effort_gain,
        friction_force=noise.grip_friction,
        load_spread="face" if fidelity == "uniform" else "pad",
    )


def _moved(way: float, speed: float, timestep: float) -> Array:
    """Return the way made after every step by a motion that speeds up and slows down evenly [m], (N,)."""
    ramp = min(SPEED_UP, way / speed)
    end = way / speed + ramp
    time = timestep * np.arange(1.0, math.ceil(end / timestep) + 1)
    up = speed * time**2 / (2 * ramp)
    down = way - speed * np.maximum(end - time, 0.0) ** 2 / (2 * ramp)
    steady = speed * (time - ramp / 2)
    made: Array = np.where(time < ramp, up, np.where(time <= end - ramp, steady, down))
    return made
