"""A whole run of the pad bench in one compiled call, and its laws.

It is the only engine of this device; closed forms in the tests are its
reference.
"""

from numba import boolean, int64, njit

from brace_drake.laws.compiled import MAKER, compiled_maker
from brace_drake.laws.contact import normal_force
from brace_drake.laws.hooks import (
    MAX_EFFECTS,
    matrix,
    stack_type,
    vector,
    vectors,
)

# Of the reading that effects at `sensing` change: the bench's y-axis.
FORCE_AXIS = 1
# Legs of the bench, which the signature of `sensing` asks for.
NUM_LEGS = 6


@compiled_maker
def interpolate_path(s, h, start, end, out):
    """Writes displacement and rate between two samples, a cubic Hermite.

    Args:
        s: Time since the first sample, s.
        h: Time between them, s.
        start, end: Displacement, m, and rate, m/s, at the samples (2,).
        out: Output (2,).
    """
    a = s / h
    rise = end[0] - start[0]
    # Coefficients of a^2 and a^3.
    two = 3.0 * rise - h * (2.0 * start[1] + end[1])
    three = h * (start[1] + end[1]) - 2.0 * rise
    out[0] = start[0] + a * (h * start[1] + a * (two + a * three))
    out[1] = start[1] + a * (2.0 * two + 3.0 * a * three) / h


@compiled_maker
def calc_pad_compression(path, law, d):
    """Writes d = displacement + preload and its rate (2,), m and m/s.

    Args:
        path: Displacement and rate of the pad (2,).
        law: Stiffness, damping, friction, regularisation speed, pad offset,
            preload (6,); here the first two and the last count.
        d: Output (2,).
    """
    d[0] = path[0] + law[5]
    d[1] = path[1]


@compiled_maker
def calc_normal_force(d, law, N):
    """Writes k d + c d' (1,), N, before effects and before it is cut."""
    N[0] = normal_force(d[0], d[1], law[0], law[1])


@compiled_maker
def cut_normal_force(d, N):
    """Sets N (1,) to zero where the pad is off the tissue or would pull."""
    if not d[0] > 0.0 or N[0] < 0.0:
        N[0] = 0.0


@njit(
    int64(
        int64,
        vector,
        matrix,
        vector,
        stack_type("compression"),
        stack_type("contact"),
        stack_type("sensing"),
        vectors,
        vectors,
        vectors,
        vectors,
        boolean[:, ::1],
        vector,
    ),
    nogil=True,
    **MAKER,
)
def rollout_pad(
    steps_per_sample,
    time,
    path,
    law,
    compression,
    contact,
    sensing,
    parameters,
    compression_memory,
    contact_memory,
    sensing_memory,
    active,
    work,
):
    """Presses the pad along a path and writes the force readings.

    Args:
        steps_per_sample: Steps of the effects' states between two samples.
        time: Sample times from 0 (N,), s.
        path: Displacement, m, and rate, m/s, at the samples (N, 2).
        law: As in `calc_pad_compression` (6,).
        compression, contact, sensing: Laws of the effects.
        parameters: Theirs.
        compression_memory, contact_memory, sensing_memory: Their states.
        active: Whether an effect sits at compression, contact and sensing
            (3, MAX_EFFECTS).
        work: Output and work space (N + 20,): the readings, N, then path (2),
            compression (2), force (1), reading (3), commands (6), lengths (6).

    Returns:
        -1 when all went well, else the sample at which the run broke down.
    """
    samples = time.shape[0]
    space = work[samples:]
    at, d, N, F = space[0:2], space[2:4], space[4:5], space[5:8]
    u, lengths = space[8:14], space[14:20]
    for i in range(samples):
        following = min(i + 1, samples - 1)
        h = time[following] - time[following - 1]
        dt = h / steps_per_sample
        # Of the last sample only the reading is wanted.
        steps = steps_per_sample if following > i else 1
        for sub in range(steps):
            t = time[i] + sub * dt
            interpolate_path(sub * dt, h, path[i], path[following], at)
            calc_pad_compression(at, law, d)
            for e in range(MAX_EFFECTS):
                if active[0, e]:
                    compression[e](
                        t, dt, 0, d, parameters[e], compression_memory[e]
                    )
            calc_normal_force(d, law, N)
            for e in range(MAX_EFFECTS):
                if active[1, e]:
                    contact[e](
                        t, dt, 0, d, law, N, parameters[e], contact_memory[e]
                    )
            cut_normal_force(d, N)
            if sub == 0:
                F[:] = 0.0
                F[FORCE_AXIS] = N[0]
                for e in range(MAX_EFFECTS):
                    if active[2, e]:
                        sensing[e](
                            t, h, u, lengths, F,
                            parameters[e], sensing_memory[e],
                        )  # fmt: skip
                work[i] = F[FORCE_AXIS]
        if not abs(work[i]) < 1e9:
            return i
    return -1
