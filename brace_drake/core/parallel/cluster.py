"""Workers of a Dask cluster (the extra `cluster`), and tasks as bytes.

A function goes with all that it holds, its tasks without that. Functions of a
package are named, others (those inside of functions) are sent whole. Compiled
functions are named too: each machine has its own of them. Arrays of a task that
the function holds as well are sent with the function alone, once for all its
tasks.
"""

from __future__ import annotations

import asyncio
import hashlib
import importlib
import io
import math
import pickle
import socket
import time
from collections import OrderedDict
from collections.abc import Callable, Sequence

import cloudpickle
import numpy as np
from distributed import Client, KilledWorker, Security, as_completed
from distributed.client import FutureCancelledError
from distributed.comm import connect
from distributed.comm.addressing import parse_address, parse_host_port
from numba.core.dispatcher import Dispatcher

from brace_drake.core.errors import ClusterError, quoted, reason
from brace_drake.core.parallel import Workers
from brace_drake.core.versions import installed_versions

# Results depend on these to the last bit (and on sources and processor, which
# are not compared).
PACKAGES = ("brace_drake", "drake", "numba", "numpy", "scipy")
# Ways to a scheduler that have a host and a port.
_SCHEMES = ("tcp", "tls", "ws", "wss")
_CONNECT_S = 30.0
# A scheduler that is about to begin refuses connections for so long at most.
_REFUSED_S = 5.0
_WORKERS_S = 60.0
# Parts of the tasks for each thread: a lost worker costs no more than a part.
_PARTS = 16
_LEAST_BYTES = 1024
_MOST_PORT = 65535
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
        self._client = _connect(address)
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


def _await_port(place: str) -> None:
    """Waits a little for a port that refuses connections.

    A client would ask for all of its time, as it does of a machine that is
    silent.

    Raises:
        OSError: It refuses them still, or no machine has that name.
        ValueError: It is no address.
    """
    target = parse_host_port(place)
    if not 0 < target[1] <= _MOST_PORT:
        raise ValueError(f"port {target[1]}")
    end = time.monotonic() + _REFUSED_S
    while True:
        try:
            socket.create_connection(target, _CONNECT_S).close()
            return
        except (ConnectionRefusedError, socket.gaierror):
            if time.monotonic() > end:
                raise
            time.sleep(0.2)


async def _greet(address: str) -> None:
    """Talks to a scheduler once.

    A client whose greeting fails is left behind, and keeps the process for
    minutes.

    Raises:
        Exception: Nobody answers, or in another language.
    """
    options = Security().get_connection_args("client")
    # Not every way heeds the limit that it is given.
    async with asyncio.timeout(_CONNECT_S):
        greeted = await connect(address, timeout=_CONNECT_S, **options)
    await greeted.close()


def _connect(address: str):
    """A client of a scheduler whose workers run what this process runs."""
    place = f"--cluster {address}"
    try:
        scheme, target = parse_address(address)
        if scheme not in _SCHEMES:
            raise ClusterError(
                f"{place}: {quoted(scheme)} is no way to a scheduler; allowed:"
                f" {', '.join(_SCHEMES)}, as in tcp://host:8786"
            )
        _await_port(target)
        asyncio.run(_greet(address))
        client = Client(address, timeout=_CONNECT_S, set_as_default=False)
    except ClusterError:
        raise
    # What talks another language may raise any exception.
    except Exception as error:
        raise ClusterError(
            f"{place}: no Dask scheduler answers there"
        ) from error
    try:
        client.wait_for_workers(1, timeout=_WORKERS_S)
        there = client.run(installed_versions, PACKAGES)
        here = installed_versions(PACKAGES)
        for worker, found in there.items():
            for name, value in here.items():
                if found[name] != value:
                    raise ClusterError(
                        f"{place}: {worker} has {name} {found[name]}, here is"
                        f" {value}: results would differ"
                    )
    except Exception as error:
        client.close()
        if isinstance(error, ClusterError):
            raise
        if isinstance(error, OSError | TimeoutError):
            raise ClusterError(f"{place}: there are no workers") from error
        raise ClusterError(
            f"{place}: a worker cannot run brace_drake: {reason(error)}"
        ) from error
    return client
