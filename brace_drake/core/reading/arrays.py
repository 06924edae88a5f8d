"""Arrays of numpy's files: numbers and text, no larger than they say."""

from __future__ import annotations

import io
import math
import zipfile
from pathlib import Path

import numpy as np

from brace_drake.core.errors import ReadError, quoted
from brace_drake.core.reading.files import ReadBytes

LARGEST_MB = 64
MOST_ARRAYS = 100
_KINDS = "fiubU"


def ReadArrays(path: str | Path) -> dict[str, np.ndarray]:
    """The arrays of a *.npz by name.

    Raises:
        ReadError: One line, without the file's name.
    """
    data = ReadBytes(path, LARGEST_MB)
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            return _read(archive)
    except ReadError:
        raise
    # Zip files and their decoders may raise any exception.
    except Exception as problem:
        raise ReadError("no file of arrays") from problem


def ReadArray(path: str | Path) -> np.ndarray:
    """The array of a *.npy; it may have fields of numbers and words.

    Raises:
        ReadError: One line, without the file's name.
    """
    data = ReadBytes(path, LARGEST_MB)
    try:
        return _parse(data, Path(path).name, may_have_fields=True)
    except ReadError:
        raise
    # On a damaged header numpy may raise any exception.
    except Exception as problem:
        raise ReadError("no array of numpy") from problem


def _read(archive: zipfile.ZipFile) -> dict[str, np.ndarray]:
    members = archive.infolist()
    if len(members) > MOST_ARRAYS:
        raise ReadError(f"holds {len(members)} arrays")
    arrays: dict[str, np.ndarray] = {}
    left = LARGEST_MB * 1_000_000
    for member in members:
        name = member.filename.removesuffix(".npy")
        if name in arrays:
            raise ReadError(f"array {quoted(name)} is there twice")
        with archive.open(member) as file:
            # Sizes that a file states of itself are not believed.
            data = file.read(left + 1)
        left -= len(data)
        if left < 0:
            raise ReadError(f"holds more than {LARGEST_MB} MB")
        arrays[name] = _parse(data, name)
    return arrays


def _parse(data: bytes, name: str, may_have_fields: bool = False) -> np.ndarray:
    stream = io.BytesIO(data)
    version = np.lib.format.read_magic(stream)
    read = {
        (1, 0): np.lib.format.read_array_header_1_0,
        (2, 0): np.lib.format.read_array_header_2_0,
    }[version]
    shape, by_columns, dtype = read(stream)
    size = math.prod(shape) * dtype.itemsize
    fields = [dtype]
    if may_have_fields and dtype.names is not None:
        fields = [dtype[field] for field in dtype.names]
    if any(field.kind not in _KINDS for field in fields):
        raise ReadError(
            f"array {quoted(name)} is of {dtype}; allowed: numbers or words"
        )
    if size != len(data) - stream.tell():
        raise ReadError(f"array {quoted(name)} is not as long as it says")
    flat = np.frombuffer(data, dtype, offset=stream.tell())
    return flat.reshape(shape, order="F" if by_columns else "C").copy()
