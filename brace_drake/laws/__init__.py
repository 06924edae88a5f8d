"""Pure laws of the twin: numbers in, numbers out, compiled by numba.

Each is called alike by a LeafSystem, by the compiled rollout and by the
tests. They write into arrays that the caller owns and allocate next to
nothing.

Numba notices a change in the file of a compiled function but not in those of
the functions that it calls. So the compiled laws are kept in a folder named
after the sources of them all, and a change in any of them starts a new one.
Where that folder takes no files, as on a full disk or in a home that is
read-only, they are compiled for this process alone.
"""

import atexit
import hashlib
import importlib
import os
import pkgutil
import shutil
import tempfile
from pathlib import Path

import numba


def _cache_folder() -> Path:
    digest = hashlib.sha256(numba.__version__.encode())
    for source in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(source.read_bytes())
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "brace_drake" / f"laws-{digest.hexdigest()[:16]}"


def _import_all(folder: str) -> None:
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = folder
    try:
        for module in pkgutil.iter_modules(__path__):
            importlib.import_module(f"{__name__}.{module.name}")
    finally:
        numba.config.CACHE_DIR = before


def _import_without_cache() -> None:
    """Into a folder of this process, which nobody else can put code into."""
    folder = tempfile.mkdtemp(prefix="brace-drake-laws-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    # For those compiled later on, too.
    numba.config.CACHE_DIR = folder
    _import_all(folder)


def _takes_files(folder: str) -> bool:
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder) as file:
            file.write(bytes(2**16))
    except OSError:
        return False
    return True


def _import(folder: str) -> None:
    if not _takes_files(folder):
        _import_without_cache()
        return
    try:
        _import_all(folder)
    except OSError:
        # Its disk was full before all was compiled.
        _import_without_cache()


_import(numba.config.CACHE_DIR or str(_cache_folder()))
