"""Workers of a Dask cluster (the extra `cluster`), and tasks as bytes.

A function goes with all that it holds, its tasks without that. Functions of a
package are named, others (those inside of functions) are sent whole. Compiled
functions are named too: each machine has its own of them. Arrays of a task that
the function holds as well are sent with the function alone, once for all its
tasks.
"""

from __future__ import annotations

import hashlib
import importlib
import io
import math
import pickle
from collections import OrderedDict
from collections.abc import Callable, Sequence

import cloudpickle
import numpy as np
from distributed import KilledWorker, as_completed
from distributed.client import FutureCancelledError
from numba.core.dispatcher import Dispatcher

from brace_drake.core.errors import ClusterError
from brace_drake.core.parallel import Workers
from brace_drake.core.parallel.connecting import connect_client

# Parts of the tasks for each thread: a lost worker costs no more than a part.
_PARTS = 16
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


def keep(data: bytes) -> bytes:
    """A task whose result is what it was given.

    So data is held by workers, and made again by the scheduler where all that
    held it are lost.
    """
    return data


class ClusterWorkers(Workers):
    """Threads of the workers at a Dask scheduler.

    A worker that is lost costs the tasks that it had at that time: others do
    them again. Results are fetched as they come.

    Args:
        address: Of the scheduler, as in tcp://host:8786.

    Raises:
        ClusterError: The extra is missing, nobody answers, there are no
            workers, or one runs other versions than this process.
    """

    def __init__(self, address: str):
        super().__init__(1)
        self._functions: dict[str, object] = {}
        self._client = connect_client(address)
        self.address = address

    def map(
        self,
        function: Callable,
        tasks: Sequence[tuple],
        progress: Callable[[int], None] | None = None,
    ) -> list:
        """See `Workers.map`.

        Raises:
            ClusterError: A task has ended several workers, or all are gone.
        """
        tasks = list(tasks)
        if not tasks:
            return []
        threads = max(1, sum(self._client.nthreads().values()))
        size = math.ceil(len(tasks) / (_PARTS * threads))
        parts = [tasks[i : i + size] for i in range(0, len(tasks), size)]
        parcel = Parcel(function)
        data = self._send(parcel)
        futures = {
            self._client.submit(
                run_parcel, parcel.key, data, parcel.pack(part), pure=False
            ): i
            for i, part in enumerate(parts)
        }
        results: list[list] = [[] for _ in parts]
        done = 0
        try:
            for future in as_completed(list(futures), loop=self._client.loop):
                i = futures[future]
                results[i] = future.result()
                done += len(parts[i])
                future.release()
                if progress is not None:
                    progress(done)
        except KilledWorker as error:
            raise ClusterError(
                f"--cluster {self.address}: workers were lost on one task, one"
                f" after the other: {error}"
            ) from error
        except FutureCancelledError as error:
            raise ClusterError(
                f"--cluster {self.address}: the scheduler has gone"
            ) from error
        finally:
            self._client.cancel(list(futures))
        return [result for part in results for result in part]

    def close(self) -> None:
        """Leaves the cluster, which goes on."""
        self._functions.clear()
        self._client.close()
        super().close()

    def _send(self, parcel: Parcel):
        """A function's bytes as a task of the cluster, the last one kept."""
        if parcel.key not in self._functions:
            self._functions.clear()
            self._functions[parcel.key] = self._client.submit(
                keep, parcel.data, key=f"brace-{parcel.key}"
            )
        return self._functions[parcel.key]
