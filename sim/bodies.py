"""Simulated objects as MJCF: a soft body of any shape, or a rigid one where nothing would be seen to give way.

A soft body is an interpolated flex: a grid of cells around the shape carries the deformation, trilinear in each,
and the surface is moved with it. Two fidelities:

    uniform       one cell. The body is strained evenly whatever the pads' size, F = E (V / L) e exactly; it
                  neither indents nor bulges: no Poisson's ratio acts, for one cell that friction holds would lock.
                  What is round has flats where it is touched, for it does not flatten there, see `sim.surfaces`.
    indentation   two cells along each axis. Pads smaller than a face sink in, round bodies flatten where they are
                  touched, sides bulge. So few cells are too stiff under pads; the modulus is lowered by a
                  calibrated factor, see `sim.calibration`, so that the force is that of the continuum.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from dynamics.mesh import Mesh
from sim import surfaces
from sim.calibration import modulus_factor
from sim.contact import OVERDAMPED, TIMESTEP, ContactLaw, contact_law
from sim.truth import TrueObject

if TYPE_CHECKING:
    import mujoco

Fidelity = Literal["uniform", "indentation"]
FIDELITIES: tuple[Fidelity, ...] = ("uniform", "indentation")

NAME = "object"
FRAME = "object_frame"  # that a soft one stands in
SKIN = 1e-4  # m, radius of the vertices of a soft body
GAP = 1e-4  # m from which contact is looked for: first found at depths below 1e-6 m, half the normals are reversed
COLOR = "0.93 0.63 0.18 1"
CELLS: dict[Fidelity, int] = {"uniform": 1, "indentation": 2}
POINTS_AROUND: dict[Fidelity, int] = {"uniform": 24, "indentation": 96}  # points around a round body
_ROLLING = "0.005 0.0005"  # m; torsional and rolling friction of a rigid body, which soft ones have by flattening


def add_object(
    root: ET.Element,
    truth: TrueObject,
    fidelity: Fidelity = "uniform",
    pose: NDArray[np.float64] | None = None,
    timestep: float = TIMESTEP,
    factor: float | None = None,
    damping_ratio: float = OVERDAMPED,
) -> None:
    """Add an object, named ``object``, to the MJCF of a world.

    After compiling, `prepare` has to be called on the model.

    Args:
        root: the ``mujoco`` element; has a ``worldbody``.
        truth: the object.
        fidelity: how it deforms.
        pose: of the middle of its bounding box, (4, 4); where it is declared to stand, on z = 0, if None.
        timestep: of the simulation, which bounds how stiff a contact can be [s].
        factor: by which its cells are too stiff; the calibrated one if None.
        damping_ratio: of its contacts [-].
    """
    world = root.find("worldbody")
    assert world is not None
    if pose is None:
        pose = standing_pose(truth)
    place = {"pos": _text(pose[:3, 3]), "quat": _text(_quaternion(pose[:3, :3]))}
    law = contact_law(truth, timestep, damping_ratio)
    if truth.is_rigid:
        if truth.shape == "mesh":
            _add_asset(root, truth)
        world.append(_rigid(truth, place, law))
    else:
        if factor is None:
            factor = modulus_factor(truth) if fidelity == "indentation" else 1.0
        # The cells are laid along the axes of the body that a flex belongs to, whichever way the flex is turned.
        frame = ET.SubElement(world, "body", {"name": FRAME, **place})
        frame.append(_soft(truth, fidelity, law, factor))


def prepare(model: mujoco.MjModel, truth: TrueObject, timestep: float = TIMESTEP) -> None:
    """Make up in a compiled model for what text and contact law alone cannot reach, on the object's bodies."""
    if model.nflex:
        _forget_rounding(model)
    damping_ratio = model.flex_solref[0, 1] if model.nflex else model.geom(NAME).solref[1]
    shortfall = contact_law(truth, timestep, float(damping_ratio)).shortfall
    if shortfall > 1:
        model.body_invweight0[object_bodies(model)] /= shortfall


def _forget_rounding(model: mujoco.MjModel) -> None:
    """Cut the last digits off what a flex is compiled to: they depend on what the process compiled before it."""
    import mujoco

    bodies = object_bodies(model)
    model.body_mass[bodies] = _rounded(model.body_mass[bodies])
    model.body_inertia[bodies] = _rounded(model.body_inertia[bodies])
    model.flex_stiffness[:] = _rounded(model.flex_stiffness)
    mujoco.mj_setConst(model, mujoco.MjData(model))


