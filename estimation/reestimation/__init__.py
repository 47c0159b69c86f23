"""Recordings through the current estimators again, against what was measured and believed at the time."""

from estimation.conclude import conclude
from estimation.reestimation.again import Redone, Reestimate, reestimate
from estimation.reestimation.description import (
    Known,
    arm_named,
    describe,
    describe_bench,
    known_of,
    mesh_of,
    write_mesh,
)

__all__ = [
    "Known",
    "Redone",
    "Reestimate",
    "arm_named",
    "conclude",
    "describe",
    "describe_bench",
    "known_of",
    "mesh_of",
    "reestimate",
    "write_mesh",
]
