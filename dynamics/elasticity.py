"""Linear elasticity of a block by finite elements: how hard it is to press pads into two opposite faces."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from dynamics.errors import InvalidInput

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PressedBlock:
    """An eighth of a block, its three inner faces on symmetry planes, and the compliance of its pressed face.

    Eight-node bricks with 2 x 2 x 2 Gauss points (Hughes, The Finite Element Method, 1987, sections 3.5 and 3.9),
    E = 1. The block is pressed along z; one factorisation gives the compliance of the whole face, so that every
    pad on it costs a small dense solution only.

    Attributes:
        half: half extents across, along and in the pressing direction, (3,).
        cells: elements per half extent.
        compliance: displacement of the face's nodes by forces on them, (3 n, 3 n), n = (cells + 1)^2, node order
            x slowest, the displacements x, y, z of a node together. Components that symmetry fixes are 0.
    """

    half: tuple[float, float, float]
    cells: int
    compliance: Array

    @classmethod
    def of(cls, size: tuple[float, float, float], poisson: float, cells: int) -> PressedBlock:
        """Factor a block of a size (across, along, pressed) with Poisson's ratio in [0, 0.5).

        Raises:
            InvalidInput: for a size that is not positive, a Poisson's ratio out of range or no cells.
        """
        from scipy.sparse import coo_matrix
        from scipy.sparse.linalg import splu

        if not (all(math.isfinite(s) and s > 0 for s in size) and 0 <= poisson < 0.5 and cells >= 1):
            raise InvalidInput(
                "pressed block", (size, poisson, cells), "sizes > 0, Poisson's ratio in [0, 0.5), cells"
            )
        half = (size[0] / 2, size[1] / 2, size[2] / 2)
        element = _brick((half[0] / cells, half[1] / cells, half[2] / cells), poisson)
        n = cells + 1
        index = np.arange(n**3).reshape(n, n, n)
        corners = [
            index[a : a + cells, b : b + cells, c : c + cells].ravel() for a, b, c in product((0, 1), repeat=3)
        ]
        nodes = np.stack(corners, axis=1)  # (elements, 8)
        dofs = (3 * nodes[:, :, None] + np.arange(3)).reshape(len(nodes), 24)
        rows, columns = np.repeat(dofs, 24, axis=1).ravel(), np.tile(dofs, (1, 24)).ravel()
        matrix = coo_matrix((np.tile(element.ravel(), len(nodes)), (rows, columns))).tocsc()
        fixed = np.concatenate(
            [3 * index[0].ravel(), 3 * index[:, 0].ravel() + 1, 3 * index[:, :, 0].ravel() + 2]
        )  # no motion through the symmetry planes
        free = np.setdiff1d(np.arange(3 * n**3), fixed)
        position = np.full(3 * n**3, -1)
        position[free] = np.arange(len(free))
        face = (3 * index[:, :, -1].ravel()[:, None] + np.arange(3)).ravel()
        factor = splu(matrix[free][:, free], permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
        compliance = np.zeros((len(face), len(face)))
        at = position[face]
        for column in np.flatnonzero(at >= 0):
            load = np.zeros(len(free))
            load[at[column]] = 1.0
            compliance[:, column] = np.where(at >= 0, factor.solve(load)[np.maximum(at, 0)], 0.0)
        return cls(half, cells, compliance)

    def force(self, across: int, along: int, *, glued: bool) -> float:
        """Return the force on the whole block when pads move its faces together by the strain 1, E = 1.

        Args:
            across, along: cells under a quarter of the pad, 1 to ``cells``.
            glued: whether the pad holds the surface sideways, or lets it slip without friction.
        """
        n = self.cells + 1
        under = np.zeros((n, n), dtype=np.bool_)
        under[: across + 1, : along + 1] = True
        held = np.zeros((n * n, 3), dtype=np.bool_)
        held[under.ravel(), 2] = True
        if glued:
            held[under.ravel(), :2] = True
        at = np.flatnonzero(held.ravel() & (np.diag(self.compliance) > 0))
        wanted = np.where(at % 3 == 2, -self.half[2], 0.0)
        loads = np.linalg.solve(self.compliance[np.ix_(at, at)], wanted)
        return -4.0 * float(loads[at % 3 == 2].sum())


def _brick(size: tuple[float, float, float], poisson: float) -> Array:
    """Return the stiffness of a brick, E = 1, corners in the order of ``product((0, 1), repeat=3)``, (24, 24)."""
    shear = 1 / (2 * (1 + poisson))
    lame = poisson / ((1 + poisson) * (1 - 2 * poisson))
    law = np.zeros((6, 6))
    law[:3, :3] = lame
    law[np.arange(3), np.arange(3)] += 2 * shear
    law[np.arange(3, 6), np.arange(3, 6)] = shear
    corners = np.array(list(product((-1.0, 1.0), repeat=3)))
    stiffness = np.zeros((24, 24))
    for point in product((-1 / math.sqrt(3), 1 / math.sqrt(3)), repeat=3):
        factors = 1 + corners * np.array(point)
        gradient = np.empty((8, 3))
        for axis in range(3):
            others = [a for a in range(3) if a != axis]
            gradient[:, axis] = corners[:, axis] * factors[:, others].prod(axis=1) / 8 * 2 / size[axis]
        strain = np.zeros((6, 24))
        for axis in range(3):
            strain[axis, axis::3] = gradient[:, axis]
        for row, (a, b) in enumerate(((0, 1), (1, 2), (0, 2)), start=3):
            strain[row, a::3] = gradient[:, b]
            strain[row, b::3] = gradient[:, a]
        stiffness += strain.T @ law @ strain * math.prod(size) / 8
    return stiffness
