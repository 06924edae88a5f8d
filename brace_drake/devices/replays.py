"""Replays of a run by a twin: exact ones, and the mean of noisy ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.devices.twin import Request
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


def without_dither(uses: Sequence[Use], off: Sequence[Use]) -> tuple[Use, ...]:
    """Effects but those that noise dithers, and numbers that are off: these
    leave dry friction as it is.
    """
    smooth = tuple(u for u in uses if not u[0].dithered)
    return (*smooth, *((replace(e, dithered=False), v) for e, v in off))


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

    Raises:
        BraceError: One broke down.
    """
    if noisy == 0:
        return twin.simulate(motion, subject, uses)
    request = Request(motion, subject, uses)
    return simulate_noisy(
        twin, request, [(seed, i) for i in range(noisy)]
    ).mean(axis=0)


def simulate_noisy(
    twin, request: Request, seeds: Sequence[Sequence[int]]
) -> np.ndarray:
    """Replays of a run with noise of several seeds (n, N, C).

    Raises:
        BraceError: One broke down.
    """
    logs = twin.simulate_each(
        [request._replace(seed=tuple(seed)) for seed in seeds]
    )
    for log, seed in zip(logs, seeds, strict=True):
        if log is None:
            # Alone it says why.
            generator = np.random.default_rng(list(seed))
            twin.simulate(
                request.motion, request.subject, request.uses, generator
            )
            raise BraceError("a simulated run with noise broke down")
    return np.array(logs)


def replay_each(
    twin, requests: Sequence[Request], noisy: Sequence[int]
) -> list[np.ndarray | None]:
    """Several runs by a twin, see `replay`; None where it broke down.

    Args:
        twin: See `ReplayTwin.simulate_each`.
        requests: The runs; a seed is that of all noisy replays of a run.
        noisy: How many of each, 0: an exact one.
    """
    asked, ends = [], []
    for request, number in zip(requests, noisy, strict=True):
        seeds = [(*request.seed, i) for i in range(number)] or [None]
        asked += [request._replace(seed=seed) for seed in seeds]
        ends.append(len(asked))
    logs = twin.simulate_each(asked)
    found: list[np.ndarray | None] = []
    for start, end in zip([0, *ends], ends, strict=False):
        own = logs[start:end]
        if any(log is None for log in own):
            found.append(None)
        else:
            found.append(own[0] if len(own) == 1 else np.mean(own, axis=0))
    return found
