"""A run that holds the samples of another one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from brace_drake.recording.columns import Channel
from brace_drake.recording.recording import Run
from brace_drake.recording_faults.card import FaultParameter, RecordingFault
from brace_drake.recording_faults.channels import noisy_channels
from brace_drake.recording_faults.finding import Finding
from brace_drake.recording_faults.library.runs.shared_noise import (
    compare_noise,
    noise_of,
)
from brace_drake.recording_faults.statistics import unlikely_blocks

CARD = RecordingFault(
    name="copied_run",
    title="a copy of another run",
    law="rec(n) = other(n + m)",
    signature="rows that are alike to the last digit of every noisy channel, or"
    " noise that is the other's",
    remedy="record the run; a copy shows no noise, and validates nothing",
    parameters=(
        FaultParameter("share", "1", "of the rows that are the other's"),
        FaultParameter("noise", "1", "correlation with the other's noise"),
    ),
    is_of_run=True,
)
_SHARE = 0.2
# Rows of its own that a run must have to be told by them.
_LEAST = 20
# Digits that noise has are many: two channels and more tell rows apart.
_CHANNELS = 2
# Noise of two runs is one where it is so much alike, and more than so many
# times what chance makes of N samples, 1 / sqrt(N).
_ALIKE, _CHANCE = 0.5, 6.0
# At any other delay it is alike by at most this part of that.
_ELSEWHERE = 0.5


def find_copies(
    runs: Sequence[Run], known: Mapping[str, Channel]
) -> list[Finding]:
    """Runs whose rows another run holds too, or whose noise."""
    found = []
    noises = [_noises(run, known) for run in runs]
    for i, run in enumerate(runs):
        for k, other in enumerate(runs[:i]):
            share = shared_rows(run, other, known)
            is_same = share >= _SHARE
            noise = 0.0 if is_same else shared_noise(noises[i], noises[k])
            if not is_same and not noise:
                continue
            across = run.split != other.split
            copy = run if run.split == "validation" or not across else other
            of = other if copy is run else run
            detail = f"{100 * share:.3g} % of its rows are those of {of.file}"
            if noise:
                detail = (
                    f"its noise is that of {of.file}, with a correlation of"
                    f" {noise:.2g}"
                )
            if across:
                detail += ", which is fitted: it does not count as validation"
            values = {"noise": noise} if noise else {"share": share}
            found.append(Finding(CARD, (copy.file,), (), values, detail=detail))
    return found


def _noises(run: Run, known: Mapping[str, Channel]) -> dict[str, np.ndarray]:
    """Noise of each reading; what is computed from readings has none."""
    found = {
        name: noise_of(run.channels[name])
        for name in noisy_channels(run, known)
        if "command" not in name and "virtual" not in name
    }
    return {name: noise for name, noise in found.items() if noise is not None}


def shared_noise(
    mine: Mapping[str, np.ndarray], others: Mapping[str, np.ndarray]
) -> float:
    """Size of the correlation of two runs' noise; 0 where it is not one.

    Two readings have to say so, by the same delay, where there are two.

    Args:
        mine, others: Noise of readings by name.
    """
    names = [name for name in mine if name in others]
    told = []
    for name in names:
        seen = compare_noise(mine[name], others[name])
        if seen is None:
            continue
        alike = min(abs(seen.correlation), abs(seen.typical))
        rows = min(len(mine[name]), len(others[name]))
        least = max(_ALIKE, _CHANCE / np.sqrt(rows))
        if alike > max(least, seen.elsewhere / _ELSEWHERE):
            told.append((seen.delay, abs(seen.correlation)))
    delays = [delay for delay, _ in told]
    most = max(delays, key=delays.count, default=0)
    agreed = [alike for delay, alike in told if abs(delay - most) <= 1]
    return max(agreed) if len(agreed) >= min(_CHANNELS, len(names)) > 0 else 0.0


def shared_rows(run: Run, other: Run, known: Mapping[str, Channel]) -> float:
    """Share of a run's rows that another one has, by noisy channels."""
    mine = noisy_channels(run, known)
    names = [
        n
        for n in mine
        if n in noisy_channels(other, known)
        and np.ptp(run.channels[n]) > 0.0
        and np.ptp(other.channels[n]) > 0.0
    ]
    # A fault of one channel leaves the others. Lengths alone are too coarse: at
    # rest they are alike by chance.
    commands = [n for n in names if "command" in n] or names
    forces = [n for n in names if n not in commands and n.endswith("_N")]
    rest = [n for n in names if n not in commands] if forces else []
    shares = [
        _share(run.stack(some), other.stack(some))
        for some in (commands, rest)
        if len(some) >= _CHANNELS
    ]
    return max(shares, default=0.0)


def _share(a: np.ndarray, b: np.ndarray) -> float:
    """Share of the rows that occur once in a run (N, C) which another one has
    in the same order (M, C).

    Readings at rest are alike by chance where their steps are coarse; these
    occur more than once.
    """
    both = np.concatenate([b, a]) + 0.0
    _, inverse = np.unique(both, axis=0, return_inverse=True)
    theirs, mine = np.split(inverse.ravel(), [len(b)])
    number = np.bincount(mine, minlength=len(both))
    once = np.flatnonzero(number[mine] == 1)
    if len(once) < _LEAST:
        return 0.0
    place = np.full(len(both), -1)
    place[theirs] = np.arange(len(b))
    found = place[mine[once]]
    # Never 0 where there is an equal.
    lags = np.where(found < 0, 0, once - found + len(b))
    told = sum(end - begin for begin, end in unlikely_blocks(lags))
    return told / len(once)
