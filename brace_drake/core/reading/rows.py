"""Rows of fields as numbers; time and memory grow with the text alone."""

from __future__ import annotations

import math
from array import array
from collections.abc import Iterable
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from brace_drake.core.errors import ReadError
from brace_drake.core.reading.files import LARGEST, most_bytes
from brace_drake.core.reading.text import decode

NUMBER, EMPTY, WORD = range(3)
_MOST_ROWS = 5_000_000  # An hour at 1 kHz has 3.6 million.
_LONGEST = 200  # characters that are kept of a word


class Rows(NamedTuple):
    """What rows hold; where that is no number, NaN stands in.

    Attributes:
        values: Numbers (N, width).
        kinds: NUMBER, EMPTY or WORD of each (N, width).
        widths: Fields that each row has (N,).
        first: What is no number, of each column where there is such, the first.
    """

    values: np.ndarray
    kinds: np.ndarray
    widths: np.ndarray
    first: dict[int, str]


def decode_lines(data: bytes) -> str:
    """Text with plain line ends, and not too many.

    Raises:
        ReadError: It is no text; the message says why.
    """
    if b"\0" in data:
        raise ReadError("not a text file (it holds null bytes)")
    text = decode(data).replace("\r\n", "\n").replace("\r", "\n")
    if text.count("\n") > _MOST_ROWS:
        raise ReadError(f"has more than {_MOST_ROWS} rows")
    return text


def read_rows(
    rows: Iterable[list[str]],
    width: int,
    decimal: str = ".",
) -> Rows:
    """Takes rows apart; one of another width is NaN throughout.

    Args:
        rows: Their fields.
        width: Fields that a row is to have.
        decimal: What stands before decimals.

    Raises:
        ReadError: There are more fields than memory is meant for.
    """
    most = most_bytes(LARGEST) // 4
    values, widths = array("d"), array("l")
    kinds = bytearray()
    first: dict[int, str] = {}
    lost, numbers = [math.nan] * width, bytes(width)
    for fields in rows:
        if len(values) + width > most:
            raise ReadError(f"has more than {most} fields")
        widths.append(len(fields))
        if len(fields) != width:
            values.extend(lost)
            kinds += numbers
            continue
        fields = with_points(fields, decimal)
        row = _all_numbers(fields)
        if row is not None:
            values.extend(row)
            kinds += numbers
            continue
        found = [
            (_kept if len(field) < _LONGEST else _number)(field)
            for field in fields
        ]
        values.extend([value for value, _ in found])
        kinds += bytes([kind for _, kind in found])
        for column, (_, kind) in enumerate(found):
            if kind != NUMBER and column not in first:
                first[column] = fields[column].strip()[:_LONGEST]
    shape = len(widths), width
    return Rows(
        np.frombuffer(values, float).reshape(shape),
        np.frombuffer(kinds, np.uint8).reshape(shape),
        np.array(widths, int),
        first,
    )


def with_points(fields: list[str], decimal: str) -> list[str]:
    """Fields with a point for their decimal sign. Where that is another one a
    point is none: of thousands, or a mistake.
    """
    if decimal == ".":
        return fields
    return [f.replace(".", "_").replace(decimal, ".") for f in fields]


def is_number(field: str) -> bool:
    """Whether a field holds a number."""
    return _number(field)[1] == NUMBER


def _all_numbers(fields: list[str]) -> list[float] | None:
    try:
        row = list(map(float, fields))
    except ValueError:
        return None
    return None if any("_" in field for field in fields) else row


def _number(field: str) -> tuple[float, int]:
    try:
        # Python takes 1_0 for 10.
        if "_" not in field:
            return float(field), NUMBER
    except ValueError:
        pass
    return math.nan, WORD if field.strip() else EMPTY


_kept = lru_cache(1024)(_number)
