"""Presets of the bench: the thesis' four classes of softness, each pressed to its two end positions.

The thesis (3.1.2) drives each finger towards a place 1 or 2 cm past the middle of the cube, so that the drive's
give makes it a force; it names neither the stiffness of its drive nor SI values of its classes, so both are ours:
1000 N/m makes 10 to 50 N, and the classes are objects of those names.
"""

from __future__ import annotations

from dataclasses import dataclass

from dynamics.errors import UnknownName

CLASSES = ("very-soft", "soft", "medium", "hard")
ENDS = {"1cm": -0.01, "2cm": -0.02}  # m
DRIVE = 1000.0  # N/m, of each plate
SPEED = 0.02  # m/s


@dataclass(frozen=True)
class Preset:
    """A squeeze by name.

    Attributes:
        name: what it is called.
        object: name of the object.
        end: place that each plate is driven to, from the middle, negative beyond it [m].
        about: one line for a list.
    """

    name: str
    object: str
    end: float
    about: str


PRESETS = {
    f"{softness}-{label}": Preset(
        f"{softness}-{label}",
        softness,
        end,
        f"the {softness.replace('-', ' ')} cube, each plate driven to {end} m",
    )
    for softness in CLASSES
    for label, end in ENDS.items()
}


def preset(name: str) -> Preset:
    """Return a preset by name.

    Raises:
        UnknownName: if there is none of that name.
    """
    if name not in PRESETS:
        raise UnknownName("--preset", name, PRESETS)
    return PRESETS[name]
