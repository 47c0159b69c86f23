"""The exploration: plan, act, measure, learn, until enough is known or nothing more is worth its time."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

from dynamics.errors import ActionFailed, InvalidInput, MotionRefused
from dynamics.objects import DeclaredObject
from dynamics.robot import Robot
from dynamics.signals import Phase
from estimation.belief import Belief
from estimation.conclude import conclude
from estimation.measurement import Measurement
from estimation.network import Network
from estimation.observation import Observation
from estimation.recording import Observed, Recorded, Recording, RunWriter
from estimation.size import SizeEstimate
from selection.actions import ACTIONS, Action, Demanding, Readings
from selection.actions.hand import Hand
from selection.lookahead import decide
from selection.planner import ALL_FAILED, ActionModel, Decision, PlanState, StopRules, plan
from selection.tape import Tape

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Settings:
    """What the exploration is after.

    Attributes:
        target: what the information is about, such as ``material``.
        price: of time [bits/s].
        confidence: probability of a class at which to stop.
        budget: robot time to spend at most [s].
        lookahead: whether to plan two steps ahead where that is worthwhile: where the budget does not hold all
            actions.
    """

    target: str = "material"
    price: float = 0.01
    confidence: float = 0.95
    budget: float = float("inf")
    lookahead: bool = True


@dataclass(frozen=True)
class Step:
    """One action of an exploration.

    Attributes:
        decision: what the planner thought, and chose.
        action: name of the action done.
        measurements: what it measured.
        notes: what else it found out, or why it failed.
        seconds: robot time that it took [s].
        ok: whether it succeeded.
        belief: what is believed after it.
        observations: what it perceived of classes.
    """

    decision: Decision
    action: str
    measurements: tuple[Measurement, ...]
    notes: tuple[str, ...]
    seconds: float
    ok: bool
    belief: Belief
    observations: tuple[Observation, ...] = ()


class Watcher(Protocol):
    """Is told how an exploration goes."""

    def begins(self, belief: Belief) -> None:
        """Show what is believed beforehand."""
        ...

    def decides(self, decision: Decision) -> None:
        """Show what the planner thinks of every action, and its choice."""
        ...

    def learns(self, step: Step) -> None:
        """Show what an action brought."""
        ...


class Exploration:
    """Explores one object.

    All it sees of the world are the robot's samples, the descriptions of arm and gripper, and what the user
    declares of the object.

    Args:
        robot: acts and reads.
        declared: what is known of the object.
        network: what is known of materials.
        prior: probabilities of the materials; the reference's if None.
        settings: what to explore for.
        watcher: is told how it goes.
        actions: the repertoire.

    Attributes:
        steps: what was done so far.
        belief: what is believed now.
        stopped_because: why it ended; empty while it goes on.

    Raises:
        InvalidInput: if the reference does not know anything that an action could tell, the gripper does not
            open wide enough for the object, or it stands out of reach.
    """

    def __init__(
        self,
        robot: Robot,
        declared: DeclaredObject,
        network: Network,
        prior: Mapping[str, float] | None,
        settings: Settings,
        watcher: Watcher,
        actions: Sequence[Action] = ACTIONS,
    ) -> None:
        self._robot, self._declared, self._settings, self._watcher = robot, declared, settings, watcher
        self._run: RunWriter | None = None
        self._tape = Tape(robot)
        self._hand = Hand(robot, declared, self._tape)
        self._actions = {action.name: action for action in actions if self._can_be_done(action)}
        found = {name: action.model(network) for name, action in self._actions.items()}
        self._models: dict[str, ActionModel] = {name: model for name, model in found.items() if model is not None}
        if not self._models:
            raise InvalidInput(
                f"reference {network.name}",
                network.quantities,
                "a quantity that an action measures: mass, elasticity",
            )
        self._blank = Belief(network, prior)
        self._size = SizeEstimate.declared(declared)
        self._measured: list[Measurement] = []
        self._observed: list[Observation] = []
        self._state = PlanState()
        self.steps: list[Step] = []
        self.stopped_because = ""
        self.belief = self._believed()

    @property
    def seconds(self) -> float:
        """Robot time spent [s]."""
        return self._state.spent_seconds

    def record(self, run: RunWriter) -> None:
        """Keep everything from now on in a run."""
        self._run = run
        self._tape.record(run)

    def on_phase(self, tell: Callable[[str, str], None]) -> None:
        """Tell of every phase of an action that begins: the action and the phase."""
        self._tape.on_phase(tell)

    def recall(self, past: Recording) -> None:
        """Take up an interrupted exploration: believe what was measured in it, without doing it again."""
        taken = [(recorded.action, recorded.measurement) for recorded in past.measurements]
        for name, measurement in taken:
            self._take(name, measurement)
        self._observed += [recorded.observation for recorded in past.observations]
        for name in dict.fromkeys(one.action for one in _in_order(past)):
            if name in self._models:
                self._state = _free_hand(self._state.after(self._models[name], 0.0))
        # The last measurement closed the last action that is believed; time after it led to nothing.
        if _in_order(past) and past.decisions:
            spent = _in_order(past)[-1].time - past.decisions[0].time
            self._state = replace(self._state, spent_seconds=self._state.spent_seconds + spent)
        self.belief = self._believed()

    def explore(self) -> None:
        """Go on until a reason to stop; it is left in `stopped_because`."""
        self._watcher.begins(self.belief)
        self._note_belief()
        while not self.stopped_because:
            self.step()

    def step(self) -> None:
        """Plan and do one action, or find a reason to stop."""
        decision = self._decide()
        if self._run is not None:
            self._run.decision(self._robot.read().time, decision_record(decision))
        if decision.choice is None:
            self.stopped_because = decision.stop or ALL_FAILED
            return
        step = self._do(decision, self._actions[decision.choice])
        self.steps.append(step)
        self._note_belief()
        self._watcher.learns(step)

    def rehearse(self) -> Iterator[tuple[str, tuple[Phase, ...], str]]:
        """Plan the next action and make its motions without measuring; with a robot that moves in thought.

        Yields:
            The action that was chosen, the stretches it would measure, and why it can not be done, or nothing. One
            that can not be done is followed by the next choice.
        """
        self._watcher.begins(self.belief)
        while (name := self._decide().choice) is not None:
            problem = ""
            try:
                self._actions[name].perform(self._hand)
            except (ActionFailed, MotionRefused, InvalidInput) as error:
                problem = str(error)
            yield name, self._tape.take(), problem
            if not problem:
                return
            self._state = self._state.failing(self._models[name], 0.0)

    def _decide(self) -> Decision:
        settings = self._settings
        decision = (decide if settings.lookahead else plan)(
            self.belief,
            tuple(_grasping_anew(model) for model in self._models.values()),
            settings.target,
            settings.price,
            self._state,
            StopRules(settings.confidence, settings.budget),
        )
        self._watcher.decides(decision)
        return decision

    def _do(self, decision: Decision, action: Action) -> Step:
        """Do an action; what fails on the object is part of the result, what fails on the robot is raised."""
        start = self._robot.read().time
        measurements: tuple[Measurement, ...] = ()
        observations: tuple[Observation, ...] = ()
        notes: tuple[str, ...] = ()
        ok = True
        self._hand.remarks.clear()
        try:
            action.perform(self._hand)
            findings = action.measure(self._readings())
            measurements, notes = findings.measurements, findings.notes
            observations = findings.observations
        except (ActionFailed, MotionRefused, InvalidInput) as error:
            log.info("%s failed: %s", action.name, error)
            ok, notes = False, (str(error),)
            self._recover()
        notes += tuple(self._hand.remarks)
        seconds = self._robot.read().time - start
        model = self._models[action.name]
        if ok:
            for measurement in measurements:
                if self._run is not None:
                    self._run.measurement(self._robot.read().time, action.name, measurement)
                self._take(action.name, measurement)
            for seen in observations:
                if self._run is not None:
                    self._run.observation(self._robot.read().time, action.name, seen)
                self._observed.append(seen)
            timed = replace(self._models[action.name], seconds=max(seconds - model.setup_seconds, 0.0))
            self._models[action.name] = timed
            self._state = _free_hand(self._state.after(timed, seconds))
        else:
            self._state = self._state.failing(model, seconds)
        self._tape.take()
        self.belief = self._believed()
        return Step(decision, action.name, measurements, notes, seconds, ok, self.belief, observations)

    def _can_be_done(self, action: Action) -> bool:
        """Tell whether what is declared of the object allows an action at all."""
        if isinstance(action, Demanding):
            try:
                action.check(self._hand)
            except ActionFailed as error:
                log.info("no %s: %s", action.name, error)
                return False
        return True

    def _recover(self) -> None:
        """Let go and rise; if even that is refused, the exploration ends here with the arm standing still."""
        try:
            self._hand.retreat()
        except MotionRefused as error:
            self._robot.stop()
            self.stopped_because = f"the arm could not retreat: {error}"

    def _readings(self) -> Readings:
        return Readings(self._robot, self._tape.take(), self._declared.shape, self._size, self._hand.edge)

    def _take(self, action: str, measurement: Measurement) -> None:
        """Learn from a measurement: of the object's width by its size, of other quantities by the network."""
        if measurement.property == "width":
            self._size = self._size.with_edge(self._hand.edge, measurement)
            return
        self._measured.append(measurement)
        model = self._models.get(action)
        if model is not None:
            self._models[action] = model.observed(measurement)

    def _believed(self) -> Belief:
        """Condition on everything known: the size as it is known now, and every measurement.

        From the start each time, for a better size replaces the one believed before.
        """
        return conclude(self._blank, self._size, self._measured, self._observed)

    def _note_belief(self) -> None:
        if self._run is not None:
            self._run.belief(self._robot.read().time, belief_record(self.belief))


