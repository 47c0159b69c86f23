"""Damaged files for every reader: each may be read or refused, but nothing else may happen.

``python -m benchmarks.fuzz --seconds 60 --json`` prints, for every reader, how many mutated files it was given,
how many it read and refused, the slowest one [s], the peak of memory [MB], and what else happened: other errors,
crashes of the process, hangs of more than 5 s, memory beyond 1.5 GB. All but files, read and refused must be 0.
"""

import argparse
import io
import json
import random
import resource
import signal
import subprocess
import sys
import tempfile
import time
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from dynamics.errors import PalpateError
from dynamics.signals import Sample
from estimation.measurement import Measurement

READERS = (
    *("run", "ros2-mcap", "bag", "feedback", "db3", "npz", "npz-inside", "parquet", "csv", "csv-map"),
    *("map", "list", "document"),
)
HANG = 5  # s
MEMORY = 1500 * 2**20  # bytes of address space beyond what the process began with
INTERESTING = (
    b"\x00",
    b"\xff",
    b"\x7f",
    b"\x80",
    b"\xff\xff\xff\xff",
    b"\xff\xff\xff\x7f",
    b"\0\0\0\x80",
    b"nan",
    b"1e999",
    b"-1",
)


def mutate(seed: bytes, chance: random.Random) -> bytes:
    """Return a damaged copy: bits, bytes, stretches, lengths."""
    data = bytearray(seed)
    for _ in range(chance.choice((1, 1, 1, 2, 4, 16))):
        if not data:
            break
        at = chance.randrange(len(data))
        kind = chance.randrange(8)
        if kind == 0:
            data[at] ^= 1 << chance.randrange(8)
        elif kind == 1:
            data[at] = chance.randrange(256)
        elif kind == 2:
            del data[at:]
        elif kind == 3:
            del data[at : at + chance.randrange(1, 64)]
        elif kind == 4:
            data[at:at] = data[at : at + chance.randrange(1, 64)]
        elif kind == 5:
            value = chance.choice(INTERESTING)
            data[at : at + len(value)] = value
        elif kind == 6:
            other = chance.randrange(len(data))
            length = chance.randrange(1, 64)
            data[at : at + length] = data[other : other + length]
        else:
            number = chance.choice((0, 1, 255, 2**31 - 1, 2**32 - 1, 2**63 - 1, 2**64 - 1, chance.getrandbits(32)))
            size = chance.choice((1, 2, 4, 8))
            data[at : at + size] = (number % 2 ** (8 * size)).to_bytes(size, chance.choice(("little", "big")))
    return bytes(data)


def samples(count: int = 40) -> list[Sample]:
    random_numbers = np.random.default_rng(1).normal(size=(count, 23))
    return [
        Sample(k / 100, r[:7], r[7:14], r[14:21], float(r[21]), float(r[22])) for k, r in enumerate(random_numbers)
    ]


def _run_seed(folder: Path) -> bytes:
    """Return a run's stream; its chunks are not compressed and bear no checksum, so that damage gets further."""
    from mcap import writer as library

    from estimation.recording import RunWriter, stream

    def plain(file: object) -> object:
        made = library.Writer(file, compression=library.CompressionType.NONE, enable_crcs=False)  # type: ignore[arg-type]
        made.start(profile="", library=stream.LIBRARY)
        return made

    stream._writer = plain  # type: ignore[assignment]
    with RunWriter.create(folder / "run", {"seed": 1}, "cube") as run:
        for k, one in enumerate(samples()):
            if k == 5:
                run.decision(one.time, {"choice": "weigh"})
                run.phase("weigh", "tare", 0, one.time)
            run.sample(one)
        run.measurement(0.4, "weigh", Measurement("mass", 0.1, 0.01, "kg"))
        run.belief(0.4, {"material": {"wood": 1.0}})
    return (folder / "run" / "run.mcap").read_bytes()


