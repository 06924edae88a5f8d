"""Episodes of several copies of a brace at once, decision by decision.

The same tick and the same laws as `rollout.run_decisions`, with lanes in place
of floats, see `laws.lanes`. Copies differ in their numbers, effects, motion,
noise and stiffness, and in how far their episodes are.
"""

from typing import NamedTuple

import numpy as np
from numba import float64, int64, types

from brace_drake.laws import stages
from brace_drake.laws.compiled import (
    MAKER,
    compiled_law,
    compiled_when_called,
    copy_values,
)
from brace_drake.laws.control import vpic
from brace_drake.laws.control.brace_control import (
    BAD_STIFFNESS,
    CONTROLLER,
    ESTIMATOR,
    GOOD,
    K_D,
    M_D,
    NO_POSE,
    NUM_SHARED_LAW,
    SELECTED,
)
from brace_drake.laws.cubic import calc_cubic
from brace_drake.laws.hooks import EFFECTS, matrix, vector
from brace_drake.laws.lanes.arrays import floats_of, lanes_of, stacked_kind
from brace_drake.laws.lanes.functions import lead
from brace_drake.laws.lanes.kinds import COUNT
from brace_drake.laws.loop.brace import BRACE, is_near
from brace_drake.laws.loop.rollout import LOST
from brace_drake.laws.loop.rollout_copies import command_copies, estimate_copies
from brace_drake.laws.loop.ticks import go_to_tick
from brace_drake.laws.numbers import NUMBERS


class EpisodeCopy(NamedTuple):
    """What an episode is asked to do and how far it is, of each copy.

    Attributes:
        tick: The last one, a whole number (1,).
        place: Of its noise, a whole number (1,).
        reference: X_0, and what the desired motion adds to it (2, 6n).
        stiffness: Asked of the controller (6n,).
        noise: Place for that of a tick (9n + 3,), or (0,): exact readings.
        desired: Place for X_d, X_d', X_d'' (18n,).
    """

    tick: np.ndarray
    place: np.ndarray
    reference: np.ndarray
    stiffness: np.ndarray
    noise: np.ndarray
    desired: np.ndarray


EPISODE = types.NamedTuple(
    (vector, vector, matrix, vector, vector, vector), EpisodeCopy
)


def num_reported(num_stages: int) -> int:
    """Numbers in a report of n rings, see `run_decisions_of_copies`."""
    return 57 * num_stages


@compiled_law
def take_noise(tick, place, noise, own):
    """Writes the noise (places, ticks, m) of each copy's tick into own (m,)."""
    row, ticks, places = floats_of(own), floats_of(tick), floats_of(place)
    for copy in range(COUNT):
        at, source = int(ticks[0, copy]), int(places[0, copy])
        for c in range(own.shape[0]):
            row[c, copy] = noise[source, at, c]


@compiled_law
def advance_controllers(controller, readings, stiffness, command):
    """One tick of the controllers of all copies, under VPIC.

    Returns:
        What `brace_control.advance_controller` would, of the first that fails.
    """
    if not estimate_copies(controller, readings):
        return NO_POSE
    law, memory = controller.law, controller.memory
    if not vpic.advance_vpic(
        controller.desired, controller.state, memory[0], stiffness,
        law[ESTIMATOR, 3], law[SELECTED], law[M_D : K_D + 1],
        law[NUM_SHARED_LAW:], memory[1:], controller.virtual,
        controller.impedance,
    ):  # fmt: skip
        return BAD_STIFFNESS
    return command_copies(controller, command)


@compiled_law
def place_rows(values, rows):
    """Writes rows one behind the other (m k,) into rows (m, k)."""
    for i in range(rows.shape[0]):
        for j in range(rows.shape[1]):
            rows[i, j] = values[i * rows.shape[1] + j]


