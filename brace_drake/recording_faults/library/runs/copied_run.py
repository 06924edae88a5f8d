"""A run that holds the samples of another one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from brace_drake.recording.columns import Channel
from brace_drake.recording.recording import Run
from brace_drake.recording_faults.card import FaultParameter, RecordingFault
from brace_drake.recording_faults.channels import noisy_channels
from brace_drake.recording_faults.finding import Finding

CARD = RecordingFault(
    name="copied_run",
    title="a copy of another run",
    law="rec(n) = other(n + m)",
    signature="rows that are alike to the last digit of every noisy channel",
    remedy="record the run; a copy shows no noise, and validates nothing",
    parameters=(
        FaultParameter("share", "1", "of the rows that are the other's"),
    ),
    is_of_run=True,
)
_SHARE = 0.2
# Digits that noise has are many: two channels and more tell rows apart.
_CHANNELS = 2


def find_copies(
    runs: Sequence[Run], known: Mapping[str, Channel]
) -> list[Finding]:
    """Runs whose rows another run holds too."""
    found = []
    for i, run in enumerate(runs):
        for other in runs[:i]:
            share = shared_rows(run, other, known)
            if share < _SHARE:
                continue
            across = run.split != other.split
            copy = run if run.split == "validation" or not across else other
            of = other if copy is run else run
            detail = f"{100 * share:.3g} % of its rows are those of {of.file}"
            if across:
                detail += ", which is fitted: it does not count as validation"
            found.append(
                Finding(
                    CARD,
                    (copy.file,),
                    (),
                    {"share": share},
                    detail=detail,
                )
            )
    return found


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
    theirs = {row.tobytes() for row in np.ascontiguousarray(b + 0.0)}
    alike = sum(r.tobytes() in theirs for r in np.ascontiguousarray(a + 0.0))
    # Readings at rest are alike by chance where their steps are coarse: what a
    # run shares with itself says how often.
    distinct = len({row.tobytes() for row in np.ascontiguousarray(a + 0.0)})
    return alike / len(a) * (distinct / len(a))
