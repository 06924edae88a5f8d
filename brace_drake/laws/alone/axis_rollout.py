"""A whole run of one axis on an imposed motion in one compiled call.

It is the only engine of this device; closed forms in the tests are its
reference.
"""

from numba import boolean, int64, njit

from brace_drake.laws.alone.pad_rollout import FORCE_AXIS, interpolate_path
from brace_drake.laws.compiled import MAKER, compiled_maker
from brace_drake.laws.hooks import (
    MAX_EFFECTS,
    matrix,
    stack_type,
    vector,
    vectors,
)

# Of the law's vector, what stands before the gains of extra inputs.
MASS, VISCOUS, STIFFNESS, OFFSET, GAINS = range(5)
# Places that a rollout needs beside the readings and the extra inputs.
WORK = 14


@compiled_maker
def calc_axis_force(path, inputs, law, f):
    """Writes the force that acts against the motion, turned round (1,), N.

    f = -(b v + k y + F_0 + g . i), before any effect and without inertia.

    Args:
        path: y, m, and v, m/s (2,).
        inputs: Extra inputs i (J,).
        law: Mass, b, k, F_0, then the gains g (4 + J,).
        f: Output (1,).
    """
    f[0] = -(law[VISCOUS] * path[1] + law[STIFFNESS] * path[0] + law[OFFSET])
    for j in range(inputs.shape[0]):
        f[0] -= law[GAINS + j] * inputs[j]


@njit(
    int64(
        int64,
        vector,
        matrix,
        matrix,
        vector,
        stack_type("drive"),
        stack_type("sensing"),
        vectors,
        vectors,
        vectors,
        boolean[:, ::1],
        vector,
    ),
    nogil=True,
    **MAKER,
)
def rollout_axis(
    steps_per_sample,
    time,
    path,
    inputs,
    law,
    drive,
    sensing,
    parameters,
    drive_memory,
    sensing_memory,
    active,
    work,
):
    """Moves the axis along a path and writes the force that this takes.

    F = m a + b v + k y + F_0 + g . i + effects.

    Args:
        steps_per_sample: Steps of the effects' states between two samples.
        time: Sample times from 0 (N,), s.
        path: Position, m, rate, m/s, and acceleration, m/s^2 (N, 3).
        inputs: Extra inputs (N, J).
        law: As in `calc_axis_force` (4 + J,).
        drive, sensing: Laws of the effects; those of the drive are given the
            viscous friction and, after it, the extra inputs as `law`.
        parameters, drive_memory, sensing_memory: Their parameters and states.
        active: Whether an effect sits at drive and sensing (2, MAX_EFFECTS).
        work: Output and work space (N + WORK + J,): the forces, N, then path
            (2), force of the drive (1), command (1), reading (3), lengths
            (6), b and the inputs (1 + J).

    Returns:
        -1 when all went well, else the sample at which the run broke down.
    """
    samples, more = time.shape[0], inputs.shape[1]
    space = work[samples:]
    at, f, u, F = space[0:2], space[2:3], space[3:4], space[4:7]
    position, lengths = space[0:1], space[7:13]
    known = space[13 : 14 + more]
    known[0] = law[VISCOUS]
    u[0] = 0.0
    for i in range(samples):
        following = min(i + 1, samples - 1)
        h = time[following] - time[following - 1]
        dt = h / steps_per_sample
        # Of the last sample only the reading is wanted.
        steps = steps_per_sample if following > i else 1
        for sub in range(steps):
            t = time[i] + sub * dt
            part = sub / steps_per_sample
            interpolate_path(
                sub * dt, h, path[i, 0:2], path[following, 0:2], at
            )
            for j in range(more):
                rise = inputs[following, j] - inputs[i, j]
                known[1 + j] = inputs[i, j] + part * rise
            calc_axis_force(at, known[1:], law, f)
            for e in range(MAX_EFFECTS):
                if active[0, e]:
                    drive[e](
                        t, dt, u, position, at[1:2], known, f,
                        parameters[e], drive_memory[e],
                    )  # fmt: skip
            if sub == 0:
                F[:] = 0.0
                F[FORCE_AXIS] = law[MASS] * path[i, 2] - f[0]
                for e in range(MAX_EFFECTS):
                    if active[1, e]:
                        sensing[e](
                            t, h, u, lengths, F,
                            parameters[e], sensing_memory[e],
                        )  # fmt: skip
                work[i] = F[FORCE_AXIS]
        if not abs(work[i]) < 1e9:
            return i
    return -1
