"""The bench for its user: hand it a motion, it hands back a recording."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from brace_drake.withheld.simulator import control, numbers
from brace_drake.withheld.simulator.chance import draw
from brace_drake.withheld.simulator.flaws import Flaws
from brace_drake.withheld.simulator.numbers import Subject
from brace_drake.withheld.simulator.recorder import NUM_COLUMNS, advance_run
from brace_drake.withheld.simulator.run import Run, begin_run

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

# From a tick and the run after it to the desired stiffness along y, N/m.
Decide = Callable[[int, Run], float]


def run_bench(
    wanted: np.ndarray,
    contact: bool,
    subject: Subject,
    flaws: Flaws,
    rng: np.random.Generator,
    noise: bool = True,
    steps: int = numbers.STEPS,
    decide: Decide | None = None,
    every: int = 50,
) -> np.ndarray:
    """Records a run at 200 Hz.

    Args:
        wanted: Reference y, y', y'' at 1 kHz, (n, 3), SI units.
        contact: Whether the torso is there.
        subject: The wearer.
        flaws: What is wrong.
        rng: Of everything random; the same one gives the same run.
        noise: False for ideal instruments, which do not round either.
        steps: Of the integration in a tick.
        decide: Sets the desired stiffness along y after every `every` ticks,
            the first included; until then it is the data sheet's.
        every: Ticks between decisions.

    Returns:
        (n / 5, 19) in the order of COLUMNS.
    """
    nominal = np.stack([numbers.lower_joints(), numbers.upper_joints()])
    real = nominal + np.array([flaws.ring.lower, flaws.ring.upper])
    run_rng, marker_rng = rng.spawn(2)
    n = len(wanted)
    random = draw(run_rng, n, flaws, noise)
    log = np.empty(
        ((n + numbers.LOG_EVERY - 1) // numbers.LOG_EVERY, NUM_COLUMNS)
    )
    wanted = np.ascontiguousarray(wanted)
    run = begin_run(n, contact, subject, flaws, real, random[2])
    ends = [n] if decide is None else [*range(1, n, every), n]
    for first, last in pairwise([0, *ends]):
        if decide is not None and first > 0:
            _set_stiffness(run, decide(first - 1, run))
        advance_run(
            first,
            last,
            run,
            wanted,
            contact,
            subject,
            flaws,
            real,
            nominal,
            noise,
            steps,
            random,
            log,
        )
    if noise:
        log[:, 15:18] += numbers.MARKER_NOISE * marker_rng.standard_normal(
            (len(log), 3)
        )
    return log


def _set_stiffness(run: Run, stiffness: float) -> None:
    """Another spring along y, and the damper that is critical for it."""
    run.memory[control.STIFFNESS] = stiffness
    run.memory[control.DAMPING] = 2.0 * np.sqrt(
        numbers.DESIRED_MASS * stiffness
    )
