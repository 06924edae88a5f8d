"""How the laws are compiled."""

import functools
import threading
from collections.abc import Callable
from pathlib import Path

import numba
from numba import njit

from brace_drake.laws.kept import folder_of_sources, keep_by_sources, kept_in

# What makes arrays counts references to them, whoever calls it.
MAKER = {"cache": True, "error_model": "numpy", "_nrt": True}
# A law writes into what it is handed, makes no array and returns none. So
# nothing need be counted, which for each slice that is handed on costs an
# atomic operation or two, more than what most of the laws compute; and it is
# put in where it is called, as an array is handed over in seven words.
LAW = {**MAKER, "_nrt": False, "forceinline": True}

_LAWS = Path(__file__).parent
_LOCK = threading.Lock()


def compiled_when_called(signature, **options) -> Callable:
    """Decorator of what not every process needs and takes long to compile:
    it is compiled for its signature when it is called first.
    """

    def decorate(function):
        found = []

        @functools.wraps(function)
        def call(*args):
            if not found:
                folder = numba.config.CACHE_DIR or folder_of_sources(_LAWS)
                with _LOCK, kept_in(str(folder)):
                    if not found:
                        found.append(njit(signature, **options)(function))
            return found[0](*args)

        return call

    return decorate


compiled_maker = keep_by_sources(njit(**MAKER))
compiled_law = keep_by_sources(njit(**LAW))


@compiled_law
def copy_values(source, out):
    """Writes vector source (n,) into out (n,), where a slice could not be
    assigned without counting references.
    """
    for i in range(source.shape[0]):
        out[i] = source[i]