def _bag_seed(folder: Path, kind: str) -> bytes:
    from rosbags.rosbag1 import Writer as Writer1
    from rosbags.rosbag2 import StoragePlugin
    from rosbags.rosbag2 import Writer as Writer2
    from rosbags.typesys import Stores, get_typestore

    types = get_typestore(Stores.ROS1_NOETIC if kind == "bag" else Stores.ROS2_HUMBLE)
    state = types.types["sensor_msgs/msg/JointState"]
    header, stamp = types.types["std_msgs/msg/Header"], types.types["builtin_interfaces/msg/Time"]
    path = folder / f"seed-{kind}"
    if kind == "bag":
        writer: Writer1 | Writer2 = Writer1(path)
    else:
        plugin = StoragePlugin.MCAP if kind == "ros2-mcap" else StoragePlugin.SQLITE3
        writer = Writer2(path, version=9, storage_plugin=plugin)
    with writer:
        topic = writer.add_connection("/joint_states", state.__msgtype__, typestore=types)
        for one in samples():
            at = round(one.time * 1e9) + 10**18
            extra = (0,) if kind == "bag" else ()
            names = [f"joint_{n}" for n in range(1, 8)]
            message = state(header(*extra, stamp(at // 10**9, at % 10**9), ""), names, one.q, one.dq, one.tau)
            encode = types.serialize_ros1 if kind == "bag" else types.serialize_cdr
            writer.write(topic, at, encode(message, state.__msgtype__))
    if kind == "bag":
        return path.read_bytes()
    return next(iter([*path.glob("*.mcap"), *path.glob("*.db3")])).read_bytes()


FEEDBACK = {  # the fields that matter, of the message that the ROS 1 driver of the Gen3 publishes
    "BaseCyclic_Feedback": (
        "uint32 frame_id\nActuatorFeedback[] actuators\nInterconnectCyclic_Feedback interconnect"
    ),
    "ActuatorFeedback": "uint32 command_id\nfloat32 position\nfloat32 velocity\nfloat32 torque",
    "InterconnectCyclic_Feedback": "InterconnectCyclic_Feedback_tool_feedback oneof_tool_feedback",
    "InterconnectCyclic_Feedback_tool_feedback": "GripperCyclic_Feedback[] gripper_feedback",
    "GripperCyclic_Feedback": "MotorFeedback[] motor",
    "MotorFeedback": "uint32 motor_id\nfloat32 position\nfloat32 velocity\nfloat32 current_motor",
}


def _feedback_seed(folder: Path) -> bytes:
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    types = get_typestore(Stores.ROS1_NOETIC)
    for name, text in FEEDBACK.items():
        types.register(get_types_from_msg(text, f"kortex_driver/msg/{name}"))
    known = {name: types.types[f"kortex_driver/msg/{name}"] for name in FEEDBACK}
    path, kind = folder / "seed-feedback", "kortex_driver/msg/BaseCyclic_Feedback"
    with Writer(path) as writer:
        topic = writer.add_connection("/base_feedback", kind, typestore=types)
        for n, one in enumerate(samples()):
            actuators = [known["ActuatorFeedback"](0, *row) for row in zip(one.q, one.dq, one.tau, strict=True)]
            motor = known["MotorFeedback"](0, one.opening, 0.0, one.effort)
            tool = known["InterconnectCyclic_Feedback_tool_feedback"]([known["GripperCyclic_Feedback"]([motor])])
            message = known["BaseCyclic_Feedback"](n, actuators, known["InterconnectCyclic_Feedback"](tool))
            writer.write(topic, round(one.time * 1e9) + 10**18, types.serialize_ros1(message, kind))
    return path.read_bytes()


def mutate_inside(seed: bytes, chance: random.Random) -> bytes:
    """Return an archive with one damaged member whose checksum is right."""
    members = {}
    with zipfile.ZipFile(io.BytesIO(seed)) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    name = chance.choice(sorted(members))
    members[name] = mutate(members[name], chance)
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w") as archive:
        for member, content in members.items():
            archive.writestr(member, content)
    return made.getvalue()


def _npz_seed(folder: Path) -> bytes:
    s = samples()
    np.savez(
        folder / "seed.npz",
        time=np.array([x.time for x in s]),
        q=np.array([x.q for x in s]),
        tau=np.array([x.tau for x in s]),
        phase=np.array(["weigh/tare"] * len(s)),
    )
    return (folder / "seed.npz").read_bytes()


def _parquet_seed(folder: Path) -> bytes:
    import pyarrow as pa
    import pyarrow.parquet as pq

    s = samples()
    table = pa.table(
        {"time": [x.time for x in s], "q": [x.q.tolist() for x in s], "tau": [x.tau.tolist() for x in s]}
    )
    pq.write_table(table, folder / "seed.parquet", compression="NONE")
    return (folder / "seed.parquet").read_bytes()


def _csv_seed(folder: Path) -> bytes:
    lines = ["time," + ",".join(f"q{n}" for n in range(1, 8)) + ",phase"]
    lines += [f"{x.time}," + ",".join(map(repr, x.q.tolist())) + ",weigh/tare" for x in samples()]
    return "\n".join(lines).encode()


MAP = b"""[columns]
time = "t"
q = ["a", "b"]
[units]
q = "deg"
tau = "N mm"
[options]
torque_sign = -1
joints = ["x"]
"""
LIST = b"""[{"object_name": "item", "measurements": [{"name": "density", "value":
 {"sigma": 1000, "mean": 7337.799079987667, "units": "kg.^{-3}"}}, {"name": "elasticity", "value":
 {"sigma": 1000, "mean": 4969.7, "units": "kPa"}}], "object_id": "1"}]"""
DOCUMENT = b"""{"measurement": {"object_instance": {"dataset": "ycb", "dataset_id": "011", "other": {}},
 "setup": {"arm": "kinova", "gripper": "robotiq"},
 "sensor_outputs": {"robotiq": {"time": [1, 2], "parameters": {}}},
 "grasp": {"translation": [1, 2, 3], "rotation": [1, 2, 3], "grasped": true}, "method": "weigh"},
 "entries": [{"type": "continuous", "name": "density", "repository": null, "values":
 [{"name": "density", "mean": 253.98, "std": 800, "units": "kg m^-3"}]}]}"""


def reader(name: str, folder: Path) -> tuple[bytes, Callable[[Path], object], str]:
    """Return a good file, what reads it, and the ending it has."""
    from estimation.ipalm import from_json, from_list
    from estimation.ipalm.documents import measurements_of
    from estimation.readers import LogMap, read_log
    from estimation.recording import read_recording
    from estimation.units import parse_unit

    parse_unit("W/(m K)")  # loads the library of units, which takes a second
    by_number = {"time": 0, "q": tuple(range(1, 8)), "current": tuple(range(1, 8))}

    def text(path: Path) -> str:
        return path.read_bytes().decode("utf-8", "replace")

    if name == "run":
        return _run_seed(folder), read_recording, ".mcap"
    if name == "feedback":
        return _feedback_seed(folder), read_log, ".bag"
    if name in ("ros2-mcap", "bag", "db3"):
        return _bag_seed(folder, name), read_log, {"ros2-mcap": ".mcap"}.get(name, f".{name}")
    simple: dict[str, tuple[Callable[[], bytes], Callable[[Path], object], str]] = {
        "npz": (lambda: _npz_seed(folder), read_log, ".npz"),
        "npz-inside": (lambda: _npz_seed(folder), read_log, ".npz"),
        "parquet": (lambda: _parquet_seed(folder), read_log, ".parquet"),
        "csv": (lambda: _csv_seed(folder), read_log, ".csv"),
        "csv-map": (lambda: _csv_seed(folder), lambda path: read_log(path, LogMap(by_number)), ".csv"),
        "map": (lambda: MAP, LogMap.from_file, ".toml"),
        "list": (lambda: LIST, lambda path: from_list(text(path)), ".json"),
        "document": (lambda: DOCUMENT, lambda path: measurements_of(from_json(text(path))), ".json"),
    }
    made, function, ending = simple[name]
    return made(), function, ending


class Hang(BaseException):
    """A file took too long."""


def attack(name: str, seconds: float, files: int, start: int) -> dict[str, object]:
    """Give one reader damaged files for a time; return what happened."""
    import logging

    logging.disable(logging.CRITICAL)
    tally: dict[str, object] = {
        "files": 0,
        "read": 0,
        "refused": 0,
        "errors": 0,
        "hangs": 0,
        "memory": 0,
        "slowest_s": 0.0,
    }
    found: list[str] = []

    def count(key: str) -> None:
        tally[key] = int(str(tally[key])) + 1

    def late(*_: object) -> None:
        raise Hang

    signal.signal(signal.SIGALRM, late)
    base = Path("/dev/shm") if Path("/dev/shm").is_dir() else Path(tempfile.gettempdir())
    with tempfile.TemporaryDirectory(dir=base) as place:
        folder = Path(place)
        seed, read, ending = reader(name, folder)
        target = folder / f"damaged{ending}"
        target.write_bytes(seed)
        read(target)  # the good one is read, and everything is imported
        used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY, used + MEMORY))
        begin, number = time.monotonic(), start
        while time.monotonic() - begin < seconds and number - start < files:
            damaged = (mutate_inside if name == "npz-inside" else mutate)(seed, random.Random(number))
            target.write_bytes(damaged)
            print(number, file=sys.stderr, flush=True)  # the last one named is the one that crashed
            before = time.monotonic()
            signal.setitimer(signal.ITIMER_REAL, HANG)
            try:
                read(target)
                count("read")
            except PalpateError as error:
                count("memory" if "memory" in str(error).lower() and "declared" not in str(error) else "refused")
            except Hang:
                count("hangs")
                found.append(f"{number}: hang")
            except MemoryError:
                count("memory")
                found.append(f"{number}: memory")
            except Exception as error:
                count("errors")
                found.append(f"{number}: {type(error).__name__}: {error}"[:300])
            finally:
                signal.setitimer(signal.ITIMER_REAL, 0)
            tally["slowest_s"] = max(float(str(tally["slowest_s"])), time.monotonic() - before)
            number += 1
            count("files")
    return {**tally, "peak_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024, "found": found[:10]}


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.fuzz", description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0, help="for each reader")
    parser.add_argument("--files", type=int, default=100_000, help="for each reader, at most")
    parser.add_argument("--start", type=int, default=0, help="number of the first damage")
    parser.add_argument("--reader", choices=READERS, action="append")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--child", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.child:
        print(json.dumps(attack(given.child, given.seconds, given.files, given.start)))
        return
    figures: dict[str, object] = {}
    for name in given.reader or READERS:
        command = [sys.executable, "-m", "benchmarks.fuzz", "--child", name, "--seconds", str(given.seconds)]
        command += ["--files", str(given.files), "--start", str(given.start)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            last = done.stderr.strip().splitlines()[-3:]
            figures[name] = {"crash": done.returncode, "last": last}
        else:
            figures[name] = {"crash": 0, **json.loads(done.stdout)}
        if not given.json:
            print(name, figures[name], flush=True)
    if given.json:
        print(json.dumps(figures))


if __name__ == "__main__":
    main()
