"""A run's beliefs and estimates made again from its recording, for the curves that a recording does not hold."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dynamics.compression import StressStrain
from dynamics.errors import PalpateError
from dynamics.signals import JointReadings, Phase
from estimation.belief import Belief
from estimation.conclude import conclude, density_of
from estimation.measurement import Measurement
from estimation.observation import Observation
from estimation.pinching import Slide
from estimation.reestimation import Known, known_of
from estimation.reestimation.again import closing_edge
from estimation.size import SizeEstimate
from estimation.stiffness import StiffnessEstimate
from selection.reporting.story import Beliefs, Step, Story

Array = NDArray[np.float64]

SAME_POSE = 0.03  # rad
AGREED = 1e-6  # of probabilities made again


@dataclass(frozen=True)
class Hold:
    """Joint torques while an object was held in one pose, next to those of the empty hand there.

    Attributes:
        before, load, after: torques less the mean of the empty ones [N m], (N, nv); before and after may be empty.
        predicted: what the estimated payload asks of the joints [N m], (nv,).
    """

    before: Array
    load: Array
    after: Array
    predicted: Array


@dataclass(frozen=True)
class Squeezing:
    """A squeeze: its curve, what was fitted to it, and the gripper's signals.

    Attributes:
        curve: the readings of closing pads.
        estimate: what they came to.
        time, opening, effort: of the pads while they closed on the object and opened again [s, m, A], (N,).
    """

    curve: StressStrain
    estimate: StiffnessEstimate
    time: Array
    opening: Array
    effort: Array


@dataclass(frozen=True)
class Rubbing:
    """Strokes over a surface.

    Attributes:
        tangential, normal: force of the pad on the object, a row a stroke [N], (strokes, N).
        coefficient, sd: friction [-].
    """

    tangential: Array
    normal: Array
    coefficient: float
    sd: float


@dataclass(frozen=True)
class Pinching:
    """Slides of closed pads down an object's sides.

    Attributes:
        slides: what each came to.
        coefficient, sd: friction [-].
    """

    slides: tuple[Slide, ...]
    coefficient: float
    sd: float


@dataclass(frozen=True)
class Analysis:
    """What could be made again of one step.

    Attributes:
        before, after: beliefs; None where they cannot be made, or would not be those of the time.
        readings: what was measured, as quantities that the reference knows.
        holds, squeezing, rubbing, pinching: by kind of action.
        notes: what could not be made, and why.
    """

    before: Belief | None = None
    after: Belief | None = None
    readings: tuple[Measurement, ...] = ()
    holds: tuple[Hold, ...] = ()
    squeezing: Squeezing | None = None
    rubbing: Rubbing | None = None
    pinching: Pinching | None = None
    notes: tuple[str, ...] = ()


def analyse(story: Story) -> tuple[dict[int, Analysis], tuple[str, ...]]:
    """Return what can be made again of every step, by its number, and what a reader should know."""
    try:
        known = known_of(story.recording.config)
    except PalpateError as error:
        return {}, (f"Beliefs and signals could not be looked into: {error}",)
    notes = list(known.notes)
    state = _State(known)
    found = {}
    for step in story.steps:
        found[step.number] = state.follow(story, step)
    if state.disagreement:
        notes.append(
            "The densities are left out where today's reference or program believes other than was believed then."
        )
    return found, tuple(notes)


class _State:
    """What was known at a step."""

    def __init__(self, known: Known) -> None:
        self.known = known
        self.size = None if known.declared is None else SizeEstimate.declared(known.declared)
        self.measured: list[Measurement] = []
        self.observed: list[Observation] = []
        self.disagreement = False

    def follow(self, story: Story, step: Step) -> Analysis:
        before = self._belief(step.before)
        phases: Sequence[Phase] = ()
        if step.episode is not None:
            phases = [story.recording.phase(mark) for mark in step.episode.marks]
        edge = closing_edge(self.known, phases)
        signals = self._signals(step, phases, edge)
        readings = []
        for one in step.measurements:
            if one.property == "width":
                if self.size is not None:
                    self.size = self.size.with_edge(edge, one)
                continue
            self.measured.append(one)
            known = self._known_reading(one)
            if known is not None:
                readings.append(known)
        self.observed += step.observations
        after = self._belief(step.after) if step.choice else None
        return Analysis(
            before,
            after,
            tuple(readings),
            signals.holds,
            signals.squeezing,
            signals.rubbing,
            signals.pinching,
            signals.notes,
        )

    def _known_reading(self, one: Measurement) -> Measurement | None:
        if self.known.blank is None or self.size is None:
            return None
        quantities = self.known.blank.network.quantities
        if one.property == "mass" and "mass" not in quantities:
            one = density_of(one, self.size.volume())
        return one if one.property in quantities else None

    def _belief(self, recorded: Beliefs | None) -> Belief | None:
        """Return the belief from the measurements so far, if it is the recorded one."""
        if self.known.blank is None or self.size is None or recorded is None:
            return None
        try:
            belief = conclude(self.known.blank, self.size, self.measured, self.observed)
            own = {variable: belief.probabilities(variable) for variable in recorded.classes}
        except PalpateError:
            self.disagreement = True
            return None
        if all(_agree(own[variable], recorded.classes[variable]) for variable in own):
            return belief
        self.disagreement = True
        return None

    def _signals(self, step: Step, phases: Sequence[Phase], edge: int) -> Analysis:
        kind = {"weigh": self._weigh, "squeeze": self._squeeze, "rub": self._rub}.get(step.choice)
        if kind is None or not phases:
            return Analysis()
        try:
            return kind(phases, edge)
        except (PalpateError, ValueError, np.linalg.LinAlgError) as error:
            return Analysis(notes=(f"The signals could not be looked into: {error}",))

    def _weigh(self, phases: Sequence[Phase], edge: int) -> Analysis:
        from estimation.weighing import measure_weighing

        estimate, _ = measure_weighing(self.known.arm, phases)
        tares = [phase.joints() for phase in phases if phase.name == "tare"]
        first_hold = next(i for i, phase in enumerate(phases) if phase.name == "hold")
        earlier = sum(phase.name == "tare" for phase in phases[:first_hold])
        holds = []
        for phase in phases:
            if phase.name != "hold":
                continue
            load = phase.joints()
            q = np.mean(load.q, axis=0)
            before, after = _near(tares[:earlier], q), _near(tares[earlier:], q)
            zero = np.mean(np.vstack([before, after]), axis=0) if len(before) + len(after) else np.nan
            predicted = self.known.arm.payload_regressor(q) @ estimate.parameters
            holds.append(Hold(before - zero, load.tau - zero, after - zero, predicted))
        return Analysis(holds=tuple(holds))

    def _squeeze(self, phases: Sequence[Phase], edge: int) -> Analysis:
        from estimation.squeezed import believe_squeeze
        from estimation.squeezing import closing_curve

        declared, arm, gripper = self.known.declared, self.known.arm, self.known.gripper
        if declared is None or self.size is None:
            return Analysis(notes=("No stress and strain: the object's shape and size are unknown.",))
        estimate = believe_squeeze(arm, gripper, declared.shape, self.size, edge, phases).estimate
        curve = closing_curve(gripper, estimate.geometry, phases)
        cycles = [p.gripper() for p in phases if p.name in ("close", "compress", "dwell", "release") and p.samples]
        series = (np.concatenate([getattr(c, name) for c in cycles]) for name in ("time", "opening", "effort"))
        return Analysis(squeezing=Squeezing(curve, estimate, *series))

    def _rub(self, phases: Sequence[Phase], edge: int) -> Analysis:
        from estimation.pinching import find_slides
        from estimation.rubbing import contact_forces, measure_rub

        arm, gripper = self.known.arm, self.known.gripper
        estimate, _ = measure_rub(arm, phases, gripper=gripper)
        if any(phase.name == "press" for phase in phases):
            found = find_slides(arm, gripper, phases)
            return Analysis(pinching=Pinching(found, estimate.coefficient, estimate.sd))
        slides = [phase.joints() for phase in phases if phase.name == "slide"]
        airs = [phase.joints() for phase in phases if phase.name == "air"]
        forces = [contact_forces(arm, a, b) for a, b in zip(slides, airs, strict=True)]
        tangential = np.array([np.linalg.norm(force[:, :2], axis=1) for force in forces])
        normal = np.array([-force[:, 2] for force in forces])
        return Analysis(rubbing=Rubbing(tangential, normal, estimate.coefficient, estimate.sd))


def _near(tares: Sequence[JointReadings], q: Array) -> Array:
    """Return the torques of the tares that were taken in a pose [N m], (N, nv)."""
    near = [tare.tau for tare in tares if np.max(np.abs(np.mean(tare.q, axis=0) - q)) < SAME_POSE]
    return np.vstack(near) if near else np.empty((0, len(q)))


def _agree(own: Mapping[str, float], recorded: Mapping[str, float]) -> bool:
    return set(own) == set(recorded) and all(math.isclose(own[k], recorded[k], abs_tol=AGREED) for k in own)
