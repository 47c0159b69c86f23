"""Robots by name: the Gen3 of this project, and arms of the example-robot-data package."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, files
from pathlib import Path

from dynamics.errors import InvalidInput, UnknownName

# name: (description in example-robot-data, tool frame)
_EXAMPLES = {
    "ur3": ("ur_description/urdf/ur3_robot.urdf", "tool0"),
    "ur5": ("ur_description/urdf/ur5_robot.urdf", "tool0"),
    "ur10": ("ur_description/urdf/ur10_robot.urdf", "tool0"),
    "panda": ("panda_description/urdf/panda.urdf", "panda_hand_tcp"),
    "xarm7": ("xarm_description/urdf/xarm7.urdf", "link_eef"),
    "jaco": ("kinova_description/robots/kinova.urdf", "j2s6s200_end_effector"),
}
ROBOTS = ("gen3", *_EXAMPLES)


def example_description(name: str) -> tuple[Path, str]:
    """Return the URDF of a robot by name, and its tool frame.

    Raises:
        UnknownName: if there is no such robot.
        InvalidInput: if the package that holds it is not installed.
    """
    if name not in _EXAMPLES:
        raise UnknownName("robot", name, ROBOTS)
    path, frame = _EXAMPLES[name]
    try:
        listed = files("example-robot-data") or []
    except PackageNotFoundError:
        raise InvalidInput(f"robot {name}", "no package example-robot-data", "that package installed") from None
    for file in listed:
        if file.as_posix().endswith(f"example-robot-data/robots/{path}"):
            return Path(str(file.locate())), frame
    raise InvalidInput(f"robot {name}", f"no {path} in example-robot-data", "a release that has it")
