"""How the stand-in is compiled."""

from numba import njit

# What makes arrays.
maker = njit(cache=True, error_model="numpy", _nrt=True)
# What only writes into those that it is handed counts no references to them,
# and is put in where it is called.
worker = njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
