"""Cells of a table as numbers: nothing else passes for one, or for a gap.

Whatever stands in a cell of text, Excel or JSON becomes a number here. What is
none is kept as a word with its row, and whoever uses the column refuses it;
columns that nobody uses may hold what they like.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from brace_drake.core.errors import quoted
from brace_drake.recording.importing.formats.flatten import check_room

ALLOWED = "numbers, and where one is missing nothing, NaN or NA"
# In any case of letters.
_MISSING = {"", "nan", "na", "n/a", "#n/a", "null", "none"}


class Word(NamedTuple):
    """A cell that holds something but a number.

    Attributes:
        row: Of the data, from 1.
        shown: What it holds, in words.
    """

    row: int
    shown: str


class Table(dict[str, np.ndarray]):
    """Columns by name, each (N,): those with a number, NaN where there is none.

    Attributes:
        words: Of each column that holds something else, the first.
        advice: What helps where columns are not found; empty without any.
    """

    def __init__(
        self,
        columns: Mapping[str, np.ndarray],
        words: Mapping[str, Word] | None = None,
        advice: str = "",
    ) -> None:
        super().__init__(columns)
        self.words = dict(words or getattr(columns, "words", {}))
        self.advice = advice


class Column:
    """A column that grows cell by cell."""

    def __init__(self) -> None:
        self.word: Word | None = None
        self._values = array("d")

    def add(self, cell: object) -> None:
        """Takes the next cell; None is an empty one."""
        number = number_of(cell)
        if number is None and self.word is None:
            self.word = Word(len(self._values) + 1, shown(cell))
        self._values.append(math.nan if number is None else number)

    def extend(self, cells: list) -> None:
        """Takes the next cells."""
        if set(map(type, cells)) <= {int, float}:
            self._values.extend(cells)
            return
        for cell in cells:
            self.add(cell)

    def fill(self, count: int) -> None:
        """Adds empty cells until there are so many."""
        more = count - len(self._values)
        if more > 0:
            self._values.extend([math.nan] * more)

    def values(self) -> np.ndarray:
        """Its numbers (N,), NaN where there is none."""
        return np.array(self._values)


class Samples:
    """Columns that grow by samples, which need not have all of them."""

    def __init__(self) -> None:
        self._count = 0
        self._columns: dict[str, Column] = {}

    def add(self, sample: Mapping[str, object]) -> None:
        """Takes a sample's cells by column.

        Raises:
            ReadError: There are more than memory is meant for.
        """
        for name, cell in sample.items():
            column = self._columns.get(name)
            if column is None:
                column = self._columns[name] = Column()
            column.fill(self._count)
            column.add(cell)
        self._count += 1
        check_room(self.size)

    @property
    def size(self) -> int:
        """Cells of the table that they make, empty ones included."""
        return self._count * len(self._columns)

    def table(self) -> Table:
        """What was added."""
        for column in self._columns.values():
            column.fill(self._count)
        return make_table(self._columns)


def make_table(columns: Mapping[str, Column]) -> Table:
    """Those that hold a number at all, and the words of each."""
    every = {name: column.values() for name, column in columns.items()}
    numbers = {n: v for n, v in every.items() if not np.isnan(v).all()}
    words = {n: c.word for n, c in columns.items() if c.word is not None}
    return Table(numbers, words)


def number_of(cell: object) -> float | None:
    """A cell's number, NaN of an empty one, None where it holds another thing.

    True and false are no numbers, nor is a text of digits where a format tells
    the two apart.
    """
    if isinstance(cell, int | float) and not isinstance(cell, bool):
        return float(cell)
    if cell is None or (isinstance(cell, str) and is_missing(cell)):
        return math.nan
    return None


def is_missing(text: str) -> bool:
    """Whether a text is a usual one for no value."""
    return text.strip().lower() in _MISSING


def shown(cell: object) -> str:
    """What a cell without a number holds, in words."""
    if isinstance(cell, str):
        return f"the text {quoted(cell[:200])}"
    if isinstance(cell, bool):
        return str(cell).upper()
    if isinstance(cell, list | dict):
        return "a list" if isinstance(cell, list) else "a map"
    return quoted(cell)
