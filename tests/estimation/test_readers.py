"""Logs of every format give the recording they were made from, and what is wrong with them is said."""

import math
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from dynamics.arm import Arm
from dynamics.errors import InvalidInput, UnknownName
from dynamics.signals import Sample
from estimation.readers import LogMap, formats, read_log
from estimation.recording import RunWriter, Samples

JOINTS = tuple(f"joint_{n}" for n in range(1, 8))
SPAN = 0.81  # rad of the knuckle joint when closed

BASE_FEEDBACK = {  # the fields that matter, of the message the ROS 1 driver publishes
    "kortex_driver/msg/BaseCyclic_Feedback": (
        "uint32 frame_id\nActuatorFeedback[] actuators\nInterconnectCyclic_Feedback interconnect"
    ),
    "kortex_driver/msg/ActuatorFeedback": "uint32 command_id\nfloat32 position\nfloat32 velocity\nfloat32 torque",
    "kortex_driver/msg/InterconnectCyclic_Feedback": (
        "InterconnectCyclic_Feedback_tool_feedback oneof_tool_feedback"
    ),
    "kortex_driver/msg/InterconnectCyclic_Feedback_tool_feedback": "GripperCyclic_Feedback[] gripper_feedback",
    "kortex_driver/msg/GripperCyclic_Feedback": "MotorFeedback[] motor",
    "kortex_driver/msg/MotorFeedback": (
        "uint32 motor_id\nfloat32 position\nfloat32 velocity\nfloat32 current_motor"
    ),
}


@pytest.fixture(scope="module")
def arm() -> Arm:
    return Arm.gen3()


@pytest.fixture(scope="module")
def truth(arm: Arm) -> Samples:
    """Return a slow motion of the arm, with the torques that hold it."""
    time = np.arange(200) / 100
    phase = 0.4 * time[:, None] + np.arange(7)
    q = 0.6 * np.sin(phase)
    tau = np.array([arm.gravity(row) for row in q])
    return Samples(time, q, 0.24 * np.cos(phase), tau, 0.085 - 0.02 * time, 0.1 + 0.2 * time)


def same(found: Samples, truth: Samples, atol: float = 1e-9, gripper: str = "both") -> None:
    for name in ("time", "q", "dq", "tau"):
        np.testing.assert_allclose(getattr(found, name), getattr(truth, name), rtol=0, atol=atol, err_msg=name)
    if gripper != "none":
        np.testing.assert_allclose(found.opening, truth.opening, rtol=0, atol=atol)
    if gripper == "both":
        np.testing.assert_allclose(found.effort, truth.effort, rtol=0, atol=atol)
    else:
        assert np.isnan(found.effort).all()


def write_npz(path: Path, truth: Samples, **changes: Any) -> Path:
    names = ("time", "q", "dq", "tau", "opening", "effort")
    np.savez(path, **{**{name: getattr(truth, name) for name in names}, **changes})
    return path


