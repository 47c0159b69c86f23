"""Drives and links of an arm, as calibrated: what turns a recorded motion into the torque of its payload.

    effort_j = k_j (Y(q, dq, ddq) links + Coulomb tanh(dq / v) + viscous dq + offset + rotor ddq)_j + noise

``k`` is 1 for torque sensors and the inverse drive gain [A/(N m)] for motor currents.
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from dynamics.errors import InvalidInput

Array = NDArray[np.float64]

_ARRAYS = ("inverse_gain", "model", "covariance", "noise_sd")


@dataclass(frozen=True)
class Drives:
    """A calibrated arm.

    Attributes:
        robot: name of the arm.
        effort_kind: what was measured, ``torque`` or ``current``.
        inverse_gain: effort per torque [1 or A/(N m)], (nv,).
        model: [link inertias (10 nv), Coulomb [N m], viscous [N m s/rad], offset [N m], rotor [kg m^2] (nv each)].
        covariance: of [model, inverse_gain], autocorrelation included, (15 nv, 15 nv).
        noise_sd: sd of a block's residual [N m], (nv,).
    """

    robot: str
    effort_kind: Literal["torque", "current"]
    inverse_gain: Array
    model: Array
    covariance: Array
    noise_sd: Array

    @property
    def gain(self) -> Array:
        """Torque per effort [1 or N m/A], (nv,)."""
        return 1 / self.inverse_gain

    @property
    def gain_sd(self) -> Array:
        """Standard deviation of the gains, (nv,)."""
        joints = len(self.inverse_gain)
        return np.asarray(np.sqrt(np.diag(self.covariance))[-joints:] * self.gain**2)

    def friction(self, name: str) -> Array:
        """Return one row of the drives' model: ``coulomb``, ``viscous``, ``offset`` or ``rotor``, (nv,)."""
        joints = len(self.inverse_gain)
        start = 10 * joints + ("coulomb", "viscous", "offset", "rotor").index(name) * joints
        return self.model[start : start + joints]

    def save(self, path: str | Path) -> None:
        """Write the calibration as JSON."""
        table = {k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in asdict(self).items()}
        Path(path).write_text(json.dumps(table) + "\n")

    @classmethod
    def from_file(cls, path: str | Path) -> Drives:
        """Read a calibration.

        Raises:
            InvalidInput: if the file is not a calibration.
        """
        try:
            table = json.loads(Path(path).read_text())
            arrays = [np.array(table[name], float) for name in _ARRAYS]
            drives = cls(str(table["robot"]), table["effort_kind"], *arrays)
        except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
            raise InvalidInput(
                f"calibration {path}", str(error), "a file of python -m estimation.calibrate"
            ) from None
        joints = len(drives.inverse_gain)
        fits = drives.model.shape == (14 * joints,) and drives.covariance.shape == (15 * joints, 15 * joints)
        if not fits or drives.effort_kind not in ("torque", "current"):
            raise InvalidInput(f"calibration {path}", "numbers that do not fit together", "a complete file")
        return drives
