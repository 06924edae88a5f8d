"""Where compiled code is kept: one folder for each state of its sources.

Numba notices a change in the file of a compiled function but not in those of
the functions that it calls. So what is compiled is kept in a folder named
after the sources beside it and those of the laws, and a change in any of them
starts a new one.
"""

import hashlib
import inspect
import os
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numba


@cache
def folder_of_sources(folder: Path) -> Path:
    """Where code compiled from files in a folder is kept."""
    digest = hashlib.sha256(numba.__version__.encode())
    laws = Path(__file__).parent
    for part in dict.fromkeys((laws, folder)):
        for source in sorted(part.glob("*.py")):
            digest.update(source.read_bytes())
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    name = f"{folder.name}-{digest.hexdigest()[:16]}"
    return Path(base) / "brace_drake" / name


def keep_by_sources(compiler: Callable) -> Callable:
    """A decorator of numba's whose results are kept in such a folder, unless
    another one is set or it takes no files.
    """

    def compile_kept(function):
        before = numba.config.CACHE_DIR
        folder = folder_of_sources(Path(inspect.getfile(function)).parent)
        if not before and takes_files(folder):
            numba.config.CACHE_DIR = str(folder)
        try:
            return compiler(function)
        finally:
            numba.config.CACHE_DIR = before

    return compile_kept


@cache
def takes_files(folder: Path) -> bool:
    """Whether a folder can be written to; it is made where there is none."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder) as file:
            file.write(bytes(2**16))
    except OSError:
        return False
    return True
