"""How the simulator is compiled, and where its machine code is kept.

Numba notices a change in the file of a compiled function but not in those of
the functions that it calls, so code is kept per state of all sources.
"""

import hashlib
import os
from pathlib import Path
from typing import Any

import numba

_MAKER: dict[str, Any] = {
    "cache": True,
    "error_model": "numpy",
    "nogil": True,
    "_nrt": True,
}
# What only writes into arrays that it is handed counts no references to them,
# and is put in where it is called.
_WORKER: dict[str, Any] = {**_MAKER, "_nrt": False, "forceinline": True}


def _folder_of_sources() -> str:
    """A folder named after the text of every file here."""
    text = numba.__version__.encode()
    for file in sorted(Path(__file__).parent.glob("*.py")):
        text += file.read_bytes()
    home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    name = "simulator-" + hashlib.sha256(text).hexdigest()[:16]
    return str(Path(home) / "brace_drake" / name)


_FOLDER = _folder_of_sources()


def _compile(function, options: dict[str, Any]):
    """Numba takes the folder at the moment of decoration."""
    kept = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = kept or _FOLDER
    try:
        return numba.njit(**options)(function)
    finally:
        numba.config.CACHE_DIR = kept


def maker(function):
    """Compiles a function that may make arrays."""
    return _compile(function, _MAKER)


def worker(function):
    """Compiles a function that makes no array and returns none."""
    return _compile(function, _WORKER)
