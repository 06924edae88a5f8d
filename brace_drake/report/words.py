"""Numbers and names as a reader wants them."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from brace_drake.effects.registry import choice_words
from brace_drake.recording.columns import split_unit

NOTHING = "–"
TIMES_FLOOR = "× floor"

_MINUS = "−"
_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")

# Floors up to which a gap before is the floor itself.
_AT_FLOOR = 1.1

# Unit: (least magnitude, factor, unit to show), largest first.
_SCALES = {
    "m": ((1.0, 1.0, "m"), (1e-4, 1e3, "mm"), (0.0, 1e6, "µm")),
    "s": ((0.1, 1.0, "s"), (1e-4, 1e3, "ms"), (0.0, 1e6, "µs")),
}


def to_number(value: float | None) -> float:
    """A float; NaN for None, which stands for what is not finite."""
    return math.nan if value is None else float(value)


def to_text(value: object) -> str:
    """A value as one line: numbers short, everything else as it prints."""
    if value is None:
        return NOTHING
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return significant(value, 6)
    if isinstance(value, list | tuple):
        return ", ".join(to_text(v) for v in value) or NOTHING
    return str(value)


def significant(value: float | None, digits: int, padded: bool = False) -> str:
    """A number to so many significant digits.

    Args:
        value: The number.
        digits: How many.
        padded: Whether zeros at the end are kept, as for a measured value.
    """
    number = to_number(value)
    if not math.isfinite(number):
        return _not_finite(number)
    text = f"{number:.{digits}g}"
    if number == 0.0 or 1e-4 <= abs(number) < 1e6:
        # Digits before the point are shown even where they are not counted.
        exponent = math.floor(math.log10(abs(float(text)))) if number else 0
        decimals = max(0, digits - 1 - exponent)
        text = f"{number:.{decimals}f}"
        if not padded and "." in text:
            text = text.rstrip("0").rstrip(".")
    if "e" not in text:
        return text.replace("-", _MINUS)
    mantissa, tens = text.split("e")
    power = str(int(tens)).translate(_SUPERSCRIPTS)
    return f"{mantissa.replace('-', _MINUS)}·10{power}"


def fixed(value: float | None, decimals: int) -> str:
    """A number to so many decimals; powers of ten where it would be long."""
    number = to_number(value)
    if not math.isfinite(number):
        return _not_finite(number)
    if decimals > 6 or abs(number) >= 1e7:
        return significant(number, 4)
    text = f"{number:.{decimals}f}"
    if float(text) == 0.0:
        text = text.lstrip("-")
    return text.replace("-", _MINUS)


def _not_finite(number: float) -> str:
    if math.isnan(number):
        return NOTHING
    return "∞" if number > 0.0 else f"{_MINUS}∞"


def percent(value: float | None) -> str:
    """A share as a percentage; one decimal near 0 and 100."""
    number = 100.0 * to_number(value)
    near_end = 0.0 < abs(number) < 1.0 or 99.0 < abs(number) < 100.0
    text = fixed(number, 1 if near_end else 0)
    if text == "100.0":
        text = "> 99.9"
    return text if text == NOTHING else f"{text} %"


def percent_interval(
    middle: float | None, low: float | None, high: float | None
) -> tuple[str, str]:
    """A share and its interval as percentages, with digits that match; more
    than all is noise, and is told as all.
    """
    shares = [100.0 * min(to_number(v), 1.0) for v in (middle, low, high)]
    if shares[1] >= 100.0:
        return "100 %", ""
    width = shares[2] - shares[1]
    if not math.isfinite(width):
        return percent(middle), ""
    decimals = 0 if width >= 5.0 else 1 if width >= 0.5 else 2
    share, *ends = (fixed(v, decimals) for v in shares)
    if ends[0] == ends[1]:
        interval = f"within 0.01 % of {ends[0]} %"
    else:
        interval = f"{ends[0]} to {ends[1]} %"
    return (share if share == NOTHING else f"{share} %"), interval


def times(value: float | None) -> str:
    """A multiple of the floor."""
    number = to_number(value)
    if not math.isfinite(number):
        return _not_finite(number)
    return fixed(number, 2 if abs(number) < 9.995 else 1)


def bar_width(share: float | None) -> float:
    """A share as the width of a bar, %, within 0 to 100."""
    value = to_number(share)
    return 0.0 if math.isnan(value) else round(100 * min(max(value, 0), 1), 1)


def decimals_for(error: float, value: float) -> int:
    """Decimals that show two digits of the error, four of the value else."""
    if math.isfinite(error) and error > 0.0:
        return max(0, 1 - math.floor(math.log10(error)))
    if math.isfinite(value) and value != 0.0:
        return max(0, 3 - math.floor(math.log10(abs(value))))
    return 2


def scale_of(unit: str, values: Sequence[float]) -> tuple[float, str]:
    """Factor and unit that suit the largest of the values."""
    sizes = [abs(v) for v in values if math.isfinite(v)]
    largest = max(sizes, default=0.0)
    for least, factor, shown in _SCALES.get(unit, ()):
        if largest >= least > 0.0:
            return factor, shown
    if largest == 0.0:
        return 1.0, unit_text(unit)
    return _SCALES.get(unit, ((0.0, 1.0, unit_text(unit)),))[-1][1:]


def unit_text(unit: str) -> str:
    """A unit as printed: m_s2 becomes m/s²."""
    known = {"1": "", "m_s": "m/s", "m_s2": "m/s²", "m/s2": "m/s²", "um": "µm"}
    return known.get(unit, unit)


def channel_text(name: str) -> str:
    """A column's name as printed: leg3_length_m becomes Leg 3 length."""
    quantity = split_unit(name)[0]
    words = re.sub(r"^(ring|leg)(\d+)_", r"\1 \2 ", quantity)
    words = words.replace("_", " ").strip()
    return words[:1].upper() + words[1:]


