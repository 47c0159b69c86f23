"""Runs on disk: what was written is read back, whole or cut off, and what can not be kept is refused."""

import json
import os
import shutil
import tempfile
import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dynamics.errors import InvalidInput, PalpateError
from dynamics.signals import Sample
from estimation.measurement import Measurement
from estimation.recording import CannotRecord, RunWriter, read_recording
from estimation.recording.files import to_toml, write_atomically

MASS = Measurement("mass", 0.123456789012345, 0.001, "kg")
WIDTH = Measurement("width", 0.05, 0.0002, "m")


def sample(k: int, nv: int = 7) -> Sample:
    """Return the k-th of a series whose every number is another one."""
    number = np.random.default_rng(k).normal(size=3 * nv + 2)
    q, dq, tau = number[:nv], number[nv : 2 * nv], number[2 * nv : 3 * nv]
    return Sample(k / 1000, q, dq, tau, float(number[-2]), float(number[-1]))


def write_run(directory: Path, count: int = 60, finish: bool = True) -> list[Sample]:
    samples = [sample(k) for k in range(count)]
    with RunWriter.create(directory, {"seed": 3, "robot": {"name": "sim", "noise": None}}, "cube") as run:
        for k, one in enumerate(samples):
            if k == 10:
                run.decision(one.time, {"action": "weigh", "scores": {"weigh": np.float64(1.5)}})
                run.phase("weigh", "tare", 0, one.time)
            if k == 30:
                run.phase("weigh", "hold", 1, one.time)
            if k == 50:
                run.end_phase(one.time)
                run.measurement(one.time, "weigh", MASS)
                run.measurement(one.time, "weigh", WIDTH)
                run.belief(one.time, {"material": {"wood": np.array([0.25, 0.75])}})
            run.sample(one)
        if finish:
            run.finish({"object": "cube", "seconds": np.float64(0.06)})
    return samples


def equal(a: Sample, b: Sample) -> bool:
    arrays = all(np.array_equal(getattr(a, name), getattr(b, name)) for name in ("q", "dq", "tau"))
    return arrays and (a.time, a.opening, a.effort) == (b.time, b.opening, b.effort)


def test_a_run_is_read_back(tmp_path: Path) -> None:
    written = write_run(tmp_path / "run")
    recording = read_recording(tmp_path / "run")
    assert recording.complete
    assert not recording.notes
    assert all(map(equal, written, recording.samples.as_tuple()))
    assert len(recording.samples) == len(written)
    phases = recording.phases
    assert [(p.action, p.name, p.index, len(p.samples)) for p in phases] == [
        ("weigh", "tare", 0, 20),
        ("weigh", "hold", 1, 20),
    ]
    assert all(map(equal, phases[1].samples, written[30:50]))
    assert recording.decisions[0].data == {"action": "weigh", "scores": {"weigh": 1.5}}
    assert recording.decisions[0].time == pytest.approx(0.010, abs=1e-9)
    assert [(m.action, m.measurement) for m in recording.measurements] == [("weigh", MASS), ("weigh", WIDTH)]
    assert recording.beliefs[0].data == {"material": {"wood": [0.25, 0.75]}}
    assert recording.config == {"seed": 3, "robot": {"name": "sim", "noise": None}}
    assert recording.object_name == "cube"


def test_the_directory_holds_what_people_read(tmp_path: Path) -> None:
    write_run(tmp_path)
    assert tomllib.loads((tmp_path / "config.toml").read_text()) == {"seed": 3, "robot": {"name": "sim"}}
    assert json.loads((tmp_path / "result.json").read_text()) == {"object": "cube", "seconds": 0.06}
    listed = json.loads((tmp_path / "measurements" / "002-width.json").read_text())
    value = {"sigma": 0.0002, "mean": 0.05, "units": "m"}
    assert listed == [{"object_name": "cube", "measurements": [{"name": "width", "value": value}]}]
    assert not list(tmp_path.rglob("*.tmp"))


