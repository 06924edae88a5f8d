"""Rows of the report's tables, every cell as the reader sees it."""

from __future__ import annotations

import math
from collections.abc import Sequence

from brace_drake.effects.registry import choice_words
from brace_drake.report.access import bar_width, items, names, part, rows, text
from brace_drake.report.words import (
    NOTHING,
    channel_text,
    decimals_for,
    fixed,
    parameter_text,
    percent,
    percent_interval,
    scale_of,
    significant,
    times,
    to_number,
    to_text,
)

# Floors up to which a gap before is the floor itself.
_AT_FLOOR = 1.1


def parameter_row(parameter: dict) -> dict:
    """Value, error and interval of a parameter to the digits they deserve."""
    keys = ("value", "standard_error", "lower95", "upper95", "nominal")
    found = {key: to_number(parameter.get(key)) for key in keys}
    unit, words = text(parameter, "unit"), None
    if math.isfinite(found["value"]):
        words = choice_words(text(parameter, "name"), found["value"])
    factor, shown = scale_of(unit, [found["value"], found["nominal"]])
    found = {key: value * factor for key, value in found.items()}
    error = found["standard_error"]
    if not math.isfinite(error):
        error = (found["upper95"] - found["lower95"]) / 4.0
    decimals = decimals_for(error, found["value"])
    low = fixed(found["lower95"], decimals)
    high = fixed(found["upper95"], decimals)
    known = NOTHING not in (low, high)
    name = parameter_text(text(parameter, "name"), unit) or NOTHING
    return {
        "name": name if words is None else "",
        "column": text(parameter, "name"),
        "unit": shown,
        "value": words or fixed(found["value"], decimals),
        "error": significant(found["standard_error"], 2, padded=True),
        "interval": f"{low} to {high}" if known else NOTHING,
        "nominal": significant(found["nominal"], 4),
        "ratio": times(_ratio(found["value"], found["nominal"])),
        "at_limit": bool(parameter.get("at_limit")),
    }


def _ratio(value: float, nominal: float) -> float:
    return value / nominal if nominal != 0.0 else math.nan


def _validation(told: dict) -> dict:
    """What a cause leaves on validation runs, and between which values."""
    low, high = times(told.get("lower95")), times(told.get("upper95"))
    interval = "" if NOTHING in (low, high) else f"{low} to {high}"
    return {"gap": times(told.get("gap")), "interval": interval}


def _in_floors(excess: object) -> str:
    """A mean square above the floor's as a multiple of the floor."""
    square = 1.0 + to_number(excess)
    return times(math.sqrt(square) if square >= 0.0 else math.nan)


def _decoys(told: dict) -> dict | None:
    """Shares of the gap's squares that a cause and its best decoy take."""
    if not told:
        return None
    taken, best = (to_number(told.get(k)) for k in ("taken", "best_decoy"))
    return {"taken": percent(max(0.0, taken)), "best": percent(best)}


def cause_row(cause: dict, verdict: dict) -> dict:
    """One candidate of the ranking."""
    effect = text(cause, "effect") or NOTHING
    return {
        "effect": effect,
        "title": text(cause, "title"),
        "block": text(cause, "block"),
        "explained": percent(cause.get("explained")),
        "width": bar_width(cause.get("explained")),
        "held_out": _in_floors(cause.get("held_out")),
        "decoys": _decoys(part(cause, "decoys")),
        "validation": _validation(part(cause, "validation")),
        "parameters": [parameter_row(p) for p in rows(cause, "parameters")],
        "decision": text(cause, "decision"),
        "chosen": is_chosen(cause, verdict),
        "ambiguous": effect in names(verdict, "ambiguous_with"),
        "unconverged": cause.get("converged") is False,
        "unidentifiable": cause.get("identifiable") is False,
    }


def left_row(row: dict) -> dict:
    """What is left in one channel, and the motion that it goes with."""
    share, interval = percent_interval(
        *(row.get(k) for k in ("takes", "lower95", "upper95"))
    )
    shape = text(row, "shape")
    return {
        "channel": channel_text(text(row, "channel")) or NOTHING,
        "rms": times(row.get("normalised_rms")),
        "share": percent(row.get("share_of_rest")),
        "width": bar_width(row.get("share_of_rest")),
        "shape": shape,
        "acts_like": text(row, "acts_like"),
        "takes": share if shape else NOTHING,
        "interval": interval or NOTHING,
    }


def is_searched(cause: dict) -> bool:
    """Whether a candidate was searched, not only replayed once."""
    return cause.get("searched") is not False


def is_chosen(cause: dict, verdict: dict) -> bool:
    """Whether a candidate, of one or more effects, is the verdict itself.

    Of several forms of an effect the document says which one it is.
    """
    said = cause.get("chosen")
    if isinstance(said, bool):
        return said
    chosen = set(names(verdict, "effects"))
    found = {name_of(p) for p in parts_of(text(cause, "effect"))}
    return bool(chosen) and found == chosen


def parts_of(effect: str) -> list[str]:
    """Single effects of a candidate such as viscous_leg+force_scale."""
    return [name.strip() for name in effect.split("+") if name.strip()]


