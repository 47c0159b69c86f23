"""How the real arm is driven."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from dynamics.errors import InvalidInput
from dynamics.gripper import ParallelGripper, robotiq_2f85
from hw.kortex.exchange import Timeouts
from hw.kortex.ports import TCP_PORT, UDP_PORT
from hw.preflight import TOLERANCES
from hw.safety import SafetyLimits
from hw.torque_tare import TorqueTare
from models.robot import Revision

MIN_RATE, MAX_RATE = 100.0, 1000.0  # Hz


@dataclass(frozen=True)
class KortexSettings:
    """How the arm is driven.

    Attributes:
        revision, vision: which arm it is.
        gripper: as its user knows it: calibration of its current, how its pads load an object.
        rate: readings a second [Hz], 100 to 1000.
        tcp_port, udp_port: where the arm listens.
        limits: what must not be exceeded.
        torque_tolerance: how far the torques may be from the model's in the check [N m], one a joint.
        tare: what the torque sensors read too much, and the revision they spoke for; none if None.
        dry_run: plan and validate, and move nothing.
        timeouts: of the connection.
    """

    revision: Revision = "V12"
    vision: bool = True
    gripper: ParallelGripper = field(default_factory=robotiq_2f85)
    rate: float = 200.0
    tcp_port: int = TCP_PORT
    udp_port: int = UDP_PORT
    limits: SafetyLimits = field(default_factory=SafetyLimits)
    torque_tolerance: tuple[float, ...] = TOLERANCES
    tare: TorqueTare | None = None
    dry_run: bool = False
    timeouts: Timeouts = field(default_factory=Timeouts)

    def __post_init__(self) -> None:
        if not MIN_RATE <= self.rate <= MAX_RATE:
            raise InvalidInput("kortex: rate", self.rate, f"{MIN_RATE:g} to {MAX_RATE:g} Hz")
        for name in ("tcp_port", "udp_port"):
            if not 0 < getattr(self, name) < 1 << 16:
                raise InvalidInput(f"kortex: {name}", getattr(self, name), "1 to 65535")
        tolerance = self.torque_tolerance
        if not (len(tolerance) == 7 and all(math.isfinite(value) and value > 0 for value in tolerance)):
            raise InvalidInput("kortex: torque_tolerance", tolerance, "7 numbers > 0 [N m]")
        if self.tare is not None and self.tare.revision != self.revision:
            raise InvalidInput(
                "kortex: tare", f"torques of a {self.tare.revision} arm", f"those of a {self.revision}, as assumed"
            )
