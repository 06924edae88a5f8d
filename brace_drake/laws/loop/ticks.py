"""The step of a brace from one tick to the next, and who goes tick by tick.

At a tick the instruments read; then, when the commands have come, the plant
moves until the next tick. With the controller inside it is `laws.loop.rollout`
that takes these steps. `numbers`, `effects` and `brace` are as
`laws.loop.forces` takes them.
"""

import math

from numba import float64, int64

from brace_drake.laws.compiled import (
    MAKER,
    compiled_law,
    compiled_when_called,
)
from brace_drake.laws.hooks import EFFECTS, MAX_EFFECTS, SENSING, vector
from brace_drake.laws.lanes.functions import lead
from brace_drake.laws.loop.brace import BRACE, is_near
from brace_drake.laws.loop.effect_calls import call_sensing
from brace_drake.laws.loop.forces import add_forces, press_pads
from brace_drake.laws.numbers import NUMBERS
from brace_drake.laws.rigid_body import step_free_body_at


@compiled_law
def measure(numbers, brace):
    """Writes what exact instruments read."""
    n, out = numbers.rest.shape[0], brace.readings
    for k in range(6 * n):
        out[k] = brace.lengths[k]
    for i in range(n):
        for c in range(3):
            out[6 * n + 3 * i + c] = brace.f_T[i, c]
    for c in range(3):
        out[9 * n + c] = brace.poses[n, 4 + c] - numbers.torso_rest[c]


@compiled_law
def round_readings(resolution, noise, out):
    """Turns ideal values into readings, in place: noise, then rounding.

    Args:
        resolution: Of lengths, m, and forces, N; 0 is not rounded (2,).
        noise: Of lengths, forces and marker, as `out`; empty, or NaN in the
            first place: exact readings, neither noisy nor rounded.
        out: Of n stages lengths (6n), m, forces (3n), N, marker (3), m.
    """
    if noise.shape[0] == 0 or math.isnan(lead(noise[0])):
        return
    end = out.shape[0] - 3
    for k in range(end):
        step = resolution[0] if k < 2 * end // 3 else resolution[1]
        out[k] += noise[k]
        if lead(step) > 0.0:
            out[k] = step * round(out[k] / step)
    for k in range(end, end + 3):
        out[k] += noise[k]


@compiled_law
def read(t, period, numbers, effects, brace, noise):
    """Writes what the instruments read at a tick: effects, noise, rounding."""
    n, out = numbers.rest.shape[0], brace.readings
    measure(numbers, brace)
    for e in range(MAX_EFFECTS):
        if effects.active[SENSING, e]:
            for i in range(n):
                a, b = 6 * i, 6 * i + 6
                at = 6 * n + 3 * i
                call_sensing(
                    effects, e, i, t, period, brace.u[a:b], out[a:b],
                    out[at : at + 3],
                )  # fmt: skip
    round_readings(numbers.resolution, noise, out)
    if not brace.present[0]:
        out[9 * n : 9 * n + 3] = 0.0


@compiled_law
def step_bodies(dt, numbers, brace):
    """Moves the bodies by a step of the plant under their forces."""
    n = numbers.rest.shape[0]
    if brace.present[0]:
        step_free_body_at(
            brace.R[n], brace.poses[n, 0:4], brace.poses[n, 4:7], brace.V[n],
            numbers.torso, brace.F[n], dt,
        )  # fmt: skip
    for i in range(n):
        brace.F[i, 5] -= numbers.ring[i, 4]
        step_free_body_at(
            brace.R[i], brace.poses[i, 0:4], brace.poses[i, 4:7], brace.V[i],
            numbers.ring[i], brace.F[i], dt,
        )  # fmt: skip


@compiled_law
def go_to_tick(tick, dt, steps, numbers, effects, brace, noise):
    """Takes a brace from the tick before to a tick, and reads there.

    Args:
        tick: Its number; at 0 nothing moves.
        dt, steps: Step of the plant, s; steps in a tick.
        numbers, effects, brace: See the module; commands are held in `brace`.
        noise: Of the readings, see `round_readings`.
    """
    period = dt * steps
    t = tick * period
    for step in range(1, steps + 1):
        at = t
        if tick > 0:
            before = (tick - 1) * period + (step - 1) * dt
            add_forces(before, dt, numbers, effects, brace)
            step_bodies(dt, numbers, brace)
            if step < steps:
                at = (tick - 1) * period + step * dt
        press_pads(at, dt, numbers, effects, brace)
        if tick == 0:
            break
    read(t, period, numbers, effects, brace, noise)


@compiled_when_called(
    (float64, int64, NUMBERS, EFFECTS, BRACE, vector), **MAKER
)  # fmt: skip
def run_ticks(dt, steps, numbers, effects, brace, noise):
    """A generator: goes to a tick, reads, yields, and so on.

    What the caller writes into arrays between two ticks, commands above all,
    counts from then on. (Handing over functions to compiled code at each tick
    would cost a thousand times what a tick does.)

    Args:
        dt ... noise: As in `go_to_tick`.

    Yields:
        Whether all bodies are near their places at rest.
    """
    tick = 0
    while True:
        go_to_tick(tick, dt, steps, numbers, effects, brace, noise)
        yield is_near(numbers, brace)
        tick += 1


@compiled_when_called((float64, vector, NUMBERS, EFFECTS, BRACE), **MAKER)
def run_forces(dt, time, numbers, effects, brace):
    """A generator: forces and exact readings of a brace as it is now.

    Args:
        dt: By which effects advance their states, s.
        time: Now (1,), s.
        numbers, effects, brace: See the module.
    """
    while True:
        press_pads(time[0], dt, numbers, effects, brace)
        measure(numbers, brace)
        add_forces(time[0], dt, numbers, effects, brace)
        yield 0