def name_of(key: str) -> str:
    """Name of an effect that may be told with its form: backlash (gap)."""
    return key.partition(" (")[0]


def block_row(block: dict) -> dict:
    """One block of the gap's budget."""
    ends = [text(block, key) for key in ("input", "output")]
    return {
        "block": text(block, "block") or NOTHING,
        "ends": " → ".join(end for end in ends if end) or NOTHING,
        "rms": times(block.get("normalised_rms")),
        "threshold": times(block.get("threshold")),
        "share": percent(block.get("share")),
        "width": bar_width(block.get("share")),
        "acquitted": bool(block.get("acquitted")),
    }


def attribution_row(row: dict) -> dict:
    """One block's share of the closed-loop gap."""
    share, interval = percent_interval(
        *(row.get(k) for k in ("share", "lower95", "upper95"))
    )
    return {
        "block": text(row, "block") or NOTHING,
        "share": share,
        "interval": interval or NOTHING,
        "alone": percent(row.get("alone")),
        "others": names(row, "or"),
    }


def balance_row(row: dict) -> dict:
    """How much of the imbalance of the legs a block's errors take."""
    return {
        "block": text(row, "block") or NOTHING,
        "explained": percent(row.get("explained")),
        "errors": [_error(e) for e in rows(row, "errors")],
    }


def _error(error: dict) -> str:
    size, unit = significant(error.get("size"), 3), text(error, "unit")
    shown = size if unit == "1" else f"{size} {unit}"
    title = text(error, "title") or NOTHING
    return f"{title.replace('-', '−')}: {shown}"


def gap_row(label: str, row: dict) -> dict:
    """Before and after of a channel, phase or band, over the floor."""
    return {
        "label": label,
        "before": times(row.get("before")),
        "after": times(row.get("after")),
        "share": percent(row.get("share")),
        "width": bar_width(row.get("share")),
    }


def channel_row(row: dict) -> dict:
    """One channel on the fit runs, with its floor in the channel's unit."""
    floor = to_number(row.get("floor"))
    factor, unit = scale_of(text(row, "unit"), [floor])
    shown = significant(floor * factor, 2, padded=True)
    return {
        **gap_row(channel_text(text(row, "channel")) or NOTHING, row),
        "column": text(row, "channel"),
        "floor": shown if shown == NOTHING else f"{shown} {unit}",
    }


def band_text(band: dict) -> str:
    """Limits of a frequency band."""
    low, high = (significant(band.get(k), 3) for k in ("from_Hz", "to_Hz"))
    return f"{low} to {high} Hz"


def error_row(label: str, unit: str, row: dict, column: str = "") -> dict:
    """Before, after and floor of an error that has a unit."""
    keys = ("before", "after", "floor")
    found = [to_number(row.get(key)) for key in keys]
    factor, shown = scale_of(unit, found)
    least = min((abs(v) for v in found if v), default=0.0)
    known = found[2] if found[2] > 0.0 else least
    decimals = decimals_for(known * factor, math.nan)
    before, after, floor = (fixed(v * factor, decimals) for v in found)
    # Of a channel that was at its floor there is nothing to close.
    is_open = not found[0] <= _AT_FLOOR * found[2]
    closed = row.get("closed") if is_open else None
    ends = [to_number(v) * factor for v in items(row, "after_interval")]
    interval = ""
    if len(ends) == 2 and all(map(math.isfinite, ends)):
        low, high = (fixed(v, decimals) for v in ends)
        interval = f"{low} to {high}"
    return {
        "label": label,
        "column": column,
        "unit": shown,
        "before": before,
        "after": after,
        "interval": interval,
        "floor": floor,
        "closed": percent(closed),
        "width": bar_width(closed),
    }


def shrink_rows(shrink: dict) -> list[dict]:
    """The channels of the validation runs.

    A floor of exactly 1 in every channel says that the numbers are multiples
    of the floor; they are then shown without the channel's unit.
    """
    channels = rows(shrink, "channels")
    normalised = all(to_number(row.get("floor")) == 1.0 for row in channels)
    return [
        error_row(
            channel_text(text(row, "channel")) or NOTHING,
            "× floor" if normalised else text(row, "unit"),
            row,
            text(row, "channel"),
        )
        for row in channels
    ]


def therapist_rows(shrink: dict) -> list[dict]:
    """The errors of what a therapist sets and watches."""
    known = (
        ("force_error_N", "Force on the torso", "N"),
        ("ring_error_mm", "Position of the ring", "mm"),
    )
    return [
        error_row(label, unit, part(shrink, key))
        for key, label, unit in known
        if part(shrink, key)
    ]


def receipt_rows(receipt: dict, prefix: str = "") -> Sequence[tuple[str, str]]:
    """The receipt as pairs of name and value, nested names with a dot."""
    pairs: list[tuple[str, str]] = []
    for key, value in receipt.items():
        if isinstance(value, dict):
            pairs += receipt_rows(value, f"{prefix}{key}.")
        else:
            pairs.append((f"{prefix}{key}", to_text(value)))
    return pairs
