"""Where compiled code is kept: one folder for each state of its sources.

Numba notices a change in the file of a compiled function but not in those of
the functions that it calls. So what is compiled is kept in a folder named
after the sources beside it and those of the laws, and a change in any of them
starts a new one.
"""

import hashlib
import inspect
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import numba

from brace_drake.core.resources import cache_path, takes_files


def sources_of(folder: Path) -> list[Path]:
    """Sources that code in a folder may be compiled from: those beside it and
    those of the laws; laws of effects call each other from folder to folder.
    """
    laws = Path(__file__).parent
    effects = laws.parent / "effects"
    beside = effects if effects in folder.parents else folder
    parts = dict.fromkeys((laws, beside))
    return [source for part in parts for source in sorted(part.rglob("*.py"))]


@cache
def folder_of_sources(folder: Path) -> Path:
    """Where code compiled from files in a folder is kept."""
    digest = hashlib.sha256(numba.__version__.encode())
    for source in sources_of(folder):
        digest.update(source.read_bytes())
    return cache_path(f"{folder.name}-{digest.hexdigest()[:16]}")


@contextmanager
def kept_in(folder: str) -> Iterator[None]:
    """What is compiled meanwhile is kept in a folder."""
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = folder
    try:
        yield
    finally:
        numba.config.CACHE_DIR = before


def keep_by_sources(compiler: Callable) -> Callable:
    """A decorator of numba's whose results are kept in such a folder, unless
    another one is set or it takes no files.
    """

    def compile_kept(function):
        folder = folder_of_sources(Path(inspect.getfile(function)).parent)
        if numba.config.CACHE_DIR or not takes_files(folder):
            return compiler(function)
        with kept_in(str(folder)):
            return compiler(function)

    return compile_kept
