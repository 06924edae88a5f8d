"""A brace in closed loop, in compiled code: a whole run, or by decisions.

The same laws in the same order as the diagrams of `brace_drake.model`, which
remain the reference (tests hold both together).
"""

from typing import NamedTuple

import numpy as np
from numba import float64, int64, njit, types

from brace_drake.laws.compiled import (
    MAKER,
    compiled_law,
    compiled_when_called,
    copy_values,
)
from brace_drake.laws.control.brace_control import (
    GOOD,
    HELD,
    advance_controller,
    make_controller,
)
from brace_drake.laws.cubic import calc_cubic
from brace_drake.laws.hooks import EFFECTS, matrix, vector
from brace_drake.laws.loop.brace import BRACE, is_near
from brace_drake.laws.loop.ticks import go_to_tick
from brace_drake.laws.numbers import NUMBERS

# What a decision comes back with, beside what a tick does: bodies have flown
# apart.
LOST = 4


class RunPlan(NamedTuple):
    """What a run is asked to do.

    Attributes:
        desired: X_d, X_d', X_d'' of the coordinates that move, at each tick
            (ticks, 3, m); the others stay at 0.
        columns: Which task coordinates these are (m,).
        noise: Of the readings at each tick (ticks, 9n + 3), or (0, 9n + 3).
        ticks_per_sample: Control ticks in a logged sample.
        log: Output (samples, 15n + 3 + m): commands (6n), readings (9n + 3),
            X_v of the coordinates that move (m).
    """

    desired: np.ndarray
    columns: np.ndarray
    noise: np.ndarray
    ticks_per_sample: int
    log: np.ndarray


class DecisionPlan(NamedTuple):
    """What an episode of decisions is asked to do.

    Attributes:
        ticks: From one decision to the next.
        duration: Of the desired motion, s.
        reference: X_0, and what the desired motion adds to it (2, 6n).
        stiffness: Asked of the controller (6n,), or (0,).
        noise: Of the readings at each tick (ticks, 9n + 3), or (0, 9n + 3).
    """

    ticks: int
    duration: float
    reference: np.ndarray
    stiffness: np.ndarray
    noise: np.ndarray


_array3 = float64[:, :, ::1]
_CONTROL = types.Tuple((int64, HELD))
_RUN = types.NamedTuple((_array3, int64[::1], matrix, int64, matrix), RunPlan)
_DECISIONS = types.NamedTuple(
    (int64, float64, matrix, vector, matrix), DecisionPlan
)


@compiled_law
def place_desired(values, columns, desired):
    """Writes the coordinates that move (3, m) into X_d and rates (3, 6n)."""
    for row in range(3):
        for j in range(columns.shape[0]):
            desired[row, columns[j]] = values[row, j]


@compiled_law
def write_row(brace, virtual, columns, row):
    """Writes a row of a log, see `RunPlan.log`."""
    a = brace.u.shape[0]
    b = a + brace.readings.shape[0]
    copy_values(brace.u, row[0:a])
    copy_values(brace.readings, row[a:b])
    for j in range(columns.shape[0]):
        row[b + j] = virtual[0, columns[j]]


@compiled_law
def _perform_tick(tick, dt, steps, numbers, effects, brace, controller, plan):
    """A tick of a run and its row of the log; False where it broke down."""
    # Nothing in here is counted, see `compiled.LAW`: no array is made.
    none = brace.u[0:0]
    noise = plan.noise[tick] if plan.noise.shape[0] > 0 else none
    go_to_tick(tick, dt, steps, numbers, effects, brace, noise)
    place_desired(plan.desired[tick], plan.columns, controller.desired)
    result = advance_controller(controller, brace.readings, none, brace.u)
    if result != GOOD or not is_near(numbers, brace):
        return False
    if tick % plan.ticks_per_sample == 0:
        row = plan.log[tick // plan.ticks_per_sample]
        write_row(brace, controller.virtual, plan.columns, row)
    return True


@njit(
    int64(float64, int64, NUMBERS, EFFECTS, BRACE, _CONTROL, _RUN),
    nogil=True,
    **MAKER,
)
def rollout_brace(dt, steps, numbers, effects, brace, control, plan):
    """Simulates one run and writes its log.

    Args:
        dt, steps: Step of the plant, s; steps in a control period.
        numbers: See `laws.numbers`.
        effects: At the plug points, see `laws.hooks`; states are updated.
        brace: From `make_brace`, updated.
        control: Kind of the controller, and what it holds, see
            `brace_control.HELD`.
        plan: Of the run.

    Returns:
        -1 when all went well, else the tick at which the run broke down.
    """
    controller = make_controller(control[0], numbers.control, control[1])
    for tick in range(plan.desired.shape[0]):
        if not _perform_tick(
            tick, dt, steps, numbers, effects, brace, controller, plan
        ):
            return tick
    return -1


@compiled_law
def _decide(tick, dt, steps, numbers, effects, brace, controller, plan):
    """A tick of an episode; returns how it went."""
    noise = plan.noise[tick] if plan.noise.shape[0] > 0 else brace.u[0:0]
    go_to_tick(tick, dt, steps, numbers, effects, brace, noise)
    if not is_near(numbers, brace):
        return LOST
    return advance_controller(
        controller, brace.readings, plan.stiffness, brace.u
    )


@compiled_when_called(
    (float64, int64, NUMBERS, EFFECTS, BRACE, _CONTROL, _DECISIONS), **MAKER
)  # fmt: skip
def run_decisions(dt, steps, numbers, effects, brace, control, plan):
    """A generator: performs the first tick, yields, goes to the next decision.

    What the caller writes into `plan.stiffness` between two decisions counts
    from then on.

    Args:
        dt ... control: As in `rollout_brace`.
        plan: Of the episode.

    Yields:
        What `advance_controller` returns, or LOST.
    """
    controller = make_controller(control[0], numbers.control, control[1])
    desired, tick = controller.desired.reshape(-1), 0
    start, way = plan.reference[0], plan.reference[1]
    while True:
        calc_cubic(tick * (dt * steps), plan.duration, start, way, desired)
        result = _decide(
            tick, dt, steps, numbers, effects, brace, controller, plan
        )
        if result != GOOD or tick % plan.ticks == 0:
            yield result
        tick += 1
