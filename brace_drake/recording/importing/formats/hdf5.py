"""HDF5: datasets of numbers, and what MATLAB's -v7.3 makes of it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from brace_drake.core.errors import ReadError, quoted
from brace_drake.recording.importing.formats.flatten import (
    Arrays,
    as_columns,
    check_room,
)

_DEEPEST = 16
_NUMBERS = "fiub"
# MATLAB keeps what is no matrix of numbers as numbers too.
_NO_NUMBERS = (b"char", b"cell", b"function_handle")


def read_hdf5(path: Path, group: str | None) -> Arrays:
    """Vectors by name, and columns of matrices: name(1) is the first.

    Datasets within groups, or fields of a struct, are named a/b, those of the
    group that is asked for by their own names. Links to other files are left
    alone.

    Raises:
        ReadError: One line.
        ImportError: h5py is not installed.
    """
    import h5py

    with h5py.File(path, "r") as file:
        is_matlab = path.suffix.lower() == ".mat"
        root = file
        if group is not None:
            if not isinstance(_hard(file, group), h5py.Group):
                raise ReadError(f"no group {quoted(group)}")
            root = file[group]
        found: Arrays = {}
        for name, data in _datasets(root, "", _DEEPEST):
            kind = data.attrs.get("MATLAB_class", b"")
            is_kept_elsewhere = data.external or data.is_virtual
            if (
                data.dtype.kind not in _NUMBERS
                or data.ndim > 2
                # Of an empty one h5py knows no size.
                or (data.size or 0) < 2
                or kind in _NO_NUMBERS
                or is_kept_elsewhere
            ):
                continue
            check_room(data.size + sum(a.size for a in found.values()))
            array = np.asarray(data[()], float)
            # MATLAB's columns are HDF5's rows.
            array = array.T if is_matlab else array
            found[name] = array.squeeze() if is_matlab else array
    return as_columns(found)


def _hard(group, name: str):
    """What a group holds by a name, None behind a link to elsewhere."""
    import h5py

    for part in name.split("/"):
        if not isinstance(group, h5py.Group) or part not in group:
            return None
        if not isinstance(group.get(part, getlink=True), h5py.HardLink):
            return None
        group = group[part]
    return group


def _datasets(group, prefix: str, depth: int) -> Iterator[tuple]:
    import h5py

    for name in group:
        item = None if name.startswith("#") else _hard(group, name)
        if isinstance(item, h5py.Dataset):
            yield prefix + name, item
        elif isinstance(item, h5py.Group) and depth:
            yield from _datasets(item, f"{prefix}{name}/", depth - 1)
