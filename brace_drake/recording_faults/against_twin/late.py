"""Readings that no controller sees and that all runs have late.

Little of a marker's delay shows: the subject's damping takes most of it. But a
twin that is right leaves noise alone in every reading, and the subject is
fitted anew with each delay undone.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.devices.declaration import Device
from brace_drake.effects.stack import Use
from brace_drake.identification.evaluation import PreparedRun
from brace_drake.recording_faults.against_twin.misfit import SubjectFit
from brace_drake.recording_faults.against_twin.readings import (
    read_runs,
    unread_channels,
)
from brace_drake.recording_faults.against_twin.refitter import Refitter
from brace_drake.recording_faults.against_twin.undone import late
from brace_drake.recording_faults.finding import MOST_PROBABLE, Finding
from brace_drake.recording_faults.library.time import skewed_channel

# Mean square, in floors, from which on a reading is looked at.
_STANDS_OUT = 1.2
# Part of what a reading leaves beyond noise that a delay may leave of it.
_TOLD = 0.25
# Delays that are tried first, samples; the best is refined by single ones.
_DELAYS = (2, 4, 8, 16, 32)


def find_late_readings(
    device: Device,
    runs: Sequence[PreparedRun],
    fit: SubjectFit,
    uses: Sequence[Use],
    jobs,
) -> list[Finding]:
    """A delay of the unread readings of one instrument, in all runs.

    Args:
        device: With a control law.
        runs: To be judged, their weights as in the fit.
        fit: Of the subject to all of them.
        uses: Effects that are there, held.
        jobs: As of `Evaluator`.
    """
    contact = [p for p in runs if p.run.contact]
    recorded = set.intersection(*(set(p.run.channels) for p in contact or runs))
    group = tuple(
        n
        for n in unread_channels(device)
        if n.startswith("torso_") and n in recorded
    )
    if not (group and contact):
        return []

    def worst(fit: SubjectFit, runs: Sequence[PreparedRun]) -> float:
        readings = read_runs(device, fit.evaluator, runs, fit.subject, uses)
        found = [r.unread(group) for r in readings]
        return max(
            float(np.mean([f[n] for f in found if n in f] or [0.0]))
            for n in group
        )

    before = worst(fit, contact)
    if before < _STANDS_OUT:
        return []
    refitter = Refitter(device, (), runs, fit.subject, uses, jobs)
    h = float(np.median(np.diff(contact[0].run.time_s)))
    place = _best_delay(refitter, group, h)
    if place == 0:
        return []
    suspect = late(group, place, h)
    undone = refitter.undone(suspect)
    again = refitter.fit(undone)
    if again is None:
        return []
    after = worst(again, [p for p in undone if p.run.contact])
    if after - 1.0 > _TOLD * (before - 1.0):
        return []
    return [
        Finding(
            skewed_channel.CARD,
            tuple(p.run.file for p in runs),
            group,
            dict(suspect.hypothesis.parameters),
            MOST_PROBABLE,
            f"{1e3 * place * h:.3g} ms late; {np.sqrt(before):.3g} noise floors"
            f" off the twin that fits best, {np.sqrt(after):.3g} with it"
            " undone",
            of_all=len(runs) > 1,
            before=before,
            after=after,
        )
    ]


def _best_delay(
    refitter: Refitter, group: tuple[str, ...], period: float
) -> int:
    """The delay in samples that leaves least; 0: none."""

    def left(place: int) -> float:
        if place not in found:
            found[place] = refitter.misfit(late(group, place, period))
        return found[place]

    found = {0: refitter.misfit()}
    for place in _DELAYS:
        for sign in (1, -1):
            left(sign * place)
    step = max(1, abs(min(found, key=found.__getitem__)) // 2)
    while step:
        best = min(found, key=found.__getitem__)
        left(best - step)
        left(best + step)
        if min(found, key=found.__getitem__) == best:
            step //= 2
    return min(found, key=found.__getitem__)
