"""One way to run many tasks: on threads here, or on a Dask cluster.

    with open_workers(2) as workers:
        results = workers.map(function, [(a, b), ...])

Results are those of `function(*task)` in the order of the tasks, whatever runs
them, and do not depend on how many workers there are: a task draws from its
own seed, and nothing is summed in the order in which results come.
"""

from brace_drake.core.parallel.workers import Workers, open_workers

__all__ = ["Workers", "open_workers"]