def _rounded(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return values to nine or ten digits of the largest."""
    largest = float(np.abs(values).max(initial=0.0))
    if largest == 0.0:
        return values
    step = 2.0 ** (math.ceil(math.log2(largest)) - 32)
    rounded: NDArray[np.float64] = np.round(values / step) * step
    return rounded


def object_bodies(model: mujoco.MjModel) -> NDArray[np.int64]:
    """Return the numbers of the bodies that the object consists of: a soft one of its nodes."""
    if model.nflex:
        nodes = model.flex_nodebodyid if model.nflexnode else model.flex_vertbodyid
        return np.unique(nodes).astype(np.int64)
    return np.array([model.body(NAME).id], dtype=np.int64)


def object_pose(model: mujoco.MjModel, data: mujoco.MjData) -> NDArray[np.float64]:
    """Return where the middle of the object's mass is [m], (3,)."""
    bodies = object_bodies(model)
    mass = model.body_mass[bodies]
    middle: NDArray[np.float64] = mass @ data.xipos[bodies] / mass.sum()
    return middle


def standing_pose(truth: TrueObject) -> NDArray[np.float64]:
    """Return the pose of the middle of its bounding box where it is declared to stand, on its skin, (4, 4)."""
    pose = truth.declared.pose()
    pose[2, 3] = truth.size[2] / 2 + SKIN
    return pose


def surface(truth: TrueObject, fidelity: Fidelity = "uniform") -> Mesh:
    """Return the surface of an object, centred on its bounding box."""
    if truth.shape == "box":
        return surfaces.box(truth.size)
    if truth.shape == "cylinder":
        return surfaces.cylinder(truth.size, POINTS_AROUND[fidelity])
    if truth.shape in ("sphere", "ellipsoid"):
        return surfaces.ellipsoid(truth.size, POINTS_AROUND[fidelity], flats=CELLS[fidelity] == 1)
    mesh = truth.declared.mesh
    assert mesh is not None, truth.shape
    return mesh.scaled(truth.size[0] / mesh.extents[0])


def _soft(truth: TrueObject, fidelity: Fidelity, law: ContactLaw, factor: float) -> ET.Element:
    cells = CELLS[fidelity]
    common = {
        "name": NAME,
        "dim": "3",
        "radius": repr(SKIN),
        "mass": repr(float(truth.mass)),
        "dof": "trilinear",
        "cellcount": f"{cells} {cells} {cells}",
        "rgba": COLOR,
    }
    outer = surface(truth, fidelity)
    inner = outer.scaled(tuple(1 - 2 * SKIN / extent for extent in outer.extents))  # type: ignore[arg-type]
    # Flat triangles cut off a little of a round body.
    modulus = truth.young_modulus / factor * truth.volume / outer.volume
    middle = inner.center_of_volume()
    points = np.vstack([middle, inner.points])
    fan = np.column_stack([np.zeros(len(inner.triangles), dtype=np.int64), inner.triangles + 1])
    body = ET.Element("flexcomp", common, type="direct", point=_text(points.ravel()))
    body.set("element", " ".join(map(str, fan.ravel())))
    poisson = truth.poisson if fidelity == "indentation" else 0.0
    elasticity = ET.SubElement(
        body,
        "elasticity",
        young=repr(float(modulus)),
        poisson=repr(float(poisson)),
        damping=repr(float(truth.damping)),
    )
    if truth.yield_strain > 0:
        elasticity.set("yield", repr(float(truth.yield_strain)))
    touch = {"selfcollide": "none", "condim": "3", **_touch(truth, law, "0.005 0.0001")}
    ET.SubElement(body, "contact", touch)
    return body


def _rigid(truth: TrueObject, place: dict[str, str], law: ContactLaw) -> ET.Element:
    body = ET.Element("body", {"name": NAME, **place})
    ET.SubElement(body, "freejoint")
    a, b, c = (extent / 2 for extent in truth.size)
    # Round bodies need a resistance to rolling, or they never come to rest.
    touch = {"condim": "6", **_touch(truth, law, _ROLLING)}
    shape = {"name": NAME, "type": truth.shape, "mass": repr(float(truth.mass)), "rgba": COLOR, **touch}
    if truth.shape == "mesh":
        shape["mesh"] = NAME
    else:
        sizes = {"box": (a, b, c), "cylinder": (a, c), "sphere": (a,), "ellipsoid": (a, b, c)}
        shape["size"] = _text(np.array(sizes[truth.shape]))
    ET.SubElement(body, "geom", shape)
    return body


def _touch(truth: TrueObject, law: ContactLaw, spin_and_roll: str) -> dict[str, str]:
    return {
        "friction": f"{truth.friction} {spin_and_roll}",
        "solref": f"{law.time_constant} {law.damping_ratio}",
        "solimp": f"{law.impedance} {law.impedance} 0.001",
        "priority": "2",
        "gap": repr(GAP),
        "contype": "1",
        "conaffinity": "7",
    }


def _add_asset(root: ET.Element, truth: TrueObject) -> None:
    asset = root.find("asset")
    if asset is None:
        asset = ET.SubElement(root, "asset")
    mesh = surface(truth)
    element = ET.SubElement(asset, "mesh", name=NAME, vertex=_text(mesh.points.ravel()))
    element.set("face", " ".join(map(str, mesh.triangles.ravel())))


def _quaternion(rotation: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the quaternion w, x, y, z of a rotation, by the largest of its parts."""
    r = rotation
    squares = np.array(
        [
            1 + r[0, 0] + r[1, 1] + r[2, 2],
            1 + r[0, 0] - r[1, 1] - r[2, 2],
            1 - r[0, 0] + r[1, 1] - r[2, 2],
            1 - r[0, 0] - r[1, 1] + r[2, 2],
        ]
    )
    largest = int(np.argmax(squares))
    w = math.sqrt(float(squares[largest])) / 2
    f = 1 / (4 * w)
    return np.array(
        {
            0: [w, (r[2, 1] - r[1, 2]) * f, (r[0, 2] - r[2, 0]) * f, (r[1, 0] - r[0, 1]) * f],
            1: [(r[2, 1] - r[1, 2]) * f, w, (r[0, 1] + r[1, 0]) * f, (r[0, 2] + r[2, 0]) * f],
            2: [(r[0, 2] - r[2, 0]) * f, (r[0, 1] + r[1, 0]) * f, w, (r[1, 2] + r[2, 1]) * f],
            3: [(r[1, 0] - r[0, 1]) * f, (r[0, 2] + r[2, 0]) * f, (r[1, 2] + r[2, 1]) * f, w],
        }[largest]
    )


def _text(values: NDArray[np.float64]) -> str:
    return " ".join(repr(float(value)) for value in values)
