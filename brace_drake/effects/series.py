"""Effects on a signal, sample by sample."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from brace_drake.effects.stack import Use, stack_effects
from brace_drake.laws.alone.signal_chain import pass_signal

# Longest step of what happens to a command on its way, s.
_FINE_S = 1e-3


def pass_series(
    values: np.ndarray, dt: float, size: float, uses: Sequence[Use]
) -> np.ndarray:
    """What arrives of a signal (N,).

    Args:
        values: That was sent (N,).
        dt: Step, s.
        size: That it is counted in.
        uses: Effects on it, with the parameters of reference.
    """
    plug = stack_effects(uses)["signal"]
    out = np.array(values) / size
    pass_signal(
        dt,
        out,
        plug.laws,
        plug.parameters,
        plug.fresh_memory(),
        np.array(plug.active),
    )
    return size * out


def held_commands(
    commands: np.ndarray,
    period: float,
    steps: int,
    sizes: Sequence[float],
    uses: Mapping[int, Sequence[Use]],
) -> np.ndarray:
    """Commands of every step of a run (N * steps, I): each is held from its
    sample to the next; what effects make of them between is averaged.

    Args:
        commands: Samples (N, I).
        period: Between two of them, s.
        steps: Of the run between two of them.
        sizes: That each is counted in (I,).
        uses: Effects on those that have any, by their place.
    """
    held = np.repeat(commands, steps, axis=0)
    fine = max(1, math.ceil(period / steps / _FINE_S))
    for i, own in uses.items():
        sent = np.repeat(commands[:, i], steps * fine)
        dt = period / steps / fine
        arrived = pass_series(sent, dt, sizes[i], own)
        held[:, i] = arrived.reshape(-1, fine).mean(axis=1)
    return held
