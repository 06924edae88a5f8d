"""Pure laws of the twin: numbers in, numbers out, compiled by numba.

Each is called alike by a LeafSystem, by the compiled rollout and by the
tests. They write into arrays that the caller owns and allocate next to
nothing.

Numba notices a change in the file of a compiled function but not in those of
the functions that it calls. So the compiled laws are kept in a folder named
after the sources of them all, and a change in any of them starts a new one.
"""

import hashlib
import importlib
import os
import pkgutil
from pathlib import Path

import numba


def _cache_folder() -> Path:
    digest = hashlib.sha256(numba.__version__.encode())
    for source in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(source.read_bytes())
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "brace_drake" / f"laws-{digest.hexdigest()[:16]}"


def _import_all() -> None:
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = before or str(_cache_folder())
    try:
        for module in pkgutil.iter_modules(__path__):
            importlib.import_module(f"{__name__}.{module.name}")
    finally:
        numba.config.CACHE_DIR = before


_import_all()
