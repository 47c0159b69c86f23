"""Names, numbers and units as a person reads them on a page."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from estimation.bounds import bound_of
from estimation.measurement import Measurement
from selection.display import DISPLAY_UNITS

LONGEST_NAME, LONGEST_UNIT, LONGEST_SLUG = 40, 12, 80
LONGEST_TEXT = 20_000
NO_BREAK = "\u00a0"
_WRITTEN = {"1": "", "kg/m^3": "kg/m³", "m^3": "m³", "cm^3": "cm³", "m^2": "m²"}
_MONTHS = (
    "January", "February", "March", "April", "May", "June",
    "July", "August", "September", "October", "November", "December",
)  # fmt: skip
_PROBABLE = 0.9995  # from here on a probability is said to be more than 99.9 %
_LARGE = {"Pa": ((1e10, "GPa", 1e-9), (1e7, "MPa", 1e-6))}
_UNFIT = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_TURNING = re.compile("[\u200e\u200f\u202a-\u202e\u2066-\u2069]")


def clean(text: object, longest: int = LONGEST_TEXT) -> str:
    """Return text of bounded length without what XML cannot hold or what turns the direction of writing."""
    fit = _TURNING.sub("", _UNFIT.sub("\ufffd", str(text)))
    return fit if len(fit) <= longest else fit[: longest - 1] + "…"


def name_of(text: object, longest: int = LONGEST_NAME) -> str:
    """Return a name on one line of bounded length."""
    return clean(" ".join(str(text).split()), longest)


def typeset(text: str) -> str:
    """Return text with the signs of print for those of a keyboard: at least, at most, plus or minus."""
    return text.replace(">=", "≥").replace("<=", "≤").replace("+-", "±")


def title_of(text: object, longest: int = LONGEST_NAME) -> str:
    """Return a name as it begins a line: with a capital letter."""
    name = name_of(text, longest)
    return name[:1].upper() + name[1:]


def slug(text: object) -> str:
    """Return a name fit for a file: small letters, digits and hyphens."""
    return re.sub(r"[^a-z0-9]+", "-", str(text).lower())[:LONGEST_SLUG].strip("-") or "unnamed"


def unit_of(unit: str, value: float = 0.0) -> tuple[str, float]:
    """Return the unit that a person would use for such a value [SI], and how many there are in one SI unit."""
    for least, name, factor in _LARGE.get(unit, ()):
        if abs(value) >= least:
            return name, factor
    name, factor = DISPLAY_UNITS.get(unit, (unit, 1.0))
    return _WRITTEN.get(name, name_of(name, LONGEST_UNIT)), factor


def labelled(quantity: str, unit: str, largest: float = 0.0) -> str:
    """Return the label of an axis that goes so far [SI unit]: quantity and unit."""
    name = unit_of(unit, largest)[0]
    return f"{title_of(quantity)} [{name or '–'}]"


def number(value: float, digits: int = 3) -> str:
    """Return a number with so many significant digits, never in the computer's notation."""
    if not math.isfinite(value):
        return "∞" if value > 0 else ("−∞" if value < 0 else "–")
    if value != 0 and not 1e-4 <= abs(value) < 1e7:
        mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
        power = str(int(exponent)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
        return f"{mantissa} × 10{power}".replace("-", "−")
    decimals = max(digits - 1 - math.floor(math.log10(abs(value))), 0) if value else 0
    return f"{value:.{decimals}f}".replace("-", "−")


def quantity(mean: float, sd: float, unit: str) -> str:
    """Return a value with its standard deviation, to two digits of the latter: ``87.5 ± 2.0 g``."""
    name, factor = unit_of(unit, mean)
    mean, sd = mean * factor, sd * factor
    if not (math.isfinite(sd) and sd > 0 and math.isfinite(mean)):
        return f"{number(mean)}{NO_BREAK}{name}".rstrip()
    decimals = min(max(1 - math.floor(math.log10(sd)), 0), 6)
    return f"{mean:.{decimals}f} ± {sd:.{decimals}f} {name}".rstrip().replace("-", "−").replace(" ", NO_BREAK)


def reading(measurement: Measurement) -> tuple[str, str]:
    """Return of what quantity a measurement is, and its value: a bound for a modulus too large to tell."""
    bound = bound_of(measurement)
    if bound is None:
        return name_of(measurement.property), quantity(measurement.mean, measurement.sd, measurement.unit)
    name, least, unit = bound
    return name, f"≥{NO_BREAK}{plain(least, unit)}"


def interval(ends: Sequence[float], unit: str) -> str:
    """Return an interval: ``84.7 to 91.1 g``."""
    name, factor = unit_of(unit, ends[1])
    return f"{number(ends[0] * factor)} to {number(ends[1] * factor)} {name}".rstrip().replace(" ", NO_BREAK)


def plain(value: float, unit: str) -> str:
    """Return one value to three digits, with its unit."""
    name, factor = unit_of(unit, value)
    return f"{number(value * factor)}{NO_BREAK}{name}".rstrip()


def percent(probability: float) -> str:
    """Return a probability, never rounded to certainty: ``94.8 %``, ``> 99.9 %``."""
    if not math.isfinite(probability):
        return "–"
    if probability >= _PROBABLE:
        return f">{NO_BREAK}99.9{NO_BREAK}%"
    if probability < 1 - _PROBABLE:
        return f"<{NO_BREAK}0.1{NO_BREAK}%"
    return f"{100 * probability:.1f}{NO_BREAK}%"


def seconds(value: float) -> str:
    """Return a duration: ``98 s``, ``12 min 5 s``."""
    if not math.isfinite(value):
        return "no limit"
    if value < 10:
        return f"{value:.1f}{NO_BREAK}s"
    whole = round(value)
    text = f"{whole} s" if whole < 180 else f"{whole // 60} min {whole % 60} s"
    return text.replace(" ", NO_BREAK)


def date(iso: str) -> str:
    """Return the day of a time of ISO 8601: ``22 November 2026``; empty if it is none."""
    found = re.match(r"(\d{4})-(\d\d)-(\d\d)", iso)
    if not found or not 1 <= int(found[2]) <= 12:
        return ""
    return f"{int(found[3])} {_MONTHS[int(found[2]) - 1]} {found[1]}".replace(" ", NO_BREAK)


def bits(value: float) -> str:
    """Return an amount of information: ``2.32 bit``."""
    return f"{signed(value)}{NO_BREAK}bit"


def signed(value: float, decimals: int = 2) -> str:
    """Return a number with so many decimals, a true minus, and no minus before zero."""
    text = f"{value:.{decimals}f}"
    return text.replace("-", "−") if float(text) else f"{0:.{decimals}f}"


def listed(parts: Sequence[str]) -> str:
    """Return parts as a sentence lists them: ``a, b and c``."""
    return ", ".join(parts[:-1]) + " and " + parts[-1] if len(parts) > 1 else "".join(parts)
