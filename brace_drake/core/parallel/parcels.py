"""Tasks as bytes: a function goes with all that it holds, tasks without that.

Functions of a package are named, others (those inside of functions) are sent
whole. Compiled functions are named too: each machine has its own of them.
Arrays of a task that the function holds as well are sent with the function
alone, once for all its tasks.
"""

from __future__ import annotations

import hashlib
import importlib
import io
import pickle
from collections import OrderedDict
from collections.abc import Callable, Sequence

import cloudpickle
import numpy as np
from numba.core.dispatcher import Dispatcher

_LEAST_BYTES = 1024
_MOST_FUNCTIONS = 4
# What this process has unpacked: the function and its arrays, by digest.
_unpacked: OrderedDict[str, tuple[Callable, list[np.ndarray]]] = OrderedDict()


def find_compiled(module: str, name: str):
    """A compiled function by its place."""
    found = importlib.import_module(module)
    for part in name.split("."):
        found = getattr(found, part)
    return found


class _Packer(cloudpickle.Pickler):
    """Names compiled functions; leaves out arrays that are known by index."""

    def __init__(
        self,
        file,
        index: dict[int, int],
        found: list[np.ndarray] | None = None,
    ):
        super().__init__(file, protocol=5)
        self._index, self._found = index, found

    def persistent_id(self, thing):
        if type(thing) is not np.ndarray:
            return None
        known = self._index.get(id(thing))
        if known is None and self._found is not None:
            if thing.nbytes >= _LEAST_BYTES:
                known = self._index[id(thing)] = len(self._found)
                self._found.append(thing)
        return known

    def reducer_override(self, thing):
        if isinstance(thing, Dispatcher):
            place = thing.py_func.__module__, thing.py_func.__qualname__
            try:
                if find_compiled(*place) is thing:
                    return find_compiled, place
            except (ImportError, AttributeError):
                pass
        return super().reducer_override(thing)


class _Unpacker(pickle.Unpickler):
    """Puts arrays back in by their index."""

    def __init__(self, data: bytes, arrays: list[np.ndarray]):
        super().__init__(io.BytesIO(data))
        self._arrays = arrays

    def persistent_load(self, pid):
        return self._arrays[pid]


class Parcel:
    """A function as bytes.

    Attributes:
        data: To be sent once.
        key: Digest of the data.
    """

    def __init__(self, function: Callable):
        # The arrays are kept, so that their ids stay theirs.
        self._index: dict[int, int] = {}
        self._arrays: list[np.ndarray] = []
        file = io.BytesIO()
        _Packer(file, self._index, self._arrays).dump(function)
        whole = self._arrays, file.getvalue()
        self.data = pickle.dumps(whole, protocol=5)
        self.key = hashlib.sha256(self.data).hexdigest()

    def pack(self, tasks: Sequence[tuple]) -> bytes:
        """Tasks as bytes that `run_parcel` takes beside the function's."""
        file = io.BytesIO()
        _Packer(file, self._index).dump(list(tasks))
        return file.getvalue()


def run_parcel(key: str, data: bytes, tasks: bytes) -> list:
    """Results of a packed function on packed tasks."""
    if key not in _unpacked:
        arrays, inner = pickle.loads(data)
        _unpacked[key] = _Unpacker(inner, arrays).load(), arrays
        while len(_unpacked) > _MOST_FUNCTIONS:
            _unpacked.popitem(last=False)
    function, arrays = _unpacked[key]
    return [function(*task) for task in _Unpacker(tasks, arrays).load()]
