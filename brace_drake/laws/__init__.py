"""Pure laws of the twin: numbers in, numbers out, compiled by numba.

Each is called alike by a LeafSystem, by the compiled rollout and by the
tests. They write into arrays that the caller owns and allocate nothing.
"""
