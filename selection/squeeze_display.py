"""What squeezes on the bench told, as lines for people and as data for programs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from estimation.stiffness.cycle import RateDependence
from selection.result import versions
from selection.robots import Truth
from selection.squeezes import Squeezed, stroke_table

FELT_IMPACT = 0.01  # of the largest force, at which moduli begin to suffer without sensor noise to hide it


def impact_share(squeezed: Squeezed, truth: Truth) -> float:
    """Return what the object's inertia adds to the force at first contact, over the largest force [-].

    A plate that meets a rod with a speed v sends a wave into it, whose stress is v sqrt(E rho) (Johnson, Contact
    Mechanics, 1985, section 11.1).
    """
    true, width = truth.properties, float(np.max(squeezed.opening))
    if squeezed.estimate is not None:
        width = squeezed.estimate.onset
    stress = squeezed.stroke.speed / 2 * math.sqrt(true["elasticity"] * true["density"])
    return float(stress * true["volume"] / width / np.max(squeezed.force))


def lines(number: int, squeezed: Squeezed, truth: Truth, rigid: bool = False) -> list[str]:
    """Return what one squeeze told, its moduli next to the truth.

    Args:
        number: of the squeeze.
        squeezed: what it told.
        truth: what the object really is.
        rigid: whether it is simulated as a rigid body.
    """
    stroke = squeezed.stroke
    drive = "" if stroke.stiffness is None else f" by drives of {stroke.stiffness:g} N/m"
    told = [
        f"squeeze {number}: {1e3 * stroke.speed:g} mm/s to an opening of {1e3 * stroke.target:.3g} mm{drive}; "
        f"reached {1e3 * np.min(squeezed.opening):.3g} mm and {np.max(squeezed.force):.3g} N"
    ]
    if squeezed.note:
        told.append(f"  {squeezed.note}")
    if rigid:
        told.append("  simulated as a rigid body: what gives way is its contact with the plates")
    elif (share := impact_share(squeezed, truth)) > FELT_IMPACT:
        told.append(
            f"  the plates' impact, {100 * share:.1f} % of the largest force, is in the first readings: "
            "squeeze slower, or deeper"
        )
    true = truth.properties["elasticity"]
    for modulus in squeezed.moduli:
        sd = f"+- {modulus.sd / 1e3:.2g}" if math.isfinite(modulus.sd) else ""
        told.append(
            f"  {modulus.name:<24} {modulus.value / 1e3:9.4g} {sd:<10} kPa   true {true / 1e3:.4g} kPa, "
            f"ratio {modulus.value / true:.3f}"
        )
    if squeezed.hysteresis is not None:
        cycle = squeezed.hysteresis
        told.append(
            f"  hysteresis: {100 * cycle.loss:.2g} % of {cycle.work:.3g} J/m^3 lost, "
            f"residual strain {100 * cycle.residual_strain:.2g} %"
        )
    return told


def result_of(
    name: str, squeezes: Sequence[Squeezed], rate: RateDependence | None, truth: Truth
) -> dict[str, Any]:
    """Return what the squeezes came to, as it stands in ``result.json``.

    Args:
        name: of the object.
        squeezes: in order.
        rate: how the modulus depends on the strain rate, where that can be told.
        truth: what the object really is.
    """
    result: dict[str, Any] = {
        "object": name,
        "truth": {
            "material": truth.material,
            "properties": {
                key: {"value": value, "unit": truth.units[key]} for key, value in truth.properties.items()
            },
        },
        "squeezes": [_squeeze(squeezed, truth.properties["elasticity"]) for squeezed in squeezes],
        "versions": versions(),
    }
    if rate is not None:
        result["rate_dependence"] = {
            "modulus_pa": rate.modulus,
            "modulus_sd_pa": rate.modulus_sd,
            "reference_per_s": rate.reference,
            "exponent": rate.exponent,
            "exponent_sd": rate.exponent_sd,
        }
    return result


def _squeeze(squeezed: Squeezed, true: float) -> dict[str, Any]:
    table: dict[str, Any] = {
        "stroke": stroke_table(squeezed.stroke),
        "largest_force_n": float(np.max(squeezed.force)),
        "smallest_opening_m": float(np.min(squeezed.opening)),
        "moduli": [
            {
                "name": modulus.name,
                "value_pa": modulus.value,
                "sd_pa": modulus.sd if math.isfinite(modulus.sd) else None,
                "ratio": modulus.value / true,
            }
            for modulus in squeezed.moduli
        ],
        "note": squeezed.note,
    }
    if squeezed.estimate is not None:
        table["onset_m"] = squeezed.estimate.onset
        table["bound_pa"] = squeezed.estimate.bound
        table["strain_rate_per_s"] = squeezed.rate if math.isfinite(squeezed.rate) else None
    if squeezed.hysteresis is not None:
        table["loss"] = squeezed.hysteresis.loss
        table["residual_strain"] = squeezed.hysteresis.residual_strain
    return table
