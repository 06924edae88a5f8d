"""Whether a MATLAB file holds as much as it says, before memory is taken.

Version 5 files are elements of a type, a length and that many bytes; compressed
ones hold another element. A matrix says its dimensions, and cells and structs
are made in that size before their members are read.
"""

from __future__ import annotations

import math
import struct
import zlib

from brace_drake.core.errors import ReadError
from brace_drake.core.reading.files import LARGEST, most_bytes

_HEADER, _MATRIX, _COMPRESSED = 128, 14, 15
_CELL, _STRUCT, _OBJECT = 1, 2, 3
_LEAST = 8  # bytes of an element
_DEEPEST = 20


def check_matlab(data: bytes) -> None:
    """Refuses files that unpack to much more than memory is meant for.

    Files of version 4, and what is no MATLAB file, are left to their reader,
    which takes no memory for what is not there.

    Raises:
        ReadError: One line.
    """
    order = {b"IM": "<", b"MI": ">"}.get(data[126:128])
    if order is None or data[:4].count(0):
        return
    most, at = most_bytes(LARGEST), _HEADER
    while at + _LEAST <= len(data):
        kind, size = struct.unpack_from(f"{order}II", data, at)
        body = data[at + _LEAST : at + _LEAST + size]
        if kind == _COMPRESSED:
            try:
                body = zlib.decompressobj().decompress(body, most + 1)
            except zlib.error as error:
                raise ReadError(f"not a MATLAB file: {error}") from error
            most -= len(body)
            if most < 0:
                raise ReadError("unpacks to more than memory is meant for")
            _check_matrix(body, order, 0)
        elif kind == _MATRIX:
            _check_matrix(data[at : at + _LEAST + size], order, 0)
        at += _LEAST + size


def _elements(data: bytes, order: str):
    """Type and bytes of each element, with small ones in their tag."""
    at = 0
    while at + _LEAST <= len(data):
        kind, size = struct.unpack_from(f"{order}II", data, at)
        if kind >> 16:
            yield kind & 0xFFFF, data[at + 4 : at + 4 + min(kind >> 16, 4)]
            at += _LEAST
        else:
            yield kind, data[at + _LEAST : at + _LEAST + size]
            at += _LEAST + size + -size % 8


def _check_matrix(data: bytes, order: str, depth: int) -> None:
    """Holds the dimensions of a matrix, and of those within, to its bytes."""
    if depth > _DEEPEST:
        raise ReadError(f"has more than {_DEEPEST} levels within another")
    for kind, body in _elements(data, order):
        if kind != _MATRIX:
            continue
        parts = list(_elements(body, order))
        if len(parts) < 2 or len(parts[0][1]) < 4:
            continue
        (flags,) = struct.unpack_from(f"{order}I", parts[0][1])
        count = len(parts[1][1]) // 4
        sizes = struct.unpack_from(f"{order}{count}i", parts[1][1])
        if flags & 0xFF not in (_CELL, _STRUCT, _OBJECT):
            continue
        if math.prod(sizes) > len(body) // _LEAST or min(sizes, default=0) < 0:
            raise ReadError(
                f"says that it holds {math.prod(sizes)} cells in"
                f" {len(body)} bytes"
            )
        for inner, content in parts[2:]:
            if inner == _MATRIX:
                head = struct.pack(f"{order}II", _MATRIX, len(content))
                _check_matrix(head + content, order, depth + 1)
