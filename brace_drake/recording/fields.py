"""Fields of YAML files: what is declared of each, and what a file says."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from datetime import datetime
from typing import Any, NamedTuple

from brace_drake.core.errors import is_plain
from brace_drake.core.reading import HUGE


class Field(NamedTuple):
    """A field's declaration.

    Attributes:
        wanted: What it must be, in words.
        accepts: Whether a value is that.
        required: Whether it must be there.
    """

    wanted: str
    accepts: Callable[[Any], bool]
    required: bool = True


class Fault(NamedTuple):
    """A field whose value is not what was declared; None: it is not there."""

    name: str
    wanted: str
    value: object


def number_from(low: float, high: float, required: bool = True) -> Field:
    """A number between two; true and false are none."""
    return Field(
        f"a {'positive ' * (low > 0.0)}number from {low:g} to {high:g}",
        lambda v: type(v) in (int, float) and low <= v <= high,
        required,
    )


POSITIVE = number_from(1 / HUGE, HUGE)
NOT_NEGATIVE = number_from(0.0, HUGE)
RATE = number_from(1e-3, 1e6)
DURATION = number_from(0.0, 1e6, required=False)
TEXT = Field(
    "text on one line",
    lambda v: isinstance(v, str) and v != "" and is_plain(v),
    required=False,
)


def _tells_when(value: Any) -> bool:
    if type(value) not in (str, int):
        return False
    try:
        datetime.fromisoformat(str(value).strip())
    except ValueError:
        return False
    return True


def _is_flat(value: Any) -> bool:
    """Whether a map has texts and numbers alone."""
    return isinstance(value, dict) and all(
        isinstance(key, str) and isinstance(item, str | int | float)
        for key, item in value.items()
    )


# A device that is recorded by the package tells there what it is.
RECORDED = Field(
    "a date as in 2026-01-12 or 2026-01-12T14:30",
    lambda v: _tells_when(v) or _is_flat(v),
    required=False,
)
SPLITS = ("fit", "validation")
WHAT_FOR = Field(" or ".join(SPLITS), lambda v: v in SPLITS, required=False)
SUBJECT = Field(
    "text", lambda v: isinstance(v, str | int | float), required=False
)
SWITCH = Field("true or false", lambda v: isinstance(v, bool), required=False)


def take(
    values: Mapping, fields: Mapping[str, Field]
) -> tuple[dict[str, Any], list[Fault]]:
    """The values that are as declared, and a fault for each that is not."""
    taken, faults = {}, []
    for name, field in fields.items():
        value = values.get(name)
        if value is not None and field.accepts(value):
            taken[name] = value
        elif value is not None or field.required:
            faults.append(Fault(name, field.wanted, value))
    return taken, faults
