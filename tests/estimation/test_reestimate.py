"""Recordings estimated again: the same numbers from the same samples, and phases found where none were marked."""

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from dynamics.arm import Arm
from dynamics.errors import InvalidInput
from dynamics.gripper import ParallelGripper, robotiq_2f85
from dynamics.objects import DeclaredObject
from dynamics.signals import Phase, Sample
from estimation.measurement import Measurement
from estimation.recording import Recording, RunWriter, Samples, read_recording
from estimation.reestimate import main
from estimation.reestimation import Known, arm_named, describe, known_of, reestimate
from estimation.reestimation.again import matched
from estimation.reestimation.batch import Request, estimate_all
from estimation.squeezing import measure_squeeze
from estimation.weighing import measure_weighing

MASS, LEVER = 0.4, 0.03  # kg, m
MODULUS, WIDTH = 6e4, 0.05  # Pa, m
POSES = np.array(
    [
        [0.3, 0.6, 0.2, 1.9, 0.1, -0.9, 1.5],
        [-0.4, 0.9, 0.1, 1.4, -0.3, -0.5, 1.0],
        [0.1, 0.3, -0.5, 2.1, 0.6, -1.2, 0.2],
    ]
)
OBJECT_FILE = """[declared]
shape = "box"
size_m = [0.05, 0.05, 0.05]
size_sd_m = 0.0005
"""


@pytest.fixture(scope="module")
def arm() -> Arm:
    return Arm.gen3()


@pytest.fixture(scope="module")
def gripper() -> ParallelGripper:
    return replace(robotiq_2f85("face"), friction_force=0.0, friction_force_sd=0.0)


def payload_torque(arm: Arm, q: np.ndarray, mass: float) -> np.ndarray:
    """Return the torque that holds arm and payload, by the change of potential energy of a point mass."""

    def height(angles: np.ndarray) -> float:
        return float((arm.tool_pose(angles) @ np.array([0, 0, LEVER, 1]))[2])

    step = 1e-6
    slope = [(height(q + step * e) - height(q - step * e)) / (2 * step) for e in np.eye(arm.nv)]
    return arm.gravity(q) + mass * 9.81 * np.array(slope)


class Story:
    """Samples of a made-up robot that weighs and squeezes."""

    def __init__(self, arm: Arm, gripper: ParallelGripper, seed: int = 1) -> None:
        self.arm, self.gripper = arm, gripper
        self.random = np.random.default_rng(seed)
        self.time, self.q = 0.123456789, POSES[0]
        self.opening = 0.08
        self.samples: list[Sample] = []
        self.phases: list[Phase] = []

    def stand(self, mass: float, seconds: float = 1.2, name: str = "") -> None:
        torque = payload_torque(self.arm, self.q, mass)
        self._say(name, [(self.q, np.zeros(7), torque, self.opening, 0.05)] * round(seconds * 100))

    def go(self, q: np.ndarray, mass: float) -> None:
        shares = (1 - np.cos(np.linspace(0, np.pi, 80))) / 2
        path = self.q + shares[:, None] * (q - self.q)
        speed = np.gradient(path, 0.01, axis=0)
        self._say(
            "",
            [
                (a, v, payload_torque(self.arm, a, mass), self.opening, 0.05)
                for a, v in zip(path, speed, strict=True)
            ],
        )
        self.q = q

    def close(self, opening: float, name: str) -> None:
        rows = []
        area = 0.05 * 0.0375  # of the pads' face that the object fills
        for step in np.arange(self.opening, opening, -0.0002):
            strain = max(WIDTH - step, 0.0) / WIDTH
            reported = round(step / self.gripper.opening_quantum) * self.gripper.opening_quantum
            force = MODULUS * min(area, self.gripper.pad_area) * strain
            rows.append(
                (
                    self.q,
                    np.zeros(7),
                    self.arm.gravity(self.q),
                    reported,
                    0.05 + force / self.gripper.force_per_ampere,
                )
            )
        self._say(name, rows)
        self.opening = opening

    def _say(self, name: str, rows: Sequence[tuple[np.ndarray, np.ndarray, np.ndarray, float, float]]) -> None:
        said = []
        for q, dq, tau, opening, effort in rows:
            self.time += 0.01 + 1e-4 * self.random.random()
            noise = self.random.normal(0, 0.05, 7)
            said.append(Sample(self.time, q, dq, tau + noise, opening, effort + self.random.normal(0, 0.003)))
        self.samples += said
        if name:
            index = sum(phase.name == name for phase in self.phases)
            self.phases.append(Phase("weigh" if name in ("tare", "hold") else "squeeze", name, index, tuple(said)))

    def weigh(self) -> None:
        for mass, name in ((0.0, "tare"), (MASS, "hold")):
            for q in POSES:
                self.go(q, mass)
                self.stand(mass, name=name)
            if not mass:
                self.close(WIDTH - 0.003, "")

    def squeeze(self) -> None:
        self.opening = 0.08
        self.stand(0.0)
        self.close(0.058, "air")
        self.stand(0.0, 0.3)
        self.close(0.040, "compress")
        self.stand(0.0, 0.3)


