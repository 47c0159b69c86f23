"""Press a simulated object between two free pads, without gravity: what its few cells make of its modulus.

The factor of an object is the modulus that its squeeze shows, by the theory of `dynamics.compression` for pads,
over the one it was given:

    F(e) ~ factor E A h(e - e0),

fitted over strains up to ``DEPTH`` with a free onset e0, as a squeeze of the hand is read.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from dataclasses import replace

import mujoco
import numpy as np
from numpy.typing import NDArray

from dynamics.compression import geometry_of
from dynamics.gripper import ParallelGripper, robotiq_2f85
from sim.bodies import Fidelity, add_object, prepare
from sim.contact import TIMESTEP
from sim.robot import SimulationError
from sim.truth import TrueObject

Array = NDArray[np.float64]

DEPTH = 0.10  # strain
SPEED = 0.02  # m/s of closing, both pads together
YOUNG, MASS = 5e4, 0.1  # Pa, kg; the factor is that of all of them
_GAIN, _DAMPING = 5e4, 500.0  # N/m, N s/m of the pads' drives
_GAP = 0.0003  # m between pad and object at first
_THICKNESS = 0.01  # m of a pad
_ONSETS = np.linspace(-0.01, 0.03, 81)


def press(truth: TrueObject, axis: int) -> float:
    """Return the factor of an object's modulus in the fidelity ``indentation`` without calibration [-].

    Args:
        truth: the object; its modulus and mass do not matter.
        axis: that the pads close along, 0 or 1.
    """
    gripper = robotiq_2f85("pad")
    sample = replace(truth, young_modulus=YOUNG, mass=MASS, yield_strain=0.0)
    width = truth.size[axis]
    strain, force = press_curve(sample, axis, "indentation", factor=1.0)
    geometry = geometry_of(
        truth.shape,
        (width, truth.size[1 - axis], truth.size[2]),
        gripper,
        poisson=truth.poisson,
        fill=truth.declared.fill,
    )
    best = (math.inf, 1.0)
    for onset in _ONSETS:
        law = YOUNG * geometry.area * geometry.law_of(strain - onset)
        factor = float(law @ force / (law @ law))
        best = min(best, (float(np.sum((force - factor * law) ** 2)), factor))
    return best[1]


def press_curve(
    truth: TrueObject,
    axis: int,
    fidelity: Fidelity,
    factor: float | None = None,
    depth: float = DEPTH,
    released: bool = False,
) -> tuple[Array, Array]:
    """Return the strain of an object between the pads and their force [N], (N,), step by step.

    Args:
        truth: the object.
        axis: that the pads close along, 0 or 1.
        fidelity: how it deforms.
        factor: by which its cells are too stiff; the calibrated one if None.
        depth: strain to press to.
        released: whether to draw back afterwards.

    Raises:
        SimulationError: if the engine warned.
    """
    gripper = robotiq_2f85("pad")
    width = truth.size[axis]
    model = mujoco.MjModel.from_xml_string(_mjcf(truth, axis, gripper, fidelity, factor))
    prepare(model, truth)
    data = mujoco.MjData(model)
    rows: list[tuple[float, float]] = []
    reached, turned = 0.0, math.inf
    patience = 2 * depth * width / SPEED + 0.1  # s, for an object that the drives can hardly press
    while data.time < 2 * turned:
        if turned == math.inf and (reached >= depth or data.time > patience):
            turned = float(data.time)
            if not released:
                break
        data.ctrl[:] = min(data.time, 2 * turned - data.time) * SPEED / 2
        mujoco.mj_step(model, data)
        # The engine reports the drives' force at the start of the step but applies it, implicitly, at its end.
        force = data.actuator_force - _GAIN * TIMESTEP * data.qvel[:2]
        reached = float(data.qpos[:2].sum() - 2 * _GAP) / width
        if reached > 0:
            rows.append((reached, float(force.mean())))
    if any(warning.number for warning in data.warning):
        raise SimulationError(f"MuJoCo warned while {truth.declared.name} was pressed")
    strain, pressed = np.array(rows).T
    return strain, pressed


def _mjcf(truth: TrueObject, axis: int, gripper: ParallelGripper, fidelity: Fidelity, factor: float | None) -> str:
    root = ET.fromstring(
        f"<mujoco><compiler angle='radian'/><option timestep='{TIMESTEP}' integrator='discrete' solver='Newton' "
        "cone='elliptic' impratio='50' tolerance='1e-8' gravity='0 0 0'/><worldbody/><actuator/></mujoco>"
    )
    world, drives = root.find("worldbody"), root.find("actuator")
    assert world is not None
    assert drives is not None
    half = [gripper.pad_width / 2, gripper.pad_width / 2, gripper.pad_length / 2]
    half[axis] = _THICKNESS / 2
    for side, name in ((-1, "left"), (1, "right")):
        place, closing = [0.0, 0.0, 0.0], [0, 0, 0]
        place[axis] = side * (truth.size[axis] / 2 + _THICKNESS / 2 + _GAP)
        closing[axis] = -side
        body = ET.SubElement(world, "body", name=name, pos=" ".join(map(repr, place)))
        ET.SubElement(body, "joint", name=name, type="slide", axis=" ".join(map(str, closing)))
        ET.SubElement(body, "geom", type="box", size=" ".join(map(repr, half)), mass="0.5")
        ET.SubElement(drives, "position", joint=name, kp=repr(_GAIN), kv=repr(_DAMPING))
    add_object(root, truth, fidelity, np.eye(4), factor=factor)
    return ET.tostring(root, encoding="unicode")