def test_equal_results_give_equal_bytes(tmp_path: Path) -> None:
    write_run(tmp_path / "a")
    write_run(tmp_path / "b")
    for name in ("result.json", "config.toml", "measurements/001-mass.json"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


def test_the_library_of_the_format_reads_it(tmp_path: Path) -> None:
    from mcap.reader import make_reader
    from rosbags.typesys import Stores, get_typestore

    written = write_run(tmp_path)
    types = get_typestore(Stores.ROS2_HUMBLE)
    with open(tmp_path / "run.mcap", "rb") as file:
        messages = [(channel, schema, m) for schema, channel, m in make_reader(file).iter_messages()]
    joints = [
        types.deserialize_cdr(m.data, schema.name)
        for channel, schema, m in messages
        if channel.topic == "/joint_states"
    ]
    grips = [
        types.deserialize_cdr(m.data, schema.name)
        for channel, schema, m in messages
        if channel.topic == "/gripper"
    ]
    assert joints[7].name == [f"joint_{n}" for n in range(1, 8)]
    for one, joint, grip in zip(written, joints, grips, strict=True):
        assert np.array_equal(joint.position, one.q)
        assert np.array_equal(joint.velocity, one.dq)
        assert np.array_equal(joint.effort, one.tau)
        assert (grip.position[0], grip.effort[0]) == (one.opening, one.effort)
        assert joint.header.stamp.sec + joint.header.stamp.nanosec / 1e9 == pytest.approx(one.time, abs=1e-9)
    assert {schema.encoding for channel, schema, _ in messages if channel.message_encoding == "json"} == {
        "jsonschema"
    }


def test_every_prefix_of_the_stream_is_readable(tmp_path: Path) -> None:
    written = write_run(tmp_path, count=40)
    whole = (tmp_path / "run.mcap").read_bytes()
    cut = tmp_path / "cut.mcap"
    counts = []
    for length in range(8, len(whole), 7):
        cut.write_bytes(whole[:length])
        recording = read_recording(cut)
        counts.append(len(recording.samples))
        assert all(map(equal, recording.samples.as_tuple(), written))
        assert recording.complete == (not recording.notes)
    assert counts == sorted(counts)
    assert counts[-1] == 40


def test_damage_within_the_stream_costs_only_what_follows(tmp_path: Path) -> None:
    write_run(tmp_path, count=200)
    whole = bytearray((tmp_path / "run.mcap").read_bytes())
    whole[len(whole) // 2] ^= 0x40
    (tmp_path / "run.mcap").write_bytes(whole)
    recording = read_recording(tmp_path)
    if not recording.complete:  # else the damage hit the index, which is not read
        assert "damaged" in recording.notes[0]
    assert all(equal(a, sample(k)) for k, a in enumerate(recording.samples.as_tuple()))


def copy_of_a_running_run(folder: Path) -> Path:
    """Return what a kill would leave of a run after its second measurement."""
    with RunWriter.create(folder / "running", {"seed": 3}, "cube") as run:
        for k in range(50):
            run.sample(sample(k))
        run.measurement(0.049, "weigh", MASS)
        run.measurement(0.049, "weigh", WIDTH)
        shutil.copytree(folder / "running", folder / "killed")
    return folder / "killed"


def test_a_run_is_resumed_with_everything_it_knew(tmp_path: Path) -> None:
    killed = copy_of_a_running_run(tmp_path)
    (killed / "measurements" / "002-width.json").unlink()  # killed between stream and file
    with RunWriter.resume(killed) as run:
        assert (killed / "measurements" / "002-width.json").exists()
        run.phase("squeeze", "compress", 0, 0.0)
        run.sample(sample(0))
        run.measurement(0.0, "squeeze", Measurement("elasticity", 5e4, 1e3, "Pa"))
        run.finish({})
    recording = read_recording(killed)
    assert [m.measurement.property for m in recording.measurements] == ["mass", "width", "elasticity"]
    assert (killed / "measurements" / "003-elasticity.json").exists()
    assert np.all(np.diff(recording.samples.time) > 0)
    assert recording.phases[-1].action == "squeeze"
    assert recording.phases[-1].samples[0].time == 0.0  # the robot's own
    assert len(recording.phases[-1].samples) == 1
    assert not recording.complete  # its first part was cut off
    with pytest.raises(InvalidInput, match="has not ended"):
        RunWriter.resume(killed)


def test_a_run_that_can_not_be_continued_is_left_as_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    killed = copy_of_a_running_run(tmp_path)
    before = sorted(path.name for path in killed.iterdir())

    def fail(descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", fail)
    with pytest.raises(CannotRecord, match="No space left"):
        RunWriter.resume(killed)
    assert sorted(path.name for path in killed.iterdir()) == before


def test_what_is_not_empty_is_not_written_to(tmp_path: Path) -> None:
    (tmp_path / "letter.txt").write_text("dear")
    with pytest.raises(InvalidInput, match="letter"):
        RunWriter.create(tmp_path, {}, "cube")
    assert [item.name for item in tmp_path.iterdir()] == ["letter.txt"]


def test_a_place_that_is_no_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(CannotRecord, match="no run can be kept"):
        RunWriter.create(tmp_path / "file" / "run", {}, "cube")


def test_a_read_only_folder_is_refused() -> None:
    with tempfile.TemporaryDirectory() as folder:
        Path(folder).chmod(0o555)
        user = os.geteuid()
        if user == 0:  # nothing is read-only for the superuser
            os.seteuid(65534)
        try:
            with pytest.raises(CannotRecord, match="Permission denied"):
                RunWriter.create(Path(folder) / "run", {}, "cube")
            with pytest.raises(CannotRecord, match="Permission denied"):
                RunWriter.create(Path(folder), {}, "cube")
        finally:
            os.seteuid(user)
            Path(folder).chmod(0o755)


def test_a_read_only_file_system_is_refused() -> None:
    for folder in (Path("/proc/palpate"), Path("/sys/palpate")):
        if folder.parent.is_dir():
            with pytest.raises(CannotRecord):
                RunWriter.create(folder, {}, "cube")


def test_a_disk_that_is_nearly_full_is_refused(tmp_path: Path) -> None:
    with pytest.raises(CannotRecord, match="the disk is full"):
        RunWriter.create(tmp_path / "new" / "run", {}, "cube", space=2**62)
    assert not (tmp_path / "new").exists()


def move_until_told_to_stop(run: RunWriter) -> None:
    for k in range(1000):
        run.sample(sample(k))
        if k % 100 == 99:
            run.decision(k / 1000, {"k": k})


def test_a_disk_that_fills_stops_the_run(tmp_path: Path) -> None:
    """A limit on the size of files stands for the full disk: the write fails halfway in the same way."""
    import resource
    import signal

    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    run = RunWriter.create(tmp_path, {}, "cube")
    try:
        run.measurement(0.0, "weigh", MASS)
        resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, limits[1]))
        with pytest.raises(CannotRecord, match=r"run\.mcap: recording failed: File too large"):
            move_until_told_to_stop(run)
        with pytest.raises(CannotRecord):
            run.sample(sample(0))
        with pytest.raises(CannotRecord):
            run.close()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        signal.signal(signal.SIGXFSZ, handler)
    recording = read_recording(tmp_path)
    assert recording.measurements[0].measurement == MASS
    assert all(equal(a, sample(k)) for k, a in enumerate(recording.samples.as_tuple()))


def test_an_atomic_file_is_the_old_one_or_the_new_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "result.json"
    write_atomically(path, "old")

    def fail(descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", fail)
    with pytest.raises(CannotRecord, match="No space left"):
        write_atomically(path, "new")
    assert path.read_text() == "old"
    assert [item.name for item in tmp_path.iterdir()] == ["result.json"]


@pytest.mark.parametrize("bad", [{"p": float("nan")}, {"p": object()}, {1: 2}])
def test_what_json_can_not_say_is_refused(tmp_path: Path, bad: dict[str, object]) -> None:
    with RunWriter.create(tmp_path, {}, "cube") as run:
        with pytest.raises(InvalidInput):
            run.decision(0.0, bad)
        run.decision(0.0, {"good": 1})
    assert [entry.data for entry in read_recording(tmp_path).decisions] == [{"good": 1}]


def test_samples_of_another_arm_are_refused(tmp_path: Path) -> None:
    run = RunWriter.create(tmp_path, {}, "cube", joint_names=["a", "b"])
    run.sample(sample(0, nv=3))
    with pytest.raises(PalpateError, match="3 names"):
        run.decision(0.0, {})
    with pytest.raises(PalpateError):
        run.close()


def test_a_folder_without_a_run_is_named(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match=r"no run\.mcap"):
        read_recording(tmp_path)
    (tmp_path / "run.mcap").write_bytes(b"something else")
    with pytest.raises(InvalidInput, match="an MCAP file"):
        read_recording(tmp_path)


_SCALARS = st.one_of(st.booleans(), st.integers(-(2**63), 2**63 - 1), st.floats(allow_nan=False), st.text())
_VALUES = st.recursive(
    _SCALARS,
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(st.text(), inner, max_size=3)),
    max_leaves=8,
)


@given(st.dictionaries(st.text(), _VALUES, max_size=4))
def test_toml_round_trip(config: dict[str, object]) -> None:
    assert tomllib.loads(to_toml("config", config)) == config
