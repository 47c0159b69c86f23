"""The registry of robots: the one place where the exploration's side names simulation and hardware.

An entry opens a robot and, for a simulated one, hands out the truth about its object apart from it, for the
comparison at the very end.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from dynamics.arm import Arm
from dynamics.bench import Plates, SqueezeBench
from dynamics.errors import InvalidInput, NoRobot, PalpateError, UnknownName
from dynamics.gripper import LoadSpread, ParallelGripper
from dynamics.robot import Robot
from dynamics.signals import Sample
from dynamics.trajectory import Trajectory
from estimation.network import CATEGORY, MATERIAL, Network
from models.robot import Revision
from selection.eyes import Senses, drawn_senses

if TYPE_CHECKING:
    from sim.sensors import SensorModel
    from sim.truth import TrueObject

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
        fidelity: how a simulated object deforms, ``uniform`` or ``indentation``.
        load_spread: what the pads' load does in an object between a real gripper's pads, ``pad`` or ``face``.
        yes: do not ask before a real arm's first motion.
        draws: whether a simulated robot will be asked for pictures.
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
    fidelity: Literal["uniform", "indentation"] = "uniform"
    yes: bool = False
    draws: bool = False
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
        show: opens a viewer that is so many times as fast as real time at most, if it is simulated.
    """

    robot: Robot
    truth: Truth | None
    judge: Callable[[Trajectory], None] | None = None
    senses: Callable[[Network], Senses] = lambda network: {}
    show: Callable[[float], None] | None = None


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
    if request.draws:
        from sim.opengl import choose_backend

        choose_backend()
    from selection.actions.reach import find_grasp, free_space
    from sim.robot import MujocoRobot
    from sim.truth import read_truth

    truth = read_truth(request.object_file)
    arm, gripper, still = simulated_at_rest(request.revision, request.vision)
    find_grasp(gripper, free_space(arm, truth.declared, still.q), truth.declared, still.q)  # or it is refused
    noise = _noise(request.noise)
    robot = MujocoRobot(truth, noise, request.seed, request.fidelity, request.revision, request.vision)
    classes = {MATERIAL: truth.material, CATEGORY: truth.category}
    return OpenedRobot(
        robot,
        _told(truth),
        senses=lambda network: drawn_senses(network, classes, request.seed),
        show=robot.show,
    )


def _noise(name: str) -> SensorModel:
    """Return the errors of simulated sensors by name or file."""
    from sim.sensors import SensorModel

    if name == "default":
        return SensorModel()
    if name == "none":
        return SensorModel.none()
    if name.endswith(".toml") or "/" in name:
        return SensorModel.from_file(Path(name))
    raise InvalidInput("--noise", name, f"{', '.join(NOISE_NAMES)}, or a TOML file")


def _told(truth: TrueObject) -> Truth:
    return Truth(
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


@dataclass(frozen=True)
class BenchRequest:
    """Which bench is wanted, with what on it.

    Attributes:
        object_file: the object.
        plates: ``pads`` or ``full``.
        setting: ``accurate``, or ``fast`` with a coarser time step.
        fidelity: ``uniform``, or ``indentation`` for an object that pads sink into.
        noise: as of a robot.
        seed: of the sensors' errors.
    """

    object_file: Path
    plates: Plates = "pads"
    setting: Literal["accurate", "fast"] = "accurate"
    fidelity: Literal["uniform", "indentation"] = "uniform"
    noise: str = "none"
    seed: int = 0


@dataclass(frozen=True)
class OpenedBench:
    """A bench with an object on it.

    Attributes:
        bench: squeezes.
        truth: apart from it, what the object really is.
        rigid: whether it is simulated as a rigid body, of which only the contact gives way.
    """

    bench: SqueezeBench
    truth: Truth
    rigid: bool


def open_bench(request: BenchRequest) -> OpenedBench:
    """Open the simulated bench.

    Raises:
        InvalidInput: if the object or the noise cannot be used.
    """
    from sim.bench import Bench
    from sim.truth import read_truth

    truth = read_truth(request.object_file)
    noise = _noise(request.noise)
    bench = Bench(truth, request.plates, request.setting, request.fidelity, noise, request.seed)
    return OpenedBench(bench, _told(truth), truth.is_rigid)


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
