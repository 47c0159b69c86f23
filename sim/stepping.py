"""Step the simulated world: finely while pads press on an object that stands on the table.

Pads that are dragged along a light and stiff object judder, for its contact is stiffer than a time step of 2 ms
can follow: they lose up to a third of their friction, and things of a few grams are thrown about between them. At
1 ms they hardly do. A contact is as stiff at either, see `sim.contact`, so that the step may change at any time.
"""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from sim.bodies import object_bodies
from sim.contact import TIMESTEP, can_be_rubbed, contact_law
from sim.truth import TrueObject

Array = NDArray[np.float64]

FINER = 2  # fine steps in a step
_AROUND = ("left_pad", "right_pad", "table")  # geometries that all touch an object that is being rubbed


class Stepper:
    """Steps a world with one object.

    Args:
        model: the world, prepared by `sim.bodies.prepare`; its time step and its object's contact are changed.
        data: its state.
        truth: the object.

    Attributes:
        velocity_before: of all degrees of freedom before the last step, (nv,).
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, truth: TrueObject) -> None:
        self._model, self._data = model, data
        self._bodies = object_bodies(model)
        self._may_be_rubbed = can_be_rubbed(truth)
        self._around = {model.geom(name).id for name in _AROUND}
        self.velocity_before: Array = data.qvel.copy()
        if self._may_be_rubbed:
            damping_ratio = float(model.flex_solref[0, 1])
            self._laws = {step: contact_law(truth, step, damping_ratio) for step in (TIMESTEP, TIMESTEP / FINER)}
            self._inverse_weight = model.body_invweight0[self._bodies] * self._laws[TIMESTEP].shortfall

    @property
    def timestep(self) -> float:
        """Length of the last step [s]."""
        return float(self._model.opt.timestep)

    def advance(self, controls: Array) -> None:
        """Step by `TIMESTEP` with every row of controls, in finer steps where it is needed, (N, nu)."""
        model, data, control = self._model, self._data, self._data.ctrl
        fine = FINER if self._is_rubbed() else 1
        self.step_by(TIMESTEP / fine)
        for row in controls[:-1]:
            control[:] = row
            mujoco.mj_step(model, data, fine)
        control[:] = controls[-1]
        if fine > 1:
            mujoco.mj_step(model, data, fine - 1)
        self.velocity_before = data.qvel.copy()
        mujoco.mj_step(model, data)

    def _is_rubbed(self) -> bool:
        """Tell whether both pads and the table touch the object, which may be dragged along between them."""
        if not self._may_be_rubbed:
            return False
        touching = self._data.contact.geom  # (N, 2); -1 for a soft body
        soft = touching[(touching < 0).any(axis=1)]
        return self._around <= set(soft.ravel().tolist())

    def step_by(self, timestep: float) -> None:
        """Change the time step to `TIMESTEP` or a fine one [s], and with it the contact that it can follow."""
        if timestep == self.timestep:
            return
        law, model = self._laws[timestep], self._model
        model.opt.timestep = timestep
        model.flex_solref[0] = law.time_constant, law.damping_ratio
        model.flex_solimp[0, :2] = law.impedance
        model.body_invweight0[self._bodies] = self._inverse_weight / law.shortfall
