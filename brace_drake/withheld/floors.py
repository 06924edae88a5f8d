"""How large an effect is, in noise floors, measured in the stand-in itself.

The same runs with ideal instruments, once with the effect and once without,
the subject unchanged. Their difference, channel by channel, is divided by the
noise of that channel, as the control loop carries it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from brace_drake.withheld.stand_in.bench import COLUMNS, run_bench
from brace_drake.withheld.stand_in.flaws import Flaws
from brace_drake.withheld.stand_in.motions import Motion
from brace_drake.withheld.stand_in.numbers import Subject

_STEP = 0.02  # of a subject's number, relative


class Size(NamedTuple):
    """Of a gap, in floors.

    Attributes:
        rms: Over all runs and channels.
        largest: Of the channel and run that show it most.
        refitted: `rms` after the subject's numbers have taken what they can.
    """

    rms: float
    largest: float
    refitted: float


def noise_floor(
    motions: list[Motion], subject: Subject, seed: int
) -> np.ndarray:
    """Root mean square of the noise, per channel, with and without torso.

    Returns:
        (2, channels): free runs, runs with the torso.
    """
    floor = np.empty((2, len(COLUMNS)))
    for contact in (False, True):
        motion = next(m for m in motions if m.contact == contact)
        noisy, ideal = (
            run_bench(
                motion.wanted,
                contact,
                subject,
                Flaws(),
                np.random.default_rng(seed),
                noise,
            )
            for noise in (True, False)
        )
        floor[int(contact)] = np.sqrt(np.mean((noisy - ideal) ** 2, axis=0))
    return floor


def ideal_runs(
    motions: list[Motion],
    subject: Subject,
    flaws: Flaws,
    floor: np.ndarray,
    seed: int,
) -> list[np.ndarray]:
    """Every run with ideal instruments, in floors."""
    runs = []
    for i, motion in enumerate(motions):
        log = run_bench(
            motion.wanted,
            motion.contact,
            subject,
            flaws,
            np.random.default_rng([seed, i]),
            False,
        )
        runs.append(log / floor[int(motion.contact)])
    return runs


def measure(
    motions: list[Motion],
    subject: Subject,
    before: Flaws,
    after: Flaws,
    seed: int,
) -> Size:
    """The size of what stands between two benches with the same subject."""
    motions = [m for m in motions if m.repeat_of is None]
    floor = noise_floor(motions, subject, seed)
    reference = ideal_runs(motions, subject, before, floor, seed)
    changed = ideal_runs(motions, subject, after, floor, seed)
    gap = [b - a for a, b in zip(reference, changed, strict=True)]
    power = np.array([np.mean(g**2, axis=0) for g in gap])
    return Size(
        rms=float(np.sqrt(power.mean())),
        largest=float(np.sqrt(power.max())),
        refitted=_refitted(
            motions, subject, before, floor, seed, reference, gap
        ),
    )


def _refitted(motions, subject, before, floor, seed, reference, gap) -> float:
    """The gap's rms once the subject is refitted, to first order."""
    stacked = np.concatenate([g.ravel() for g in gap])
    columns = []
    for name, value in subject._asdict().items():
        other = subject._replace(**{name: value * (1.0 + _STEP)})
        worn = [m for m in motions if m.contact]
        runs = iter(ideal_runs(worn, other, before, floor, seed))
        columns.append(
            np.concatenate(
                [
                    (next(runs) - r if m.contact else 0.0 * r).ravel()
                    for m, r in zip(motions, reference, strict=True)
                ]
            )
        )
    S = np.column_stack(columns)
    fit = np.linalg.lstsq(S, stacked, rcond=None)[0]
    return float(np.sqrt(np.mean((stacked - S @ fit) ** 2)))
