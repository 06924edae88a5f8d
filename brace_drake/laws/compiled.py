"""How the laws are compiled."""

from numba import njit

from brace_drake.laws.kept import keep_by_sources

# What makes arrays counts references to them, whoever calls it.
MAKER = {"cache": True, "error_model": "numpy", "_nrt": True}
# A law writes into what it is handed, makes no array and returns none. So
# nothing need be counted, which for each slice that is handed on costs an
# atomic operation or two, more than what most of the laws compute; and it is
# put in where it is called, as an array is handed over in seven words.
LAW = {**MAKER, "_nrt": False, "forceinline": True}

compiled_maker = keep_by_sources(njit(**MAKER))
compiled_law = keep_by_sources(njit(**LAW))


@compiled_law
def copy_values(source, out):
    """Writes vector source (n,) into out (n,), where a slice could not be
    assigned without counting references.
    """
    for i in range(source.shape[0]):
        out[i] = source[i]
