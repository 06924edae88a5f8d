"""A module of this package run in a process of its own, spoken to by pipes."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys


def StartChild(module: str) -> subprocess.Popen:
    """Runs `python -m module`; Ctrl-C is for the one that has started it."""
    return subprocess.Popen(
        [sys.executable, "-m", module],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        process_group=0,
    )


def EndChild(child: subprocess.Popen, seconds: float) -> None:
    """Kills it, waits at most so long for its end, and closes its pipes."""
    child.kill()
    with contextlib.suppress(subprocess.TimeoutExpired):
        child.wait(seconds)
    for pipe in (child.stdin, child.stdout):
        with contextlib.suppress(OSError):
            pipe.close()
