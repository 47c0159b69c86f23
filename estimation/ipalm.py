"""Measurements in the form the IPALM project exchanges them: a JSON list of objects with named values.

Form: thesis, section 3.3.10, Listing 2. Every value has ``mean``, ``sigma`` and ``units``; what Palpate writes is
in SI units.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass

from estimation.measurement import Measurement


@dataclass(frozen=True)
class MeasuredObject:
    """An object and what was measured of it.

    Attributes:
        name: what the object is called.
        object_id: its number in the list's owner's world, if it has one.
        measurements: in SI units, in the order they were taken.
    """

    name: str
    object_id: str | None = None
    measurements: tuple[Measurement, ...] = ()


def to_list(objects: Sequence[MeasuredObject]) -> str:
    """Return objects as an IPALM measurement list."""
    return json.dumps([_object(item) for item in objects], indent=2, allow_nan=False, ensure_ascii=False) + "\n"


def _object(item: MeasuredObject) -> dict[str, object]:
    listed: dict[str, object] = {"object_name": item.name}
    listed["measurements"] = [
        {"name": m.property, "value": {"sigma": m.sd, "mean": m.mean, "units": m.unit}} for m in item.measurements
    ]
    if item.object_id is not None:
        listed["object_id"] = item.object_id
    return listed
