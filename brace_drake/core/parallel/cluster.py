"""Workers of a Dask cluster (the extra `cluster`)."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from brace_drake.core.errors import ClusterError
from brace_drake.core.parallel.parcels import Parcel, run_parcel
from brace_drake.core.parallel.workers import Workers
from brace_drake.core.versions import installed_versions

# Results depend on these to the last bit (and on sources and processor, which
# are not compared).
PACKAGES = ("brace_drake", "drake", "numba", "numpy", "scipy")
_CONNECT_S = 30.0
_WORKERS_S = 60.0
# Parts of the tasks for each thread: a lost worker costs no more than a part.
_PARTS = 16


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
        from distributed import as_completed

        tasks = list(tasks)
        if not tasks:
            return []
        parcel = Parcel(function)
        data, size = self._send(parcel), self._size_of_part(len(tasks))
        parts = [tasks[i : i + size] for i in range(0, len(tasks), size)]
        futures = {
            self._client.submit(
                run_parcel,
                parcel.key,
                data,
                parcel.pack(part),
                pure=False,
            ): i
            for i, part in enumerate(parts)
        }
        results: list[list] = [[] for _ in parts]
        done = 0
        try:
            for future in as_completed(list(futures), loop=self._client.loop):
                i = futures[future]
                results[i] = _result_of(future, self.address)
                done += len(parts[i])
                future.release()
                if progress is not None:
                    progress(done)
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

    def _size_of_part(self, count: int) -> int:
        threads = max(1, sum(self._client.nthreads().values()))
        return math.ceil(count / (_PARTS * threads))


def _connect(address: str):
    """A client of a scheduler whose workers run what this process runs."""
    try:
        from distributed import Client
    except ImportError as error:
        raise ClusterError(
            "a cluster needs one more package: pip install -e '.[cluster]'"
        ) from error
    try:
        client = Client(address, timeout=_CONNECT_S, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as error:
        raise ClusterError(
            f"--cluster {address}: no Dask scheduler answers there"
        ) from error
    try:
        client.wait_for_workers(1, timeout=_WORKERS_S)
        there = client.run(installed_versions, PACKAGES)
    except (OSError, TimeoutError) as error:
        client.close()
        raise ClusterError(
            f"--cluster {address}: there are no workers"
        ) from error
    except Exception as error:
        client.close()
        line = " ".join(str(error).split())
        raise ClusterError(
            f"--cluster {address}: a worker cannot run brace_drake: {line}"
        ) from error
    here = installed_versions(PACKAGES)
    for worker, found in there.items():
        for name, value in here.items():
            if found[name] != value:
                client.close()
                raise ClusterError(
                    f"--cluster {address}: {worker} has {name} {found[name]},"
                    f" here is {value}: results would differ"
                )
    return client


def _result_of(future, address: str) -> list:
    from distributed import KilledWorker
    from distributed.client import FutureCancelledError

    try:
        return future.result()
    except KilledWorker as error:
        raise ClusterError(
            f"--cluster {address}: workers were lost on one task, one after"
            f" the other: {error}"
        ) from error
    except FutureCancelledError as error:
        raise ClusterError(
            f"--cluster {address}: the scheduler has gone"
        ) from error
