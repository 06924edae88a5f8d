"""One way to run many tasks: on threads here, or on a Dask cluster.

    with open_workers(2) as workers:
        results = workers.map(function, [(a, b), ...])

Results are those of `function(*task)` in the order of the tasks, whatever runs
them, and do not depend on how many workers there are: a task draws from its
own seed, and nothing is summed in the order in which results come.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

from brace_drake.core.errors import ClusterError

__all__ = ["Workers", "open_workers"]


class Workers:
    """Threads. Compiled rollouts release the interpreter lock while they run.

    Sent to another machine, workers are one thread there.

    Attributes:
        jobs: How many.
    """

    def __init__(self, jobs: int = 1):
        self.jobs = max(1, jobs)
        self._pool = ThreadPoolExecutor(self.jobs)

    def __reduce__(self):
        return Workers, ()

    def __enter__(self) -> Workers:
        return self

    def __exit__(self, *exception) -> None:
        self.close()

    def map(
        self,
        function: Callable,
        tasks: Sequence[tuple],
        progress: Callable[[int], None] | None = None,
    ) -> list:
        """Results of `function(*task)` in the order of the tasks.

        Args:
            function: It must leave its arguments as they are.
            tasks: Arguments.
            progress: Told how many are done.

        Raises:
            Exception: Of the first task that raised one.
        """
        results = []
        for result in self._pool.map(lambda task: function(*task), tasks):
            results.append(result)
            if progress is not None:
                progress(len(results))
        return results

    def close(self) -> None:
        """Ends them; what has not begun is dropped."""
        self._pool.shutdown(cancel_futures=True)


def open_workers(
    jobs: int | Workers = 1, cluster: str | None = None
) -> Workers:
    """Workers of an address, or `jobs` threads; workers stay what they are.

    Args:
        jobs: Threads, unless there is an address.
        cluster: Of a Dask scheduler, as in tcp://host:8786.

    Raises:
        ClusterError: There is no such cluster, or its workers differ.
    """
    if isinstance(jobs, Workers):
        return jobs
    if cluster is None:
        return Workers(jobs)
    try:
        from brace_drake.core.parallel.cluster import ClusterWorkers
    except ImportError as error:
        raise ClusterError(
            "a cluster needs one more package: pip install -e '.[cluster]'"
        ) from error
    return ClusterWorkers(cluster)
