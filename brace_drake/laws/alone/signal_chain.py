"""Effects on one signal of a diagram, sample after sample."""

from numba import boolean, float64, njit, void

from brace_drake.laws.compiled import MAKER
from brace_drake.laws.hooks import (
    MAX_EFFECTS,
    stack_type,
    vector,
    vectors,
)


@njit(
    void(
        float64,
        vector,
        stack_type("signal"),
        vectors,
        vectors,
        boolean[::1],
    ),
    nogil=True,
    **MAKER,
)
def pass_signal(dt, values, laws, parameters, memory, active):
    """Writes what arrives of a signal in place of what was sent.

    Args:
        dt: Step, s.
        values: From time 0 on (N,).
        laws, parameters, memory: Of the effects, see `laws.hooks`.
        active: Whether an effect sits in each place (MAX_EFFECTS,).
    """
    for i in range(values.shape[0]):
        for e in range(MAX_EFFECTS):
            if active[e]:
                laws[e](i * dt, dt, values[i : i + 1], parameters[e], memory[e])