def record(directory: Path, story: Story, measured: dict[str, Sequence[Measurement]], marks: bool = True) -> Path:
    """Write a story as an exploration would."""
    config = {"object_file": OBJECT_FILE, "object": "cube", **describe(story.arm, story.gripper)}
    first = {id(phase.samples[0]): phase for phase in story.phases}
    last = {id(phase.samples[-1]): phase for phase in story.phases}
    with RunWriter.create(directory, config, "cube", story.arm.joint_names) as run:
        action = ""
        for sample in story.samples:
            phase = first.get(id(sample))
            if phase is not None and marks:
                if phase.action != action:
                    for one in measured.get(action, ()):
                        run.measurement(sample.time, action, one)
                    action = phase.action
                    run.decision(sample.time, {"choice": action})
                run.phase(phase.action, phase.name, phase.index, sample.time)
            run.sample(sample)
            if id(sample) in last and marks:
                run.end_phase(sample.time)
        for one in measured.get(action, ()):
            run.measurement(story.time, action, one)
        run.finish({})
    return directory


@pytest.fixture(scope="module")
def told(arm: Arm, gripper: ParallelGripper) -> tuple[Story, dict[str, Sequence[Measurement]]]:
    """Return a story, and what was measured as it happened."""
    story = Story(arm, gripper)
    story.weigh()
    story.squeeze()
    weighed = measure_weighing(arm, [p for p in story.phases if p.action == "weigh"])[1]
    squeezed = measure_squeeze(
        gripper, "box", (0.05,) * 3, [p for p in story.phases if p.action == "squeeze"], size_sd=(0.0005,) * 3
    )[1]
    return story, {"weigh": weighed, "squeeze": squeezed}


def test_the_same_samples_give_the_same_numbers(
    tmp_path: Path, told: tuple[Story, dict[str, Sequence[Measurement]]]
) -> None:
    story, measured = told
    recording = read_recording(record(tmp_path / "run", story, measured))
    again = reestimate(recording, known_of(recording.config))
    assert [action.action for action in again.actions] == ["weigh", "squeeze"]
    assert {m.property for a in again.actions for m in a.measurements} == {"mass", "elasticity", "width"}
    for action in again.actions:
        assert action.recorded == tuple(measured[action.action])
        for new, old in matched(action):
            assert new is not None
            assert old is not None
            assert new.mean == pytest.approx(old.mean, rel=1e-9)
            assert new.sd == pytest.approx(old.sd, rel=1e-9)


def test_the_estimates_are_near_the_truth(told: tuple[Story, dict[str, Sequence[Measurement]]]) -> None:
    _, measured = told
    (mass,) = measured["weigh"]
    assert abs(mass.mean - MASS) < 4 * mass.sd
    by_name = {m.property: m for m in measured["squeeze"]}
    assert abs(by_name["width"].mean - WIDTH) < 5e-4


def test_an_interrupted_action_is_left_out_and_told(
    tmp_path: Path, told: tuple[Story, dict[str, Sequence[Measurement]]]
) -> None:
    story, measured = told
    recording = read_recording(record(tmp_path / "run", story, {"weigh": measured["weigh"]}))
    weigh, squeeze = reestimate(recording, known_of(recording.config)).actions
    assert weigh.measurements
    assert not squeeze.measurements
    assert "left out" in squeeze.notes[0]
    assert "elasticity" in squeeze.notes[0]


def test_phases_are_found_where_nobody_marked_them(
    tmp_path: Path, told: tuple[Story, dict[str, Sequence[Measurement]]]
) -> None:
    story, measured = told
    recording = read_recording(record(tmp_path / "run", story, {}, marks=False))
    assert not recording.marks
    again = reestimate(recording, known_of(recording.config))
    found = {m.property: m for action in again.actions for m in action.measurements}
    (mass,) = measured["weigh"]
    assert abs(found["mass"].mean - MASS) < 4 * found["mass"].sd
    assert found["mass"].mean == pytest.approx(mass.mean, abs=2 * mass.sd)
    modulus = next(m for m in measured["squeeze"] if m.property == "elasticity")
    assert found["elasticity"].mean == pytest.approx(modulus.mean, rel=0.05)
    assert any("no marks" in note for note in again.notes)