def write_ros2(
    path: Path, truth: Samples, sign: int, storage: str, order: tuple[int, ...] = tuple(range(7))
) -> Path:
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    types = get_typestore(Stores.ROS2_HUMBLE)
    state, header, stamp = (
        types.types[name]
        for name in ("sensor_msgs/msg/JointState", "std_msgs/msg/Header", "builtin_interfaces/msg/Time")
    )
    plugin = StoragePlugin.MCAP if storage == "mcap" else StoragePlugin.SQLITE3
    with Writer(path, version=9, storage_plugin=plugin) as writer:
        other = writer.add_connection("/chatter", "std_msgs/msg/String", typestore=types)
        topic = writer.add_connection("/joint_states", state.__msgtype__, typestore=types)
        text = types.types["std_msgs/msg/String"](data="hello")
        names = [*(JOINTS[n] for n in order), "robotiq_85_left_knuckle_joint"]
        for one in truth.as_tuple():
            at = round(one.time * 1e9) + 1_700_000_000_000_000_000
            knuckle = (1 - one.opening / 0.085) * SPAN
            message = state(
                header(stamp(at // 10**9, at % 10**9), ""),
                names,
                np.array([*one.q[list(order)], knuckle]),
                np.array([*one.dq[list(order)], 0.0]),
                np.array([*(sign * one.tau[list(order)]), 0.0]),
            )
            writer.write(topic, at, types.serialize_cdr(message, state.__msgtype__))
            writer.write(other, at, types.serialize_cdr(text, "std_msgs/msg/String"))
    return path


def write_ros1(path: Path, truth: Samples) -> Path:
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    types = get_typestore(Stores.ROS1_NOETIC)
    for name, text in BASE_FEEDBACK.items():
        types.register(get_types_from_msg(text, name))
    known = {name.rsplit("/", 1)[1]: types.types[name] for name in BASE_FEEDBACK}
    state = types.types["sensor_msgs/msg/JointState"]
    header, stamp = types.types["std_msgs/msg/Header"], types.types["builtin_interfaces/msg/Time"]
    with Writer(path) as writer:
        feedback = writer.add_connection(
            "/arm/base_feedback", "kortex_driver/msg/BaseCyclic_Feedback", typestore=types
        )
        joints = writer.add_connection("/arm/joint_states", "sensor_msgs/msg/JointState", typestore=types)
        for n, one in enumerate(truth.as_tuple()):
            at = round(one.time * 1e9) + 1_600_000_000_000_000_000
            degrees = np.degrees(one.q) % 360
            actuators = [
                known["ActuatorFeedback"](0, *row)
                for row in zip(degrees, np.degrees(one.dq), -one.tau, strict=True)
            ]
            motor = known["MotorFeedback"](0, 100 * (1 - one.opening / 0.085), 0.0, one.effort)
            tool = known["InterconnectCyclic_Feedback_tool_feedback"]([known["GripperCyclic_Feedback"]([motor])])
            connect = known["InterconnectCyclic_Feedback"](tool)
            message = known["BaseCyclic_Feedback"](n, actuators, connect)
            writer.write(feedback, at, types.serialize_ros1(message, "kortex_driver/msg/BaseCyclic_Feedback"))
            both = state(
                header(n, stamp(at // 10**9, at % 10**9), ""),
                [*JOINTS, "finger_joint"],
                np.array([*one.q, (1 - one.opening / 0.085) * 0.8]),
                np.zeros(8),
                np.array([*-one.tau, 0.0]),
            )
            writer.write(joints, at, types.serialize_ros1(both, "sensor_msgs/msg/JointState"))
    return path


def test_a_run_is_a_log(tmp_path: Path, truth: Samples, arm: Arm) -> None:
    with RunWriter.create(tmp_path / "run", {}, "cube", arm.joint_names) as run:
        for one in truth.as_tuple():
            run.sample(one)
    same(read_log(tmp_path / "run", arm=arm).samples, truth)
    same(read_log(tmp_path / "run" / "run.mcap").samples, truth)


def test_npz(tmp_path: Path, truth: Samples, arm: Arm) -> None:
    recording = read_log(write_npz(tmp_path / "log.npz", truth), arm=arm)
    same(recording.samples, truth)
    assert recording.rejections.count == 0


def test_npz_with_labels_as_bytes_and_labels_that_are_no_text(tmp_path: Path, truth: Samples, arm: Arm) -> None:
    labels = np.array(["weigh/tare"] * 150 + [""] * 50)
    path = tmp_path / "log.npz"
    np.savez(path, time=truth.time, q=truth.q, phase=labels.astype("S"))
    (mark,) = read_log(path, arm=arm).marks
    assert (mark.action, mark.name, mark.stop) == ("weigh", "tare", 150)
    np.savez(path, time=truth.time, q=truth.q, phase=np.full((200, 3), 0x7FFFFFFF, np.uint32).view("U3")[:, 0])
    with pytest.raises(InvalidInput, match="no text"):
        read_log(path, arm=arm)


def test_npz_whose_header_breaks_off(tmp_path: Path, truth: Samples) -> None:
    path = tmp_path / "log.npz"
    np.savez(path, time=truth.time, q=truth.q)
    with zipfile.ZipFile(path) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in members.items():
            archive.writestr(name, content.replace(b"), }", b"(, }"))
    with pytest.raises(InvalidInput, match="NPZ file of numbers"):
        read_log(path)


def test_npz_with_a_map_of_columns_and_units(tmp_path: Path, truth: Samples, arm: Arm) -> None:
    arrays = {f"axis{n}": np.degrees(truth.q[:, n]) for n in range(7)}
    arrays |= {f"load_{n + 1}": -1e3 * truth.tau[:, n] for n in range(7)}
    labels = np.array(["weigh/tare"] * 80 + [""] * 20 + ["weigh/hold"] * 60 + ["weigh/tare"] * 40)
    path = tmp_path / "log.npz"
    np.savez(path, ms=truth.time * 1e3, gap=100 * (1 - truth.opening / 0.085), label=labels, **arrays)
    (tmp_path / "map.toml").write_text(
        '[columns]\ntime = "ms"\nq = ["axis0", "axis1", "axis2", "axis3", "axis4", "axis5", "axis6"]\n'
        'tau = "load"\nopening = "gap"\nphase = "label"\n'
        '[units]\ntime = "ms"\nq = "deg"\ntau = "N mm"\nopening = "% closed"\n[options]\ntorque_sign = "auto"\n'
    )
    recording = read_log(path, LogMap.from_file(tmp_path / "map.toml"), arm)
    derived = Samples(truth.time, truth.q, recording.samples.dq, truth.tau, truth.opening, truth.effort)
    same(recording.samples, derived, gripper="opening")
    np.testing.assert_allclose(recording.samples.dq[1:-1], truth.dq[1:-1], atol=1e-4)
    marks = [(m.action, m.name, m.index, m.start, m.stop) for m in recording.marks]
    assert marks == [("weigh", "tare", 0, 0, 80), ("weigh", "hold", 0, 100, 160), ("weigh", "tare", 1, 160, 200)]
    assert any("derived" in note for note in recording.notes)


def test_parquet(tmp_path: Path, truth: Samples, arm: Arm) -> None:
    pa = pytest.importorskip("pyarrow")
    import pyarrow.parquet as pq

    columns = {"time": truth.time, "opening": truth.opening, "effort": truth.effort}
    columns |= {f"q{n + 1}": truth.q[:, n] for n in range(7)} | {f"tau{n + 1}": truth.tau[:, n] for n in range(7)}
    columns["dq"] = pa.array(truth.dq.tolist())
    pq.write_table(pa.table({**columns, "comment": ["x"] * 200}), tmp_path / "log.parquet", row_group_size=64)
    same(read_log(tmp_path / "log.parquet", arm=arm).samples, truth)


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_a_bag_of_the_ros_2_driver(tmp_path: Path, truth: Samples, arm: Arm, storage: str) -> None:
    bag = write_ros2(tmp_path / "bag", truth, sign=-1, storage=storage, order=(1, 0, 2, 3, 4, 6, 5))
    recording = read_log(bag, arm=arm)
    same(recording.samples, truth, gripper="opening")
    assert recording.joint_names == JOINTS
    assert any("reversed" in note for note in recording.notes)
    single = next(bag.glob("*.mcap" if storage == "mcap" else "*.db3"))
    same(read_log(single, arm=arm).samples, truth, gripper="opening")
    (bag / "metadata.yaml").unlink()  # killed while recording
    same(read_log(bag, arm=arm).samples, truth, gripper="opening")


def test_a_cut_off_ros_2_mcap(tmp_path: Path, truth: Samples, arm: Arm) -> None:
    bag = write_ros2(tmp_path / "bag", truth, sign=-1, storage="mcap")
    file = next(bag.glob("*.mcap"))
    whole = file.read_bytes()
    file.write_bytes(whole[: len(whole) - 200])
    recording = read_log(file, arm=arm)
    assert 0 < len(recording.samples) <= len(truth)
    same(recording.samples, truth[: len(recording.samples)], gripper="opening")


def test_a_bag_of_the_ros_1_driver(tmp_path: Path, truth: Samples, arm: Arm) -> None:
    """Its floats have 32 bits, and its messages no stamp."""
    bag = write_ros1(tmp_path / "log.bag", truth)
    same(read_log(bag, arm=arm).samples, truth, atol=2e-5)
    states = read_log(bag, LogMap(topic="/arm/joint_states"), arm)
    np.testing.assert_allclose(states.samples.tau, truth.tau, atol=1e-12)
    np.testing.assert_allclose(states.samples.opening, truth.opening, atol=1e-12)
    with pytest.raises(UnknownName, match="/arm/base_feedback"):
        read_log(bag, LogMap(topic="/other"))


def test_a_sign_that_contradicts_gravity_is_refused_and_the_option_named(
    tmp_path: Path, truth: Samples, arm: Arm
) -> None:
    raw = write_npz(tmp_path / "raw.npz", truth, tau=-truth.tau)
    with pytest.raises(InvalidInput, match="torque_sign = -1"):
        read_log(raw, arm=arm)
    same(read_log(raw, LogMap(torque_sign=-1), arm).samples, truth)
    same(read_log(raw, LogMap(torque_sign="auto"), arm).samples, truth)
    with pytest.raises(InvalidInput, match="no arm"):
        read_log(raw, LogMap(torque_sign="auto"))
    driver = write_ros2(tmp_path / "bag", truth, sign=1, storage="sqlite3")  # a driver that was repaired
    with pytest.raises(InvalidInput, match="torque_sign = 1"):
        read_log(driver, arm=arm)
    same(read_log(driver, LogMap(torque_sign=1), arm).samples, truth, gripper="opening")


def test_degrees_given_as_radians_are_refused(tmp_path: Path, truth: Samples) -> None:
    far = write_npz(tmp_path / "far.npz", truth, q=np.degrees(truth.q))
    with pytest.raises(InvalidInput, match='q = "deg"'):
        read_log(far)
    near = write_npz(tmp_path / "near.npz", truth, q=np.degrees(truth.q) * 0.2, dq=truth.dq * 0.2)
    with pytest.raises(InvalidInput, match="one unit of angle"):
        read_log(near)
    np.testing.assert_allclose(read_log(far, LogMap(units={"q": "deg"})).samples.q, truth.q)


def test_damaged_rows_are_counted_and_named(tmp_path: Path, truth: Samples) -> None:
    q, tau, time = truth.q.copy(), truth.tau.copy(), truth.time.copy()
    q[3, 2], tau[7, 0], time[50], time[90] = np.nan, 1e200, 1e6, 0.2
    recording = read_log(write_npz(tmp_path / "log.npz", truth, q=q, tau=tau, time=time))
    assert recording.rejections.count == 4
    assert len(recording.samples) == 196
    reasons = recording.rejections.reasons
    assert [reason.split(":")[0] for reason in reasons] == ["row 4", "row 8", "row 51", "row 91"]
    assert "q is nan" in reasons[0]
    assert "1e+200" in reasons[1]
    assert np.all(np.diff(recording.samples.time) > 0)


def test_joints_that_do_not_fit_the_arm_are_named(tmp_path: Path, truth: Samples, arm: Arm) -> None:
    six = {name: getattr(truth, name)[:, :6] for name in ("q", "dq", "tau")}
    with pytest.raises(InvalidInput, match="option joints"):
        read_log(write_npz(tmp_path / "six.npz", truth, **six), arm=arm)
    whole = write_npz(tmp_path / "log.npz", truth)
    with pytest.raises(InvalidInput, match="joints"):
        read_log(write_npz(tmp_path / "odd.npz", truth, tau=truth.tau[:, :3]))
    few = read_log(whole, LogMap(joints=JOINTS))
    assert few.joint_names == JOINTS


def test_what_is_no_log_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="existing"):
        read_log(tmp_path / "nothing.npz")
    (tmp_path / "log.xyz").write_text("")
    with pytest.raises(InvalidInput, match=r"\.npz"):
        read_log(tmp_path / "log.xyz")
    (tmp_path / "folder").mkdir()
    with pytest.raises(InvalidInput):
        read_log(tmp_path / "folder")
    for ending in formats():
        for content in (b"", b"PK\x03\x04", b"#ROSBAG V2.0\n", b"SQLite format 3\x00", bytes(range(256))):
            path = tmp_path / f"bad{ending}"
            path.write_bytes(content)
            with pytest.raises(InvalidInput):
                read_log(path)


def test_arrays_that_declare_more_than_there_is_take_no_memory(tmp_path: Path) -> None:
    import io
    import zipfile

    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(header, {"descr": "<f8", "fortran_order": False, "shape": (10**12,)})
    with zipfile.ZipFile(tmp_path / "log.npz", "w") as archive:
        archive.writestr("time.npy", header.getvalue())
    with pytest.raises(InvalidInput, match="declared"):
        read_log(tmp_path / "log.npz")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[column]\n", "columns, units, options"),
        ("[columns]\nangle = 'q'\n", "time, q, dq"),
        ("[columns]\nq = 3.5\n", "a column"),
        ("[columns]\ntime = ['a', 'b']\n", "a column"),
        ("[units]\nq = 'kg'\n", "converted to rad"),
        ("[units]\ntau = 'furlong parsec'\n", "N m"),
        ("[options]\ntorque_sign = 2\n", "auto"),
        ("[options]\nmax_opening = -1\n", "> 0"),
        ("[options]\njoints = 'joint_1'\n", "list of joint names"),
        ("time = \n", "TOML"),
    ],
)
def test_a_map_that_can_not_be_meant_is_refused(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "map.toml").write_text(text)
    with pytest.raises(InvalidInput, match=message):
        LogMap.from_file(tmp_path / "map.toml")


def test_a_missing_column_is_named(tmp_path: Path, truth: Samples) -> None:
    path = write_npz(tmp_path / "log.npz", truth)
    with pytest.raises(UnknownName, match="effort"):
        read_log(path, LogMap(columns={"tau": "torque"}))
    np.savez(tmp_path / "no_q.npz", time=truth.time)
    with pytest.raises(InvalidInput, match="column map"):
        read_log(tmp_path / "no_q.npz")


def test_angles_of_kortex_come_wrapped() -> None:
    from types import SimpleNamespace as Bag

    from estimation.readers.kortex import base_feedback_row

    actuator = Bag(position=350.0, velocity=180.0, torque=2.0)
    message = Bag(actuators=[actuator], interconnect=Bag(oneof_tool_feedback=Bag(gripper_feedback=[])))
    row = base_feedback_row(message, 0.085)
    assert row[:3] == pytest.approx([math.radians(-10), math.pi, 2.0])
    assert all(map(math.isnan, row[3:]))


def test_samples_are_what_the_robot_gave(truth: Samples) -> None:
    one = truth.as_tuple()[3]
    assert isinstance(one, Sample)
    assert np.array_equal(one.tau, truth.tau[3])


def write_csv(path: Path, truth: Samples, delimiter: str = ",", header: bool = True) -> Path:
    names = ["time", *(f"{s}{n}" for s in ("q", "dq", "tau") for n in range(1, 8)), "opening", "effort", "phase"]
    lines = [delimiter.join(names)] if header else []
    for n, one in enumerate(truth.as_tuple()):
        numbers = [one.time, *one.q, *one.dq, *one.tau, one.opening, one.effort]
        cells = [repr(float(x)) for x in numbers] + (["weigh/tare" if n < 90 else "weigh/hold"] if header else [])
        lines.append(delimiter.join(cells))
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
def test_csv_with_names(tmp_path: Path, truth: Samples, arm: Arm, delimiter: str) -> None:
    recording = read_log(write_csv(tmp_path / "log.csv", truth, delimiter), arm=arm)
    same(recording.samples, truth, atol=0)
    assert [(m.name, m.start, m.stop) for m in recording.marks] == [("tare", 0, 90), ("hold", 90, 200)]


def test_csv_without_names(tmp_path: Path, truth: Samples, arm: Arm) -> None:
    path = write_csv(tmp_path / "log.csv", truth, header=False)
    columns: dict[str, str | tuple[str, ...]] = {"time": "0", "opening": "22", "effort": "23"}
    for place, signal in enumerate(("q", "dq", "tau")):
        columns[signal] = tuple(str(1 + 7 * place + n) for n in range(7))
    same(read_log(path, LogMap(columns=columns), arm).samples, truth, atol=0)


def test_corrupt_lines_of_csv_are_told_by_number(tmp_path: Path, truth: Samples) -> None:
    path = write_csv(tmp_path / "log.csv", truth)
    lines = path.read_text().splitlines()
    lines[9] = lines[9].replace(lines[9].split(",")[3], "1e200", 1)
    lines[19] = lines[19][:40]
    lines[29] = lines[29].replace(lines[29].split(",")[2], "abc", 1)
    lines[39] = ""
    lines.insert(50, "# a remark")
    path.write_text("\n".join(lines))
    recording = read_log(path)
    assert recording.rejections.count == 3
    assert sorted(reason.split(":")[0] for reason in recording.rejections.reasons) == [
        "line 10",
        "line 20",
        "line 30",
    ]
    assert len(recording.samples) == 196


def test_a_table_without_numbers_is_refused(tmp_path: Path) -> None:
    for text in ("", "\n\n", "time,q\n", "a,b\n1,2\n", "\0\0\0", "time,q1\nx,y\n"):
        (tmp_path / "log.csv").write_text(text)
        with pytest.raises(InvalidInput):
            read_log(tmp_path / "log.csv")
