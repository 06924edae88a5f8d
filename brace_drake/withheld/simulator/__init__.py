"""An independent simulator of the physical bench, written apart from the twin.

It shares no code with the twin: other formulation, other integration, other
laws of friction and tissue. Where the twin is an idealisation of a machine,
this plays the machine.

Numba notices a change in the file of a compiled function but not in those of
the functions that it calls, so compiled code is kept per state of all sources.
"""

import hashlib
import importlib
import os
import pkgutil
from pathlib import Path

import numba


def _folder_of_sources() -> str:
    """A cache folder named after the text of every file here."""
    text = numba.__version__.encode()
    for file in sorted(Path(__file__).parent.glob("*.py")):
        text += file.read_bytes()
    home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    name = "simulator-" + hashlib.sha256(text).hexdigest()[:16]
    return str(Path(home) / "brace_drake" / name)


_kept = numba.config.CACHE_DIR
numba.config.CACHE_DIR = _kept or _folder_of_sources()
try:
    for _module in pkgutil.iter_modules(__path__):
        importlib.import_module(f"{__name__}.{_module.name}")
finally:
    numba.config.CACHE_DIR = _kept
