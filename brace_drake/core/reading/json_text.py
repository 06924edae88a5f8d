"""JSON, bounded: what is not as the standard has it is refused."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any, NoReturn

from brace_drake.core.errors import BraceError, ReadError, quoted
from brace_drake.core.reading.files import ReadBytes, in_file, most_bytes
from brace_drake.core.reading.text import decode

LARGEST_MB = 16
DEEPEST = 64
# Longer ones are no number that a measurement, a count or a time needs.
MOST_DIGITS = 18


def LoadJson(path: str | Path, error: type[BraceError]) -> Any:
    """What a JSON file holds.

    Raises:
        error: One line: the file, and what is wrong.
    """
    with in_file(path, error):
        return parse_json(ReadBytes(path, LARGEST_MB))


def parse_json(data: bytes, may_be_nan: bool = False) -> Any:
    """What JSON text holds: finite numbers, keys once, not too deep.

    Args:
        data: UTF-8 text.
        may_be_nan: Whether NaN may stand for a number.

    Raises:
        ReadError: One line.
    """
    if len(data) > most_bytes(LARGEST_MB):
        raise ReadError(f"not JSON: more than {LARGEST_MB} MB of text")
    try:
        found = (_WITH_NAN if may_be_nan else _STRICT).decode(decode(data))
    except RecursionError as error:
        raise _too_deep() from error
    except ReadError:
        raise
    except ValueError as error:
        raise ReadError(f"not JSON: {error}") from error
    level = [found]
    for _ in range(DEEPEST):
        level = [
            item
            for node in level
            if isinstance(node, dict | list)
            for item in (node.values() if isinstance(node, dict) else node)
        ]
        if not level:
            return found
    raise _too_deep()


def _too_deep() -> ReadError:
    return ReadError(f"not JSON: more than {DEEPEST} levels within another")


def _pairs(pairs: list[tuple[str, object]]) -> dict[str, object]:
    found = dict(pairs)
    if len(found) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(n for n in found if names.count(n) > 1)
        raise ReadError(f"not JSON: key {quoted(twice)} is there twice")
    return found


def _whole(text: str) -> int:
    if len(text) > MOST_DIGITS + text.startswith("-"):
        raise ReadError(f"not JSON: a whole number of {len(text)} digits")
    return int(text)


def _number(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ReadError(f"not JSON: {quoted(text)} is beyond any number")
    return value


def _refuse(text: str) -> NoReturn:
    raise ReadError(f"not JSON: {text} is no finite number")


def _nan(text: str) -> float:
    return math.nan if text == "NaN" else _refuse(text)


_STRICT, _WITH_NAN = (
    json.JSONDecoder(
        object_pairs_hook=_pairs,
        parse_int=_whole,
        parse_float=_number,
        parse_constant=constant,
    )
    for constant in (_refuse, _nan)
)
