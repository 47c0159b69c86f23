"""Compose the one robot description: Gen3 arm, hardware revision, vision module and 2F-85 gripper, as MJCF.

The topology and the shapes stand in ``robots/gen3_2f85.xml``, the published inertials of the two hardware
revisions in ``robots/gen3_inertials.toml``. What comes out is loaded as it is by Pinocchio and by MuJoCo.
``python -m models.robot`` prints it, for a viewer or another program.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import tomllib
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Literal

Revision = Literal["V12", "BRAKES"]
COLOUR_CAMERA = (0.0, 0.05639, -0.00305)
"""Place of the vision module's colour camera in the flange's frame [m]; it looks along +z (kortex_description)."""
TOOL_LENGTH = 0.12
"""Distance of the tool frame from the flange along z with the gripper 2f85 [m]."""
REVISIONS: tuple[Revision, ...] = ("V12", "BRAKES")
GRIPPERS: tuple[str, ...] = ("2f85",)

_FOLDER = Path(__file__).parent / "robots"


@cache
def gen3_mjcf(revision: Revision = "V12", vision: bool = True, gripper: str | None = "2f85") -> str:
    """Return the MJCF of a Kinova Gen3 with its gripper.

    Args:
        revision: hardware revision of the arm, ``V12`` or ``BRAKES``.
        vision: whether the bracelet carries the vision module.
        gripper: ``2f85``, or None for the bare flange; the site ``tool_frame`` is then at the flange.

    Raises:
        ValueError: if the revision or the gripper is unknown.
    """
    if revision not in REVISIONS:
        raise ValueError(f"revision {revision!r}: valid are {', '.join(REVISIONS)}")
    if gripper is not None and gripper not in GRIPPERS:
        raise ValueError(f"gripper {gripper!r}: valid are {', '.join(GRIPPERS)}, or none")
    inertials = tomllib.loads((_FOLDER / "gen3_inertials.toml").read_text())
    links = inertials[revision]["vision" if vision else "plain"]
    root = ET.parse(_FOLDER / "gen3_2f85.xml").getroot()
    bodies = {body.get("name"): body for body in root.iter("body")}
    for name, link in links.items():
        bodies[name].set("pos", _numbers(link["origin"]))
        inertial = ET.Element(
            "inertial",
            pos=_numbers(link["com"]),
            mass=repr(link["mass"]),
            fullinertia=_numbers(link["inertia"]),
        )
        bodies[name].insert(0, inertial)
    bracelet = bodies["bracelet_link"]
    if not vision:
        _remove(bracelet, "geom", "vision_module")
    if gripper is None:
        _remove(bracelet, "body", "gripper_base")
        flange = bracelet.find("site[@name='end_effector']")
        assert flange is not None
        bracelet.append(ET.Element("site", {**flange.attrib, "name": "tool_frame"}))
        root.remove(_child(root, "equality"))
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


@contextmanager
def as_file(mjcf: str) -> Iterator[Path]:
    """Yield a temporary file that holds a description, for loaders that take no text."""
    with tempfile.TemporaryDirectory(prefix="palpate-") as folder:
        path = Path(folder) / "robot.xml"
        path.write_text(mjcf)
        yield path


def main() -> None:
    """Print the description that the arguments name."""
    parser = argparse.ArgumentParser(prog="python -m models.robot", description=main.__doc__)
    parser.add_argument("--revision", choices=REVISIONS, default="V12")
    parser.add_argument("--no-vision", action="store_true", help="bracelet without the vision module")
    parser.add_argument("--no-gripper", action="store_true", help="the bare flange")
    given = parser.parse_args()
    sys.stdout.write(gen3_mjcf(given.revision, not given.no_vision, None if given.no_gripper else "2f85"))


def _numbers(values: list[float]) -> str:
    return " ".join(repr(float(value)) for value in values)


def _child(parent: ET.Element, path: str) -> ET.Element:
    child = parent.find(path)
    assert child is not None, path
    return child


def _remove(parent: ET.Element, tag: str, name: str) -> None:
    parent.remove(_child(parent, f"{tag}[@name='{name}']"))


if __name__ == "__main__":
    main()
