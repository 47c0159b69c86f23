"""ROS 1 and ROS 2 bags, through the library rosbags, without ROS."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from dynamics.arm import Arm
from dynamics.errors import InvalidInput, PalpateError, UnknownName
from estimation.readers.kortex import BASE_FEEDBACK, base_feedback_row
from estimation.readers.mapping import LogMap
from estimation.readers.mcap import read_mcap
from estimation.readers.rows import Rows
from estimation.readers.signals import to_recording
from estimation.recording.cdr import SCHEMA_NAME, JointState
from estimation.recording.data import Recording


def read_rosbag(path: Path, mapping: LogMap, arm: Arm | None = None) -> Recording:
    """Return the recording of a bag: a ``.bag`` or ``.db3`` file, or the folder of a ROS 2 bag.

    Taken is the base feedback of a Kortex arm, which knows the gripper's current, else the joint states.

    Raises:
        InvalidInput: if it is no bag, or holds no joint states.
    """
    stray = _files_without_metadata(path)
    if stray and stray[0].suffix == ".mcap":
        return read_mcap(stray[0], mapping, arm)
    rows = Rows(path, mapping)
    notes = ["the bag was never closed; its first file was read alone"] if stray else []
    try:
        _read(stray[0] if stray else path, rows, mapping)
    except PalpateError:
        raise
    except MemoryError:
        raise InvalidInput(f"{path}", "declared sizes beyond the memory", "a bag that is not damaged") from None
    except Exception as error:  # the library raises whatever a damaged file provokes
        if not rows.names:
            raise InvalidInput(f"{path}", f"{type(error).__name__}: {error}", "a ROS 1 or ROS 2 bag") from None
        notes.append(f"cut off or damaged: {error}; everything before it was kept")
    return to_recording(path, rows.signals(notes), mapping, arm)


def _read(path: Path, rows: Rows, mapping: LogMap) -> None:
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    types = get_typestore(Stores.ROS1_NOETIC if path.suffix == ".bag" else Stores.ROS2_HUMBLE)
    with AnyReader([path], default_typestore=types) as reader:
        connections = _choose(path, reader.connections, mapping.topic)
        for connection, logged, data in reader.messages(connections=connections):
            try:
                message: Any = reader.deserialize(data, connection.msgtype)
                if connection.msgtype == BASE_FEEDBACK:
                    rows.add_feedback(logged, base_feedback_row(message, mapping.max_opening))
                else:
                    rows.add_joint_state(_joint_state(message), logged)
            except PalpateError:
                raise
            except Exception as error:  # one damaged message must not cost the others
                rows.skip(f"{type(error).__name__}: {error}")


def _choose(path: Path, connections: Iterable[Any], topic: str) -> list[Any]:
    """Return the connections of one topic: the one asked for, or the most telling one."""
    usable = [c for c in connections if c.msgtype in (BASE_FEEDBACK, SCHEMA_NAME)]
    topics = sorted({c.topic for c in usable})
    if topic and topic not in topics:
        raise UnknownName(f"{path}: topic", topic, topics)
    if not usable:
        raise InvalidInput(f"{path}", "no joint states", f"a topic of type {SCHEMA_NAME} or {BASE_FEEDBACK}")
    best = topic or max(usable, key=lambda c: (c.msgtype == BASE_FEEDBACK, c.msgcount)).topic
    return [c for c in usable if c.topic == best]


def _joint_state(message: Any) -> JointState:
    stamp = message.header.stamp
    nanoseconds = int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)
    return JointState(nanoseconds, tuple(message.name), message.position, message.velocity, message.effort)


def _files_without_metadata(path: Path) -> list[Path]:
    if not path.is_dir() or (path / "metadata.yaml").is_file():
        return []
    return sorted([*path.glob("*.mcap"), *path.glob("*.db3")])
