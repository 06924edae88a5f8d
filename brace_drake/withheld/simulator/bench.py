"""The bench for its user: hand it a motion, it hands back a recording.

The controller ticks at 1 kHz, the machine moves in between.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from brace_drake.withheld.simulator import control as controller
from brace_drake.withheld.simulator import numbers
from brace_drake.withheld.simulator.chance import draw
from brace_drake.withheld.simulator.compiled import maker, worker
from brace_drake.withheld.simulator.flaws import Flaws
from brace_drake.withheld.simulator.frame import inverse_mass
from brace_drake.withheld.simulator.instruments import sense
from brace_drake.withheld.simulator.legs import delivered
from brace_drake.withheld.simulator.motion import advance, begin, calc_rates
from brace_drake.withheld.simulator.numbers import (
    LOG_EVERY,
    RING_INERTIA,
    RING_MASS,
    TICK,
    Subject,
)
from brace_drake.withheld.simulator.state import TORSO, Bench, Run, make_run

MUSCLE_TIME = 0.03  # s, from a reflex's nerve signal to force
COLUMNS = (
    *(f"leg{k}_force_command_N" for k in range(1, 7)),
    *(f"leg{k}_length_m" for k in range(1, 7)),
    *(f"ring2_force_{axis}_N" for axis in "xyz"),
    *(f"torso_{axis}_m" for axis in "xyz"),
    "ring2_y_virtual_m",
)
REFERENCE = (
    "ring2_y_desired_m",
    "ring2_vy_desired_m_s",
    "ring2_ay_desired_m_s2",
)


class Decisions(NamedTuple):
    """Who sets the desired stiffness along y during a run.

    Attributes:
        every: Ticks between decisions; the first follows the first tick,
            until then the stiffness is the data sheet's.
        stiffness: From a tick and the run after it to the stiffness, N/m.
    """

    every: int
    stiffness: Callable[[int, Run], float]


def run_bench(
    wanted: np.ndarray,
    contact: bool,
    subject: Subject,
    flaws: Flaws,
    rng: np.random.Generator,
    noise: bool = True,
    steps: int = numbers.STEPS,
    decisions: Decisions | None = None,
) -> np.ndarray:
    """Records a run at 200 Hz.

    Args:
        wanted: Reference y, y', y'' at 1 kHz, (n, 3), SI units.
        contact: Whether the torso is there.
        subject: Who or what is in the brace.
        flaws: What is wrong.
        rng: Of everything random; the same one gives the same run.
        noise: False for ideal instruments, which do not round either.
        steps: Of the integration in a tick.
        decisions: Where someone else sets the stiffness along y.

    Returns:
        (n / 5, 19) in the order of COLUMNS.
    """
    nominal = numbers.lower_joints(), numbers.upper_joints()
    real = nominal[0] + flaws.ring.lower, nominal[1] + flaws.ring.upper
    run_rng, marker_rng = rng.spawn(2)
    n = len(wanted)
    chance = draw(run_rng, n, flaws, noise)
    bench = Bench(contact, subject, flaws, real, nominal, chance, noise, steps)
    run = make_run(n, controller.make_memory())
    begin(bench, run)
    log = np.empty(((n + LOG_EVERY - 1) // LOG_EVERY, len(COLUMNS)))
    wanted = np.ascontiguousarray(wanted)
    starts = [] if decisions is None else range(1, n, decisions.every)
    for first, last in pairwise([0, *starts, n]):
        if decisions is not None and first > 0:
            _set_stiffness(run, decisions.stiffness(first - 1, run))
        run_ticks(first, last, wanted, bench, run, log)
    if noise:
        log[:, 15:18] += numbers.MARKER_NOISE * marker_rng.standard_normal(
            (len(log), 3)
        )
    return log


def _set_stiffness(run: Run, stiffness: float) -> None:
    """Another spring along y, and the damper that is critical for it."""
    run.memory[controller.STIFFNESS] = stiffness
    run.memory[controller.DAMPING] = 2.0 * np.sqrt(
        numbers.DESIRED_MASS * stiffness
    )


@maker
def run_ticks(first, last, wanted, bench, run, log):
    """Performs ticks from `first` to before `last`, the machine in between.

    Args:
        first, last: Ticks.
        wanted: Reference y, y', y'' at 1 kHz (n, 3).
        bench, run: Bench and Run, which is updated.
        log: Output (n / LOG_EVERY, 19), without the marker's noise.
    """
    reading, x = np.empty(9), run.x
    flaws, expansion = bench.flaws, bench.chance.expansion
    mass, leg_mass = RING_MASS + flaws.ring.mass, flaws.ring.leg_mass
    for tick in range(first, last):
        # The force at this instant, of the rates that are not used.
        expansion_at(expansion, tick, 0.0, run.breath[0])
        calc_rates(tick * TICK, x, run.breath[0], bench, run, run.stages[0])
        sense(tick, bench, run, reading)
        run.W[:, :] = inverse_mass(
            run.R[0], run.arm, run.along, mass, RING_INERTIA, leg_mass
        )
        controller.control(tick, reading, wanted[tick], bench.nominal, run)
        run.past[tick, 0] = x[TORSO + 1]
        run.past[tick, 1] = x[TORSO + 7]
        run.push[0] = reflex(tick, run.past, flaws.torso, run.push[0])
        drive(tick, bench, run)
        if tick % LOG_EVERY == 0:
            row = log[tick // LOG_EVERY]
            row[0:6] = run.sent[tick]
            row[6:15] = reading
            row[15:18] = x[TORSO : TORSO + 3]
            row[18] = run.memory[controller.VIRTUAL]
        move(tick, bench, run)


@worker
def expansion_at(expansion, tick, share, out):
    """Writes the expansion within a tick and its rate (2, 2)."""
    for pad in range(2):
        a, b = expansion[tick, pad], expansion[tick + 1, pad]
        out[pad, 0] = a + share * (b - a)
        out[pad, 1] = (b - a) / TICK


@worker
def reflex(tick, past, flaws, push):
    """Muscles' force after this tick, N, from the torso's past (n, 2)."""
    if flaws.reflex_stiffness == 0.0 and flaws.reflex_damping == 0.0:
        return 0.0
    then = tick - round(flaws.reflex_delay / TICK)
    wanted = 0.0
    if then >= 0:
        wanted = -flaws.reflex_stiffness * past[then, 0]
        wanted -= flaws.reflex_damping * past[then, 1]
    return push + (1.0 - math.exp(-TICK / MUSCLE_TIME)) * (wanted - push)


@worker
def drive(tick, bench, run):
    """Writes what the drives deliver (6,) of the commands sent so far."""
    flaws = bench.flaws.legs
    for k in range(6):
        if bench.chance.lost[tick, k] == 0 and tick >= flaws.delay:
            run.held[k] = run.sent[tick - flaws.delay, k]
        run.u[k] = delivered(run.held[k], flaws.gain[k], flaws)


@maker
def move(tick, bench, run):
    """Moves the machine on by one tick."""
    steps, expansion = bench.steps, bench.chance.expansion
    h = TICK / steps
    for step in range(steps):
        for at in range(3):
            share = (step + 0.5 * at) / steps
            expansion_at(expansion, tick, share, run.breath[at])
        advance(tick * TICK + step * h, h, bench, run)
