"""Fields of YAML files: what is declared of each, and what a file says."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import yaml

from brace_drake.core.errors import quoted


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


# Numbers that fit a float; true and false are none.
POSITIVE = Field(
    "a positive number",
    lambda v: type(v) in (int, float) and 0 < v <= sys.float_info.max,
)
NOT_NEGATIVE = Field(
    "a number from 0",
    lambda v: type(v) in (int, float) and 0 <= v <= sys.float_info.max,
    required=False,
)
TEXT = Field(
    "text",
    lambda v: isinstance(v, str) and v != "" and "\0" not in v,
    required=False,
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


def parse_yaml(data: bytes) -> dict:
    """The mapping that a YAML file holds.

    Raises:
        ValueError: It holds none; the message is one line.
    """
    try:
        content = yaml.safe_load(data.decode("utf-8-sig"))
    except UnicodeDecodeError as e:
        line = data[: e.start].count(b"\n") + 1
        raise ValueError(f"line {line}: not UTF-8 text") from e
    except yaml.YAMLError as e:
        mark = getattr(e, "problem_mark", None)
        place = f" in line {mark.line + 1}" if mark is not None else ""
        reason = " ".join((getattr(e, "problem", None) or str(e)).split())
        raise ValueError(f"unreadable YAML{place}: {reason}") from e
    except (ValueError, RecursionError) as e:
        # PyYAML lets these through for impossible dates and deep nesting.
        raise ValueError(f"unreadable YAML: {e}") from e
    if not isinstance(content, dict):
        raise ValueError(
            f"must hold a mapping of keys, found {quoted(content)}"
        )
    return content
