"""Readings that no controller sees and that all runs have late.

Little of a marker's delay shows: the subject's damping takes most of it. But a
twin that is right leaves noise alone in every reading. Where
a delay would take more than chance of that, by straight lines, the subject is
fitted anew with delays of that sign undone.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.devices.declaration import Device
from brace_drake.effects.stack import Use
from brace_drake.identification.evaluation import PreparedRun
from brace_drake.recording_faults.against_twin.misfit import SubjectFit
from brace_drake.recording_faults.against_twin.readings import (
    Reading,
    read_runs,
    unread_channels,
)
from brace_drake.recording_faults.against_twin.refitter import Refitter
from brace_drake.recording_faults.against_twin.undone import late
from brace_drake.recording_faults.finding import MOST_PROBABLE, Finding
from brace_drake.recording_faults.library.time import skewed_channel
from brace_drake.recording_faults.statistics import largest_normal

# Mean square, in floors, from which on a reading is looked at.
_STANDS_OUT = 1.2
# Part of what a reading leaves beyond noise that a delay may leave of it.
_TOLD = 0.25
# Delays that are tried first, samples; the best is refined by single ones.
_DELAYS = (1, 2, 4, 8, 16, 32)


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

    def off(fit: SubjectFit, runs: Sequence[PreparedRun]) -> list[float]:
        readings = read_runs(device, fit.evaluator, runs, fit.subject, uses)
        return sorted(_beside_noise(readings, n) for n in group)

    *others, before = off(fit, contact)
    if before < _STANDS_OUT:
        return []
    slope = _slope(fit, group, uses)
    if abs(slope) < largest_normal(len(_DELAYS)):
        return []
    refitter = Refitter(device, (), runs, fit.subject, uses, jobs)
    h = float(np.median(np.diff(contact[0].run.time_s)))
    place = _best_delay(refitter, group, h, 1 if slope > 0.0 else -1)
    if place == 0:
        return []
    suspect = late(group, place, h)
    undone = refitter.undone(suspect)
    again = refitter.fit(undone)
    if again is None:
        return []
    *_, after = off(again, [p for p in undone if p.run.contact])
    # A reading in which least moves shows what noise there is.
    quiet = max([1.0, *others[:1]])
    if after - quiet > _TOLD * (before - quiet):
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


def _beside_noise(readings: Sequence[Reading], name: str) -> float:
    """Mean square of a reading off the twin, in floors, or in squares of its
    own noise where that is larger; 0 where no run has it.
    """
    squares = [
        square / max(1.0, r.noise_ratio(name)) ** 2
        for r in readings
        for square in r.unread((name,)).values()
    ]
    return float(np.mean(squares)) if squares else 0.0


def _slope(
    fit: SubjectFit, group: tuple[str, ...], uses: Sequence[Use]
) -> float:
    """How far late readings would leave less, beside what the subject and
    numbers within their tolerances take: in deviations of what a right twin
    leaves; positive where they are late, negative where they are early.
    """
    evaluator = fit.evaluator
    mine = np.isin(evaluator.twin.channels, group)
    steps = [
        np.gradient(evaluator.simulate(p, fit.subject, uses), axis=0)
        for p in evaluator.prepared
    ]
    way = np.concatenate(
        [
            p.weigh(mine * step * p.run.contact)
            for p, step in zip(evaluator.prepared, steps, strict=True)
        ]
    )
    if evaluator.tolerances is not None:
        way = evaluator.tolerances.whiten(way)
    rows = len(way)
    jacobian, rest = fit.solution.jacobian[:rows], fit.solution.residual[:rows]
    way = way - jacobian @ np.linalg.lstsq(jacobian, way, rcond=None)[0]
    size = float(np.linalg.norm(way)) * np.sqrt(1.0 + max(0.0, fit.misfit))
    return -float(way @ rest) / size if size > 0.0 else 0.0


def _best_delay(
    refitter: Refitter, group: tuple[str, ...], period: float, sign: int
) -> int:
    """The delay in samples that leaves least, of a sign first; 0: none."""

    def left(place: int) -> float:
        if place not in found:
            found[place] = refitter.misfit(late(group, place, period))
        return found[place]

    found = {0: refitter.misfit()}
    for place in _DELAYS:
        left(sign * place)
    step = max(1, abs(min(found, key=found.__getitem__)) // 2)
    while step:
        best = min(found, key=found.__getitem__)
        left(best - step)
        left(best + step)
        if min(found, key=found.__getitem__) == best:
            step //= 2
    return min(found, key=found.__getitem__)
