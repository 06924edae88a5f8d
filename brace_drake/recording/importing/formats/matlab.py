"""Numbers of MATLAB files up to -v7, arrays held to the bytes that are there.

Version 5 files (-v6, -v7) are elements of a type, a length and that many bytes;
compressed ones (-v7) hold another element. Version 4 files are headers with
numbers behind them. (scipy's reader of version 5 believes the sizes in a file,
and a wrong one can end the process.)
"""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Iterable, Iterator
from itertools import islice

import numpy as np

from brace_drake.core.errors import ReadError, quoted
from brace_drake.core.reading.files import LARGEST, most_bytes
from brace_drake.recording.importing.formats.cells import Table, Word
from brace_drake.recording.importing.formats.flatten import check_room

_HEADER, _TAG = 128, 8
_MATRIX, _COMPRESSED = 14, 15
_STRUCT, _COMPLEX = 2, 0x0800
_NUMBERS = range(6, 16)  # classes of full matrices of numbers
_TYPES = {
    **{1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4"},
    **{7: "f4", 9: "f8", 12: "i8", 13: "u8"},
}
_TYPES_4 = ("f8", "f4", "i4", "i2", "u2", "u1")
# Elements of a matrix: flags, sizes, name, numbers; of a struct the length of
# a field's name and the names stand in the place of the numbers.
_OF_MATRIX, _OF_STRUCT = 4, 5
_MOST_SIZES, _MOST_NAMES = 32, 10_000
_COMPLEX_NUMBERS = Word(1, "complex")
_Content = np.ndarray | dict | Word | None


def read_matlab(data: bytes, group: str | None) -> Table:
    """Arrays of numbers by name; what is none is left out, or is a word where
    it holds complex ones.

    Args:
        data: The file.
        group: The struct to look in; by default the file itself.

    Raises:
        ReadError: One line.
    """
    try:
        is_old = b"\0" in data[:4]
        found = _by_name((_version_4 if is_old else _version_5)(data))
    except (struct.error, zlib.error, ValueError) as error:
        if isinstance(error, ReadError):
            raise
        raise ReadError(f"not a MATLAB file: {error}") from error
    if group is not None:
        struct_ = found.get(group)
        if not isinstance(struct_, dict):
            raise ReadError(f"no struct {quoted(group)}")
        found = struct_
    return Table(
        {n: a for n, a in found.items() if isinstance(a, np.ndarray)},
        {n: w for n, w in found.items() if isinstance(w, Word)},
    )


def is_version_7_3(data: bytes) -> bool:
    """Whether a file is one of -v7.3, which is HDF5 within."""
    is_marked = data[124:126] in (b"\0\2", b"\2\0")
    return is_marked and b"MATLAB 7.3" in data[:_HEADER]


def _by_name(variables: Iterable[tuple[str, _Content]]) -> dict[str, _Content]:
    found: dict[str, _Content] = {}
    for number, (name, content) in enumerate(variables, 1):
        _check_count(number, "variables")
        found[name] = content
    return found


def _check_count(count: int, what: str) -> None:
    if count > _MOST_NAMES:
        raise ReadError(f"has more than {_MOST_NAMES} {what}")


def _version_5(data: bytes) -> Iterator[tuple[str, _Content]]:
    order = {b"IM": "<", b"MI": ">"}.get(data[126:128])
    if order is None:
        raise ReadError("not a MATLAB file")
    left, at = most_bytes(LARGEST), _HEADER
    while at < len(data):
        kind, size = struct.unpack_from(f"{order}II", data, at)
        body = data[at + _TAG : at + _TAG + size]
        if len(body) < size:
            raise ReadError("not a MATLAB file: it is cut off")
        at += _TAG + size
        if kind == _COMPRESSED:
            packed = zlib.decompressobj()
            body = packed.decompress(body, left + 1)
            left -= len(body)
            if left < 0:
                raise ReadError("unpacks to more than memory is meant for")
            if not packed.eof:
                raise ReadError("not a MATLAB file: it is cut off")
            (kind,) = struct.unpack_from(f"{order}I", body)
            body = body[_TAG:]
        if kind == _MATRIX:
            yield _matrix(body, order)


def _elements(data: bytes, order: str) -> Iterator[tuple[int, bytes]]:
    """Type and bytes of each element; small ones lie in their tag."""
    at = 0
    while at + _TAG <= len(data):
        kind, size = struct.unpack_from(f"{order}II", data, at)
        small = kind >> 16
        start, size = (at + 4, small) if small else (at + _TAG, size)
        if size > (4 if small else len(data) - start):
            raise ReadError("not a MATLAB file: an element is cut off")
        yield kind & 0xFFFF, data[start : start + size]
        at += _TAG if small else _TAG + size + -size % 8


def _matrix(
    body: bytes, order: str, within: str | None = None
) -> tuple[str, _Content]:
    """Name and content; None where that is neither numbers nor a struct."""
    # No more of them than are read: a file can have millions.
    elements = _elements(body, order)
    parts = list(islice(elements, _OF_MATRIX))
    if len(parts) < _OF_MATRIX - 1:
        return "", None
    (flags,) = struct.unpack_from(f"{order}I", parts[0][1])
    sizes = _integers(parts[1][1], order)
    name = parts[2][1].decode("latin-1")
    kind = flags & 0xFF
    if kind == _STRUCT and within is None:
        parts += islice(elements, _OF_STRUCT - _OF_MATRIX)
        return name, _fields(parts, elements, sizes, order, name)
    if kind not in _NUMBERS or len(parts) < _OF_MATRIX:
        return name, None
    if flags & _COMPLEX:
        return name, _COMPLEX_NUMBERS
    stored = _TYPES.get(parts[3][0])
    if stored is None:
        return name, None
    flat = np.frombuffer(parts[3][1], f"{order}{stored}")
    check_room(flat.size)
    if min(sizes, default=0) < 0 or math.prod(sizes) != flat.size:
        raise ReadError(f"{quoted(name or within)} has not the size it says")
    return name, flat.reshape(sizes, order="F").astype(float).squeeze()


def _integers(data: bytes, order: str) -> tuple[int, ...]:
    if len(data) > 4 * _MOST_SIZES:
        raise ReadError(f"an array of {len(data) // 4} dimensions")
    return struct.unpack(
        f"{order}{len(data) // 4}i", data[: len(data) // 4 * 4]
    )


def _fields(
    parts: list[tuple[int, bytes]],
    elements: Iterator[tuple[int, bytes]],
    sizes: tuple[int, ...],
    order: str,
    name: str,
) -> dict[str, _Content]:
    """What a struct holds, by field; `elements` are those behind its parts."""
    if math.prod(sizes) != 1:
        raise ReadError(
            f"{quoted(name)} is an array of {math.prod(sizes)} structs;"
            " allowed: one"
        )
    if len(parts) < _OF_STRUCT:
        return {}
    length = max((1, *_integers(parts[3][1], order)[:1]))
    _check_count(len(parts[4][1]) // length, "fields")
    names = [
        parts[4][1][i : i + length].split(b"\0")[0].decode("latin-1")
        for i in range(0, len(parts[4][1]), length)
    ]
    return {
        field: _matrix(body, order, field)[1]
        for field, (_, body) in zip(names, elements, strict=False)
    }


def _version_4(data: bytes) -> Iterator[tuple[str, _Content]]:
    at = 0
    while at < len(data):
        order = (
            "<" if 0 <= struct.unpack_from("<i", data, at)[0] < 5000 else ">"
        )
        kind, rows, columns, is_complex, length = struct.unpack_from(
            f"{order}5i", data, at
        )
        at += 20
        stored, is_text = kind // 10 % 10, kind % 10
        if stored >= len(_TYPES_4) or min(kind, rows, columns, length) < 0:
            raise ReadError("not a MATLAB file")
        name = data[at : at + length].split(b"\0")[0].decode("latin-1")
        at += length
        dtype = np.dtype(f"{order}{_TYPES_4[stored]}")
        count = rows * columns
        if count * dtype.itemsize > len(data) - at:
            raise ReadError(f"{quoted(name)} has not the size it says")
        check_room(count)
        flat = np.frombuffer(data, dtype, count, at)
        at += count * dtype.itemsize * (2 if is_complex else 1)
        if is_complex:
            yield name, _COMPLEX_NUMBERS
        elif is_text:
            yield name, None
        else:
            matrix = flat.reshape((rows, columns), order="F")
            yield name, matrix.astype(float).squeeze()
