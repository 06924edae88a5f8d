"""Replays of a run by a twin: exact ones, and the mean of noisy ones."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.effects.stack import Use


def uses_in_run(uses: Sequence[Use], index: int) -> tuple[Use, ...]:
    """Effects with the parameters that they have in one run."""
    return tuple((e, e.in_run(values, index)) for e, values in uses)


def is_dithered(twin, uses: Sequence[Use]) -> bool:
    """Whether a twin with these effects is averaged over noisy replays.

    Where readings feed a loop, their noise moves the machine; what that does
    to effects such as dry friction has to be averaged.
    """
    rough = any(effect.dithered for effect, _ in (*twin.carried, *uses))
    return rough and twin.has_loop


def replay(
    twin,
    motion,
    seed: int,
    subject: np.ndarray,
    uses: Sequence[Use],
    noisy: int,
) -> np.ndarray:
    """A run by a twin (N, C): the mean of noisy replays, 0: an exact one.

    Args:
        twin, motion: See `ReplayTwin.simulate`.
        seed: Of the noise.
        subject, uses: As there.
        noisy: How many replays.
    """
    if noisy == 0:
        return twin.simulate(motion, subject, uses)
    replays = [
        twin.simulate(motion, subject, uses, np.random.default_rng([seed, i]))
        for i in range(noisy)
    ]
    return np.mean(replays, axis=0)


def replay_each(
    twin,
    motion,
    seed: int,
    points: Sequence[tuple[np.ndarray, Sequence[Use]]],
    noisy: Sequence[int],
) -> list[np.ndarray | None]:
    """`replay` at several points; None where the twin broke down."""
    found: dict[int, np.ndarray | None] = {}
    for number in sorted(set(noisy)):
        places = [k for k, own in enumerate(noisy) if own == number]
        some = [points[k] for k in places]
        seeds = [[seed, i] for i in range(number)] or [None]
        each = [twin.simulate_each(motion, some, s) for s in seeds]
        for k, logs in zip(places, zip(*each, strict=True), strict=True):
            if any(log is None for log in logs):
                found[k] = None
            else:
                found[k] = np.mean(logs, axis=0) if number else logs[0]
    return [found[k] for k in range(len(points))]
