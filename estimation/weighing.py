"""The measurements of a weigh action: its marked phases become one reading of the mass."""

from __future__ import annotations

from collections.abc import Sequence

from dynamics.arm import Arm
from dynamics.errors import InvalidInput
from dynamics.signals import Phase
from estimation.measurement import Measurement
from estimation.payload import estimate_payload
from estimation.payload.estimate import PayloadEstimate
from estimation.payload.noise import JointNoise


def measure_weighing(
    arm: Arm, phases: Sequence[Phase], noise: JointNoise | None = None
) -> tuple[PayloadEstimate, tuple[Measurement, ...]]:
    """Return the payload, and the mass as a measurement, from the phases of a weigh action.

    Args:
        arm: the arm, with its gripper.
        phases: those named ``tare`` (the empty gripper held still, one a pose, before grasping and perhaps again
            after putting back) and ``hold`` (the object held still, one a pose); others are ignored.
        noise: of the torques; without it, it is estimated from the samples, and gains are as uncertain as the arm
            says.

    Returns:
        The estimate, and the measurement of ``mass`` [kg]; no measurement if the poses do not identify the mass.

    Raises:
        InvalidInput: if there is no tare or no hold, or their readings cannot be this arm's.
    """
    tare = [phase.joints() for phase in phases if phase.name == "tare"]
    load = [phase.joints() for phase in phases if phase.name == "hold"]
    if not tare or not load:
        found = f"{len(tare)} phases named tare, {len(load)} named hold"
        raise InvalidInput("weighing: phases", found, "at least one of each")
    estimate = estimate_payload(
        arm, tare, load, JointNoise(gain_sd=arm.torque_gain_sd) if noise is None else noise
    )
    return estimate, (estimate.measurement(),) if "mass" in estimate.identified else ()
