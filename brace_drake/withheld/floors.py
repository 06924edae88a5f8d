"""How large an effect is, in noise floors, measured in the simulator itself.

The same runs with ideal instruments, once with the effect and once without,
the subject unchanged. Their difference, channel by channel, is divided by the
noise of that channel, as the control loop carries it.
"""

from __future__ import annotations

import functools
from typing import NamedTuple

import numpy as np

from brace_drake.withheld.simulator import (
    COLUMNS,
    Flaws,
    Motion,
    Subject,
    make_motions,
    run_bench,
)

_STEP = 0.02  # of a subject's number, relative
_STEPS = 5  # of the integration in a tick; both benches err alike
# The runs that tell most for their time.
RUNS = ("free_multisine", "push", "stairs", "multisine")


class Size(NamedTuple):
    """Of a gap, in floors.

    Attributes:
        rms: Over the runs of RUNS and all channels.
        largest: Of the channel and run that show it most.
        refitted: `rms` after the subject's numbers have taken what they can,
            to first order; None where that was not asked for.
    """

    rms: float
    largest: float
    refitted: float | None


@functools.cache
def noise_floor() -> np.ndarray:
    """Root mean square of the nominal bench's noise, per channel.

    Returns:
        (2, channels): free runs, runs with the torso.
    """
    motions = {m.name: m for m in make_motions(np.random.default_rng(0))}
    floor = np.empty((2, len(COLUMNS)))
    for contact, name in enumerate(("free_multisine", "push")):
        runs = [
            run_bench(
                motions[name].wanted,
                bool(contact),
                Subject(),
                Flaws(),
                np.random.default_rng(0),
                noise,
            )
            for noise in (True, False)
        ]
        floor[contact] = np.sqrt(np.mean((runs[0] - runs[1]) ** 2, axis=0))
    return floor


def ideal_run(
    motion: Motion, subject: Subject, flaws: Flaws, seed: int
) -> np.ndarray:
    """A run with ideal instruments, in floors."""
    log = run_bench(
        motion.wanted,
        motion.contact,
        subject,
        flaws,
        np.random.default_rng(seed),
        False,
        _STEPS,
    )
    return log / noise_floor()[int(motion.contact)]


def measure(
    motions: list[Motion],
    subject: Subject,
    before: Flaws,
    after: Flaws,
    refit: bool = True,
) -> Size:
    """The size of what stands between two benches with the same subject."""
    motions = [m for m in motions if m.name in RUNS]
    reference = [
        ideal_run(m, subject, before, i) for i, m in enumerate(motions)
    ]
    gap = [
        ideal_run(m, subject, after, i) - reference[i]
        for i, m in enumerate(motions)
    ]
    power = np.array([np.mean(g**2, axis=0) for g in gap])
    rest = None
    if refit:
        rest = _refitted(motions, subject, before, reference, gap)
    rms, largest = np.sqrt(power.mean()), np.sqrt(power.max())
    return Size(float(rms), float(largest), rest)


def _refitted(motions, subject, before, reference, gap) -> float:
    """The gap's rms once the subject is refitted, to first order."""
    columns = []
    for name, value in subject._asdict().items():
        other = subject._replace(**{name: value * (1.0 + _STEP)})
        moved = [
            ideal_run(m, other, before, i) - reference[i]
            if m.contact
            else np.zeros_like(reference[i])
            for i, m in enumerate(motions)
        ]
        columns.append(np.concatenate(moved).ravel())
    S, gaps = np.column_stack(columns), np.concatenate(gap).ravel()
    fit = np.linalg.lstsq(S, gaps, rcond=None)[0]
    return float(np.sqrt(np.mean((gaps - S @ fit) ** 2)))