def test_a_log_of_the_empty_arm_is_its_tare(arm: Arm, gripper: ParallelGripper) -> None:
    def log(mass: float, seed: int) -> Recording:
        story = Story(arm, gripper, seed)
        for q in POSES:
            story.go(q, mass)
            story.stand(mass)
        rows = story.samples
        columns = [np.array([getattr(s, name) for s in rows]) for name in ("time", "q", "dq", "tau")]
        missing = np.full(len(rows), np.nan)
        return Recording(Path("log"), Samples(*columns, missing, missing))

    again = reestimate(log(MASS, 2), Known(arm, gripper), [log(0.0, 3)])
    (mass,) = again.actions[0].measurements
    assert abs(mass.mean - MASS) < 4 * mass.sd
    with pytest.raises(InvalidInput, match="--tare"):
        reestimate(log(MASS, 2), Known(arm, gripper))


def test_the_edge_that_is_closed_on_is_read_off_the_arm(arm: Arm, gripper: ParallelGripper) -> None:
    from estimation.reestimation.again import closing_edge

    story = Story(arm, gripper)
    story.squeeze()
    closing = arm.tool_pose(POSES[0])[:2, 1]
    for turn, edge in ((0.0, 1), (np.pi / 2, 0)):
        yaw = float(np.arctan2(-closing[0], closing[1])) + turn  # the object's y axis along the closing direction
        declared = DeclaredObject("box", "box", (0.05, 0.05, 0.05), 0.0005, (0.5, 0.0), yaw)
        assert closing_edge(Known(arm, gripper, declared), story.phases) == edge


def test_robots_are_known_by_the_names_in_recordings() -> None:
    for name in ("gen3-V12-vision-2f85", "gen3-BRAKES-2f85", "gen3-V12"):
        assert arm_named(name).name == name
    with pytest.raises(InvalidInput):
        arm_named("hal9000")
    with pytest.raises(InvalidInput, match="--tool-frame"):
        arm_named("robot.urdf")


def test_the_command_line(
    tmp_path: Path, told: tuple[Story, dict[str, Sequence[Measurement]]], capsys: pytest.CaptureFixture[str]
) -> None:
    story, measured = told
    run = record(tmp_path / "runs" / "a", story, measured)
    record(tmp_path / "runs" / "b", story, measured)
    assert main([str(run), "--compare"]) == 0
    shown = capsys.readouterr().out
    assert "as recorded" in shown
    assert "nothing changed" in shown
    assert main([str(tmp_path / "runs"), "--json", "--workers", "2"]) == 0
    first, second = json.loads(capsys.readouterr().out)
    assert first["actions"] == second["actions"]
    assert [m["property"] for a in first["actions"] for m in a["measurements"]] == ["mass", "elasticity", "width"]


def test_a_dask_cluster_comes_to_the_same(
    tmp_path: Path, told: tuple[Story, dict[str, Sequence[Measurement]]]
) -> None:
    distributed = pytest.importorskip("distributed")
    story, measured = told
    runs = [record(tmp_path / "runs" / name, story, measured) for name in "ab"]
    (tmp_path / "bad.npz").write_bytes(b"nothing")
    logs, counts = [*runs, tmp_path / "bad.npz"], []
    options = {"n_workers": 1, "threads_per_worker": 1, "processes": False, "dashboard_address": None}
    with distributed.LocalCluster(**options) as cluster:
        there = estimate_all(logs, Request(), scheduler=cluster.scheduler_address, told=counts.append)
    assert there == estimate_all(logs, Request(), workers=1)
    assert counts == [1, 2, 3]
    assert "bad.npz" in there[2]["error"]


def test_a_bad_log_costs_itself_only(
    tmp_path: Path, told: tuple[Story, dict[str, Sequence[Measurement]]], capsys: pytest.CaptureFixture[str]
) -> None:
    story, measured = told
    run = record(tmp_path / "run", story, measured)
    (tmp_path / "bad.npz").write_bytes(b"nothing")
    assert main([str(run), str(tmp_path / "bad.npz"), "--workers", "1"]) == 2
    told_of = capsys.readouterr()
    assert "mass" in told_of.out
    assert told_of.err.count("\n") == 1
    assert "bad.npz" in told_of.err
    assert main([str(tmp_path / "nowhere")]) == 2
    assert main([str(run), "--reference", "no-such-reference"]) == 2
