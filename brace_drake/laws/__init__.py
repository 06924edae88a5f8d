"""Pure laws of the twin: numbers in, numbers out, compiled by numba.

Each is called alike by a LeafSystem, by the compiled rollout and by the
tests. They write into arrays that the caller owns and allocate next to
nothing. In this folder are the laws of single parts, in `control` those of the
controllers, in `loop` all of them put together, in `alone` a part by itself,
and in `lanes` what lets several copies of a brace go side by side.

They are kept in a folder for each state of their sources, see `kept`. Where
the user's cache takes no files, as on a full disk or in a home that is
read-only, that is a temporary one; where that takes none either, they are
compiled for this process alone.
"""

import atexit
import importlib
import pkgutil
import shutil
import tempfile
from pathlib import Path

import numba

from brace_drake.core.resources import takes_files, tell_note
from brace_drake.laws.kept import folder_of_sources, kept_in


def _import_all(folder: str) -> None:
    with kept_in(folder):
        for module in pkgutil.walk_packages(__path__, f"{__name__}."):
            importlib.import_module(module.name)


def _import_without_cache(wanted: str) -> None:
    """Into a folder of this process, which nobody else can put code into."""
    tell_note(
        f"{wanted} takes no files: the laws are compiled for this process"
        " alone, and again for the next; XDG_CACHE_HOME names another place"
    )
    folder = tempfile.mkdtemp(prefix="brace-drake-laws-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    # For those compiled later on, too.
    numba.config.CACHE_DIR = folder
    _import_all(folder)


def _import(folder: str) -> None:
    if not takes_files(Path(folder)):
        _import_without_cache(folder)
        return
    try:
        _import_all(folder)
    except OSError:
        # Its disk was full before all was compiled.
        _import_without_cache(folder)


_import(numba.config.CACHE_DIR or str(folder_of_sources(Path(__file__).parent)))

# What callers of the loop need; the laws above are compiled first.
from brace_drake.laws.hooks import PLUG_POINTS, Effects  # noqa: E402
from brace_drake.laws.loop.brace import Brace, make_brace  # noqa: E402
from brace_drake.laws.loop.rollout import (  # noqa: E402
    DecisionPlan,
    RunPlan,
    rollout_brace,
    run_decisions,
)
from brace_drake.laws.loop.ticks import run_forces, run_ticks  # noqa: E402
from brace_drake.laws.numbers import BraceNumbers  # noqa: E402
from brace_drake.laws.plug_in import PlugIn, make_effects  # noqa: E402

__all__ = [
    "PLUG_POINTS",
    "Brace",
    "BraceNumbers",
    "DecisionPlan",
    "Effects",
    "PlugIn",
    "RunPlan",
    "make_brace",
    "make_effects",
    "rollout_brace",
    "run_decisions",
    "run_forces",
    "run_ticks",
]
