"""Arrays of numpy: *.npz by name, *.npy as one matrix or a structured array."""

from __future__ import annotations

from pathlib import Path

from brace_drake.core.errors import ReadError, quoted
from brace_drake.core.reading.arrays import ReadArray, ReadArrays
from brace_drake.recording.importing.formats.flatten import Arrays, as_columns

_NUMBERS = "fiub"


def read_npz(path: Path, group: str | None) -> Arrays:
    """Vectors by name, and columns of matrices: name(1) is the first.

    Raises:
        ReadError: One line.
    """
    arrays = ReadArrays(path)
    if group is not None:
        if group not in arrays:
            raise ReadError(f"no array {quoted(group)}")
        arrays = {group: arrays[group]}
    numbers = {n: a for n, a in arrays.items() if a.dtype.kind in _NUMBERS}
    return _as_floats(as_columns(numbers))


def read_npy(path: Path, group: str | None) -> Arrays:
    """Columns of a matrix by their number, "1" the first; fields of a
    structured array by name.

    Raises:
        ReadError: One line.
    """
    array = ReadArray(path)
    if array.dtype.names is not None:
        fields = {name: array[name] for name in array.dtype.names}
        numbers = {n: f for n, f in fields.items() if f.dtype.kind in _NUMBERS}
        return _as_floats(as_columns(numbers))
    if array.dtype.kind not in _NUMBERS or array.ndim != 2:
        raise ReadError(
            f"an array of {array.ndim} dimensions of {array.dtype}; allowed: a"
            " matrix of numbers, a row a sample"
        )
    columns = as_columns({"": array}).values()
    return _as_floats({str(i): c for i, c in enumerate(columns, 1)})


def _as_floats(columns: Arrays) -> Arrays:
    """Columns one by one, as floats take eight times the room of bytes."""
    return {name: columns.pop(name).astype(float) for name in list(columns)}
