"""How the simulator is compiled."""

from typing import Any

from numba import njit

_MAKER: dict[str, Any] = {
    "cache": True,
    "error_model": "numpy",
    "nogil": True,
    "_nrt": True,
}
# What only writes into arrays that it is handed counts no references to them,
# and is put in where it is called.
_WORKER: dict[str, Any] = {**_MAKER, "_nrt": False, "forceinline": True}

maker, worker = njit(**_MAKER), njit(**_WORKER)