@compiled_law
def report_copies(time, duration, numbers, brace, controller, episode, out):
    """Writes what is and what the controllers know.

    Args:
        time: Now, s.
        duration: Of the desired motion, s.
        numbers, brace, controller, episode: See the module.
        out: Output (57n,): X_d, X_d', X_d'' (18n); X, X' as they are (12n);
            forces of the pads on the torso (3n), N; X, X', filtered force as
            known (18n); stiffness in use (6n).
    """
    n = numbers.rest.shape[0]
    m = 6 * n
    start, way = episode.reference[0], episode.reference[1]
    calc_cubic(time, duration, start, way, out[0 : 3 * m])
    rings = brace.poses[0:n]
    stages.calc_task_coordinates(rings, numbers.rest, out[3 * m : 4 * m])
    for i in range(n):
        at = 6 * i
        for c in range(3):
            out[4 * m + at + c] = brace.V[i, 3 + c]
            out[4 * m + at + 3 + c] = brace.V[i, c]
            out[5 * m + 3 * i + c] = brace.f_T[i, c]
        for c in range(6):
            out[33 * n + at + c] = controller.rings[i, 7 + c]
            out[39 * n + at + c] = controller.rings[i, 13 + c]
    copy_values(controller.memory[0], out[45 * n : 51 * n])
    copy_values(controller.impedance[2], out[51 * n : 57 * n])


@compiled_law
def perform_tick(
    dt, steps, duration, numbers, effects, brace, controller, episode, noise
):
    """The next tick of all copies; how it went."""
    tick = episode.tick
    tick[0] = tick[0] + 1.0
    own = episode.noise
    if own.shape[0] > 0:
        take_noise(tick, episode.place, noise, own)
    # Only effects ask for the time, and then it is the same in all copies.
    go_to_tick(int(lead(tick[0])), dt, steps, numbers, effects, brace, own)
    if not is_near(numbers, brace):
        return LOST
    start, way = episode.reference[0], episode.reference[1]
    calc_cubic(tick[0] * (dt * steps), duration, start, way, episode.desired)
    place_rows(episode.desired, controller.desired)
    return advance_controllers(
        controller, brace.readings, episode.stiffness, brace.u
    )


_array3 = float64[:, :, ::1]


@compiled_when_called(
    (
        float64, int64, stacked_kind(NUMBERS), EFFECTS, stacked_kind(BRACE),
        stacked_kind(CONTROLLER), stacked_kind(EPISODE), _array3,
        types.Tuple((int64, float64, float64)), matrix,
    ),
    **MAKER,
)  # fmt: skip
def run_decisions_of_copies(
    dt, steps, numbers, effects, brace, controller, episode, noise, times, out
):
    """A generator: goes to the next decision of all copies, yields, and so on.

    What the caller writes into the arrays between two decisions counts from
    then on; another episode can take a copy's place. Copies with effects must
    be at the same tick.

    Args:
        dt, steps: Step of the plant, s; steps in a control period.
        numbers, brace, controller, episode: Of the copies, see
            `lanes.stack_copies`; after the first tick, updated.
        effects: Of the copies; states are updated.
        noise: Of the readings at each tick (places, ticks, 9n + 3), or
            (0, 0, 9n + 3).
        times: Ticks from one decision to the next, control period, s, and
            duration of the desired motion, s.
        out: Takes the reports (57n, COUNT), see `report_copies`.

    Yields:
        GOOD, or what broke down in one of the copies; then none is of use.
    """
    many, period, duration = times
    while True:
        result = GOOD
        for _ in range(many):
            result = perform_tick(
                dt, steps, duration, lanes_of(numbers), effects,
                lanes_of(brace), lanes_of(controller), lanes_of(episode),
                noise,
            )  # fmt: skip
            if result != GOOD:
                break
        if result == GOOD:
            own = lanes_of(episode)
            report_copies(
                own.tick[0] * period, duration, lanes_of(numbers),
                lanes_of(brace), lanes_of(controller), own, lanes_of(out),
            )  # fmt: skip
        yield result
