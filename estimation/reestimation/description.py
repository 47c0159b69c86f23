"""What a run's configuration says of robot, object and reference, so that its estimates can be made again."""

from __future__ import annotations

import base64
import contextlib
import dataclasses
import math
import re
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dynamics.arm import Arm
from dynamics.errors import InvalidInput, PalpateError
from dynamics.gripper import ParallelGripper, robotiq_2f85
from dynamics.objects import DeclaredObject, read_declared
from dynamics.tables import Table, read_toml

if TYPE_CHECKING:
    from estimation.belief import Belief

_GEN3 = re.compile(r"gen3-(V12|BRAKES)(-vision)?(?:-(2f85))?")


@dataclass(frozen=True)
class Known:
    """What estimators need besides the samples; what is None is unknown, and its estimates are left out.

    Attributes:
        arm, gripper: as the robot's user knows them.
        declared: of the object.
        blank: belief before anything was measured.
        notes: what is missing, and why.
        closing_edge: which edge of the object the pads close on; None where the arm's pose tells.
    """

    arm: Arm
    gripper: ParallelGripper
    declared: DeclaredObject | None = None
    blank: Belief | None = None
    notes: tuple[str, ...] = ()
    closing_edge: int | None = None


def describe(arm: Arm, gripper: ParallelGripper) -> dict[str, Any]:
    """Return what a configuration should say of a robot: ``arm`` and ``gripper``; infinite values are left out."""
    return {"arm": arm.name, "torque_gain_sd": arm.torque_gain_sd, "gripper": describe_gripper(gripper)}


def describe_bench(gripper: ParallelGripper, edge: int) -> dict[str, Any]:
    """Return what a configuration should say of plates without an arm that close on an edge of the object."""
    return {"closing_edge": edge, "gripper": describe_gripper(gripper)}


def describe_gripper(gripper: ParallelGripper) -> dict[str, Any]:
    """Return a gripper's description; infinite values are left out."""
    table = dataclasses.asdict(gripper)
    return {k: v for k, v in table.items() if not (isinstance(v, float) and math.isinf(v))}


def known_of(
    config: Mapping[str, Any], arm: Arm | None = None, reference: str = "", object_file: str = ""
) -> Known:
    """Return what a run's configuration knows.

    Args:
        config: of the run; empty for foreign logs.
        arm: takes precedence over the configuration's.
        reference, object_file: the same, as names or files.

    Raises:
        InvalidInput: if something that was named here can not be read; what only the configuration names is noted.
    """
    notes: list[str] = []
    edge = config.get("closing_edge")
    edge = edge if isinstance(edge, int) and edge in (0, 1, 2) else None
    if arm is None:
        named = config.get("arm")
        arm = arm_named(named) if isinstance(named, str) else Arm.gen3()
        if config and not isinstance(named, str) and edge is None:
            notes.append("the recording does not say which arm it was; taken as gen3-V12 with vision and 2f85")
        arm.torque_gain_sd = Table("recording", config).number("torque_gain_sd", arm.torque_gain_sd, at_least=0)
    declared = _declared(config, object_file, notes)
    blank = _blank(config, reference, notes)
    return Known(arm, _gripper(config, notes), declared, blank, tuple(notes), edge)


def arm_named(name: str, tool_frame: str = "") -> Arm:
    """Return an arm by the name it has in recordings, by the name of a robot, or from a URDF or MJCF file.

    Raises:
        InvalidInput: for an unknown name or a file that can not be loaded.
    """
    match = _GEN3.fullmatch(name)
    if match:
        return Arm.gen3("BRAKES" if match[1] == "BRAKES" else "V12", match[2] is not None, match[3])
    path = Path(name)
    if path.suffix.lower() in (".urdf", ".xml", ".mjcf"):
        if not tool_frame:
            raise InvalidInput(f"robot {name}: tool frame", "none", "the name of one; option --tool-frame")
        load = Arm.from_urdf if path.suffix.lower() == ".urdf" else Arm.from_mjcf
        return load(path, tool_frame)
    return Arm.named(name)


def _gripper(config: Mapping[str, Any], notes: list[str]) -> ParallelGripper:
    table = config.get("gripper")
    if not isinstance(table, Mapping):
        if config:
            notes.append("the recording does not describe its gripper; taken as a 2F-85 of nominal calibration")
        return robotiq_2f85()
    names = {field.name for field in dataclasses.fields(ParallelGripper)}
    try:
        return ParallelGripper(**{key: value for key, value in table.items() if key in names})
    except TypeError as error:
        raise InvalidInput("recording: gripper", str(error), "a gripper's description") from None


def _declared(config: Mapping[str, Any], object_file: str, notes: list[str]) -> DeclaredObject | None:
    if object_file:
        from models import objects

        try:
            return read_declared(objects.locate(object_file))
        except KeyError:
            raise InvalidInput("--object", object_file, ", ".join(objects.names()) + ", or a file") from None
    text = config.get("object_file")
    if not isinstance(text, str):
        return None
    with tempfile.TemporaryDirectory(prefix="palpate-") as folder:
        path = Path(folder) / f"{config.get('object', 'object')}.toml".replace("/", "_")
        path.write_text(text, encoding="utf-8")
        mesh = config.get("object_mesh")
        if isinstance(mesh, Mapping):
            write_mesh(path.parent, mesh)
        try:
            return read_declared(path)
        except PalpateError as error:
            notes.append(f"the object's description is unusable: {error}")
            return None


def _blank(config: Mapping[str, Any], reference: str, notes: list[str]) -> Belief | None:
    from estimation.belief import Belief
    from estimation.network import Network
    from estimation.prior import parse_prior

    name = reference or config.get("reference")
    if not isinstance(name, str):
        return None
    try:
        network = Network.from_file(name)
    except PalpateError as error:
        if reference:
            raise
        notes.append(f"no belief: {error}")
        return None
    return Belief(network, parse_prior(str(config.get("prior") or ""), network, "recording: prior"))


def mesh_of(object_file: Path) -> dict[str, Any]:
    """Return what a configuration should keep of the mesh that an object file names, if it names one."""
    declared = read_toml(object_file).get("declared")
    name = declared.get("mesh") if isinstance(declared, Mapping) else None
    if not isinstance(name, str):
        return {}
    try:
        content = base64.b64encode((object_file.parent / name).read_bytes()).decode("ascii")
    except OSError:  # who reads the object says so
        return {}
    return {"object_mesh": {"name": name, "content": content}}


def write_mesh(folder: Path, mesh: Mapping[str, Any]) -> None:
    """Write a kept mesh where the object file will look for it, but nowhere else."""
    name, content = mesh.get("name"), mesh.get("content")
    if not isinstance(name, str) or not isinstance(content, str):
        return
    path = (folder / name).resolve()
    if folder.resolve() in path.parents:
        path.parent.mkdir(parents=True, exist_ok=True)
        with contextlib.suppress(ValueError):  # damaged: then the object file says what is missing
            path.write_bytes(base64.b64decode(content, validate=True))
