"""The registry of robots: the one place where the exploration's side names simulation and hardware.

An entry opens a robot and, for a simulated one, hands out the truth about its object apart from it, for the
comparison at the very end.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from dynamics.arm import Arm
from dynamics.errors import InvalidInput, NoRobot, PalpateError, UnknownName
from dynamics.gripper import LoadSpread, ParallelGripper
from dynamics.robot import Robot
from dynamics.signals import Sample
from dynamics.trajectory import Trajectory
from estimation.network import CATEGORY, MATERIAL, Network
from models.robot import Revision
from selection.eyes import Senses, drawn_senses

NOISE_NAMES = ("default", "none")


@dataclass(frozen=True)
class RobotRequest:
    """Which robot is wanted.

    Attributes:
        object_file: the object on its table; a real robot does not read it.
        noise: ``default``, ``none``, or the path of a sensor model; for simulated robots.
        seed: of everything random in a simulated robot.
        revision, vision: which Gen3 it is.
        host, tcp_port, udp_port: where a real arm listens.
        tare: file of a tare of a real arm's torque sensors.
        load_spread: what the pads' load does in an object between a real gripper's pads, ``pad`` or ``face``.
        yes: do not ask before a real arm's first motion.
        dry_run: only plan; a real arm is connected and checked, and never moves.
    """

    object_file: Path
    noise: str = "default"
    seed: int = 0
    revision: Revision = "V12"
    vision: bool = True
    host: str = ""
    tcp_port: int = 10000
    udp_port: int = 10001
    tare: Path | None = None
    load_spread: LoadSpread = "pad"
    yes: bool = False
    dry_run: bool = False


@dataclass(frozen=True)
class OpenedRobot:
    """A robot ready to move.

    Attributes:
        robot: what the exploration sees.
        truth: what the object really is, if it is simulated: its material, and the SI values of its properties.
        senses: gives the classifiers that come with it, for a reference; a simulated one answers by the truth,
            through the confusion matrices of the reference.
        judge: of a robot that only plans: what it has to say to a motion, if anything.
    """

    robot: Robot
    truth: Truth | None
    judge: Callable[[Trajectory], None] | None = None
    senses: Callable[[Network], Senses] = lambda network: {}


@dataclass(frozen=True)
class Truth:
    """What a simulated object really is.

    Attributes:
        material: the name of its material, or ``unknown``.
        category: the name of its category, or ``unknown``.
        properties: SI values by name.
        units: SI units by name.
    """

    material: str
    category: str
    properties: Mapping[str, float]
    units: Mapping[str, str]


def open_robot(name: str, request: RobotRequest) -> OpenedRobot:
    """Open a robot by name.

    Raises:
        InvalidInput: if there is no robot of that name, or something about it is unusable.
        NoRobot: if it cannot be opened.
    """
    if name not in ROBOTS:
        raise UnknownName("--robot", name, ROBOTS)
    try:
        return ROBOTS[name](request)
    except InvalidInput:
        raise
    except PalpateError as error:
        raise NoRobot(str(error)) from error


def simulated_at_rest(revision: Revision = "V12", vision: bool = True) -> tuple[Arm, ParallelGripper, Sample]:
    """Return arm and gripper of the simulated robot and how it stands at the start, without a simulation."""
    import numpy as np

    from dynamics.gripper import robotiq_2f85
    from sim.robot import start_position

    arm, gripper = Arm.gen3(revision, vision), robotiq_2f85()
    still = np.zeros(arm.nv)
    return arm, gripper, Sample(0.0, start_position(arm), still, still, gripper.max_opening, 0.0)


def _simulated(request: RobotRequest) -> OpenedRobot:
    from sim.robot import MujocoRobot
    from sim.sensors import SensorModel
    from sim.truth import read_truth

    truth = read_truth(request.object_file)
    if request.noise == "default":
        noise = SensorModel()
    elif request.noise == "none":
        noise = SensorModel.none()
    elif request.noise.endswith(".toml") or "/" in request.noise:
        noise = SensorModel.from_file(Path(request.noise))
    else:
        raise InvalidInput("--noise", request.noise, f"{', '.join(NOISE_NAMES)}, or a TOML file")
    told = Truth(
        material=truth.material,
        category=truth.category,
        properties={
            "mass": truth.mass,
            "density": truth.density,
            "elasticity": truth.young_modulus,
            "friction": truth.friction,
            "volume": truth.volume,
        },
        units={"mass": "kg", "density": "kg/m^3", "elasticity": "Pa", "friction": "1", "volume": "m^3"},
    )
    robot = MujocoRobot(truth, noise, request.seed, revision=request.revision, vision=request.vision)
    classes = {MATERIAL: truth.material, CATEGORY: truth.category}
    return OpenedRobot(robot, told, senses=lambda network: drawn_senses(network, classes, request.seed))


def _kortex(request: RobotRequest) -> OpenedRobot:
    from dynamics.gripper import robotiq_2f85
    from hw.connect import connect

    if not request.host:
        raise InvalidInput("--host", "nothing", "name or address of the arm, for --robot kortex")
    robot = connect(
        request.host,
        request.tcp_port,
        request.udp_port,
        revision=request.revision,
        vision=request.vision,
        gripper=robotiq_2f85(request.load_spread),
        tare=request.tare,
        dry_run=request.dry_run,
        yes=request.yes,
    )
    return OpenedRobot(robot, None, judge=robot.follow if request.dry_run else None)


ROBOTS: dict[str, Callable[[RobotRequest], OpenedRobot]] = {"sim": _simulated, "kortex": _kortex}
