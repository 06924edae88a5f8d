"""The odd ones out: runs without which the twin fits all others far better."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.devices.declaration import Device
from brace_drake.effects.stack import Use
from brace_drake.identification.evaluation import PreparedRun
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.prepare import estimate_floors, prepare_runs
from brace_drake.recording.recording import Campaign, Run
from brace_drake.recording_faults.against_twin.refitter import Refitter
from brace_drake.recording_faults.against_twin.subjects import TIMES

# Runs that are accused together; rows that are fitted, and that are explained,
# at most.
_MOST_ODD, _FITTED_ROWS, _ROWS = 2, 300_000, 30_000


class Maker(NamedTuple):
    """How a device is had from some of the runs alone.

    Attributes:
        make: The device of a campaign of these.
        explain: The best fit that effects come to on its prepared runs.
    """

    make: Callable[[Campaign], Device]
    explain: Callable[[Device, Sequence[PreparedRun]], CandidateFit]


def find_odd_ones(
    campaign: Campaign, maker: Maker, seed: int, jobs
) -> Refitter | None:
    """The fewest runs without which the twin fits the others far better; None
    where there are none.

    Where no twin without effects does, the others are explained first: of the
    run that is least like them, of all where they are short.

    Args:
        campaign: With all fit runs.
        maker, seed: As of `find_undone`.
        jobs: As of `Evaluator`.
    """
    runs = campaign.split("fit")
    rows = sum(len(r.time_s) for r in runs)
    likely: list[tuple[float, int, Sequence[Run]]] = []
    for number in range(1, len(runs) - 1):
        every = list(itertools.combinations(runs, number))
        is_dear = len(every) * rows > _FITTED_ROWS
        if number > _MOST_ODD or 2 * number > len(runs) or is_dear:
            break
        found = []
        for few in every:
            one = _without(campaign, few, maker, seed, jobs)
            if one is None:
                continue
            less = one.misfit() / one.level
            if less > TIMES:
                found.append((one.level, len(found), one))
            if number == 1:
                likely.append((-less, len(likely), few))
        if found:
            return min(found)[-1]
    for _, _, few in sorted(likely)[: max(1, _ROWS // rows)]:
        one = _without(campaign, few, maker, seed, jobs, explained=True)
        if one is not None and one.misfit() > TIMES * one.level:
            return one
    return None


def _without(
    campaign: Campaign,
    few: Sequence[Run],
    maker: Maker,
    seed: int,
    jobs,
    explained: bool = False,
) -> Refitter | None:
    """Accused runs beside the others, as a device sees them that knows nothing
    of these; None where it cannot be made of the others.
    """
    rest = [r for r in campaign.split("fit") if r not in few]
    part = replace(campaign, runs=tuple(rest))
    try:
        device = maker.make(part)
    except BraceError:
        return None
    twin = device.twin
    subject = np.array([p.nominal for p in twin.subject])
    floors, _ = estimate_floors(twin, part, subject, seed)
    if any(r.contact not in floors for r in few):
        return None
    runs = prepare_runs(twin, [*rest, *few], floors, device.rate, seed)
    sound, accused = runs[: len(rest)], runs[len(rest) :]
    uses: Sequence[Use] = ()
    if explained:
        fit = maker.explain(device, sound)
        subject, uses = fit.subject, fit.uses
    return Refitter(device, sound, accused, subject, uses, jobs)