def decision_record(decision: Decision) -> dict[str, object]:
    """Return a decision as it stands in the recording."""
    return {
        "target": decision.target,
        "price": decision.price,
        "horizon": decision.horizon,
        "actions": {
            score.name: {
                "bits": score.bits,
                "seconds": score.seconds,
                "value": score.value,
                "feasible": score.feasible,
                "reason": score.reason,
            }
            for score in decision.scores
        },
        "choice": decision.choice,
        "stop": decision.stop,
    }


def belief_record(belief: Belief) -> dict[str, object]:
    """Return a belief as it stands in the recording and in the result."""
    return {
        "belief": {name: belief.probabilities(name) for name in belief.network.variables},
        "properties": {
            name: {
                "mean": marginal.mean,
                "sd": marginal.sd,
                "unit": marginal.unit,
                # Moments of what has not been measured yet say little on a log scale: the tails make them.
                "median": marginal.quantile(0.5),
                "mode": marginal.mode(),
                "interval_90": list(marginal.interval(0.9)),
            }
            for name, marginal in ((name, belief.marginal(name)) for name in belief.network.quantities)
        },
    }


def _in_order(past: Recording) -> list[Recorded | Observed]:
    """Return what was measured and perceived, in order of time."""
    return sorted([*past.measurements, *past.observations], key=lambda one: one.time)


def _grasping_anew(model: ActionModel) -> ActionModel:
    """Return an action with its set-up as part of it, as every action here puts the object back at its end."""
    return replace(model, seconds=model.seconds + model.setup_seconds, setup=None, setup_seconds=0.0)


def _free_hand(state: PlanState) -> PlanState:
    """Return the state with the object put back: the next action has to grasp it again."""
    return replace(state, setups=frozenset())