def floor_text(channel: dict) -> str:
    """The noise floor of a channel in a unit that suits it."""
    factor, unit = scale_of(channel["unit"], [channel["floor"]])
    return f"{significant(channel['floor'] * factor, 2, padded=True)} {unit}"


def over_floor(excess: float | None) -> str:
    """A mean square above the floor's as a multiple of the floor."""
    square = 1.0 + to_number(excess)
    return times(math.sqrt(square) if square >= 0.0 else math.nan)


def band_text(band: dict) -> str:
    """Limits of a frequency band."""
    low, high = (significant(band[k], 3) for k in ("from_Hz", "to_Hz"))
    return f"{low} to {high} Hz"


def parameter_text(name: str, unit: str) -> str:
    """A parameter's name without its unit: coulomb_N becomes coulomb."""
    written = unit.translate(str.maketrans("²³", "23"))
    suffix = "_" + re.sub(r"[ /*·^]+", "_", written)
    if unit and name.endswith(suffix):
        name = name[: -len(suffix)]
    return name.replace("_", " ")


def parameter_row(parameter: dict) -> dict:
    """Value, error and interval of a parameter to the digits they deserve."""
    keys = ("value", "standard_error", "lower95", "upper95", "nominal")
    found = {key: to_number(parameter.get(key)) for key in keys}
    unit = parameter["unit"]
    words = choice_words(parameter["name"], found["value"])
    factor, shown = scale_of(unit, [found["value"], found["nominal"]])
    ratio = math.nan
    if found["nominal"] != 0.0:
        ratio = found["value"] / found["nominal"]
    found = {key: value * factor for key, value in found.items()}
    decimals = decimals_for(found["standard_error"], found["value"])
    low, high = (fixed(found[k], decimals) for k in ("lower95", "upper95"))
    return {
        "name": "" if words else parameter_text(parameter["name"], unit),
        "column": parameter["name"],
        "unit": shown,
        "value": words or fixed(found["value"], decimals),
        "error": significant(found["standard_error"], 2, padded=True),
        "interval": NOTHING if NOTHING in (low, high) else f"{low} to {high}",
        "nominal": significant(found["nominal"], 4),
        "ratio": times(ratio),
        "at_limit": parameter["at_limit"],
    }


def error_row(label: str, unit: str, row: dict) -> dict:
    """Before, after and floor of an error that has a unit."""
    found = [to_number(row[key]) for key in ("before", "after", "floor")]
    factor, shown = scale_of(unit, found)
    least = min((abs(v) for v in found if v), default=0.0)
    known = found[2] if found[2] > 0.0 else least
    decimals = decimals_for(known * factor, math.nan)
    if unit == TIMES_FLOOR:
        decimals = 2
    before, after, floor = (fixed(v * factor, decimals) for v in found)
    # Of a channel that was at its floor there is nothing to close.
    is_open = not found[0] <= _AT_FLOOR * found[2]
    closed = row.get("closed") if is_open else None
    # Less than the floor is chance: no more than all can be closed.
    closed = None if closed is None else min(closed, 1.0)
    interval = ""
    if row["after_interval"]:
        ends = (to_number(v) * factor for v in row["after_interval"])
        interval = " to ".join(fixed(end, decimals) for end in ends)
    return {
        "label": label,
        "unit": shown,
        "before": before,
        "after": after,
        "interval": interval,
        "floor": floor,
        "closed": percent(closed),
        "share": closed,
    }
