"""Readings that no controller sees and that all runs have off in time.

Little of a marker's delay shows: the subject's damping takes most of it. But a
twin that is right leaves noise alone in every reading. Where
a delay, or a clock of its own, would take more than chance of that, by straight
lines, the subject is fitted anew with faults of that sign undone.
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
from brace_drake.recording_faults.against_twin.undone import (
    OTHER,
    Suspect,
    time_faults,
)
from brace_drake.recording_faults.finding import MOST_PROBABLE, Finding
from brace_drake.recording_faults.relations.time_faults import (
    TimeFault,
    size_text,
)
from brace_drake.recording_faults.statistics import largest_normal

# Mean square, in floors, from which on a reading is looked at.
_STANDS_OUT = 1.2
# Part of what a reading leaves beyond noise that a delay may leave of it.
_TOLD = 0.25


def find_late_readings(
    device: Device,
    runs: Sequence[PreparedRun],
    fit: SubjectFit,
    uses: Sequence[Use],
    jobs,
) -> list[Finding]:
    """A delay, or a clock, of the unread readings of one instrument.

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
        with_torso = [p for p in runs if p.run.contact]
        evaluator = fit.evaluator
        readings = read_runs(device, evaluator, with_torso, fit.subject, uses)
        return sorted(_beside_noise(readings, n) for n in group)

    *others, before = off(fit, runs)
    if before < _STANDS_OUT:
        return []
    # A reading in which least moves shows what noise there is.
    quiet = max([1.0, *others[:1]])
    refitter = Refitter(device, (), runs, fit.subject, uses, jobs)
    faults = time_faults(contact[0].run)
    slopes = _slopes(fit, group, uses)
    least = largest_normal(sum(len(f.sizes) for f in faults))
    for slope, fault in sorted(
        zip(slopes, faults, strict=True), key=lambda s: -abs(s[0])
    ):
        if abs(slope) < least:
            break
        suspect = _best_of(refitter, fault, group, np.sign(slope))
        undone = refitter.undone(suspect)
        again = refitter.fit(undone) if undone else None
        if again is None:
            continue
        *_, after = off(again, undone)
        if after - quiet <= _TOLD * (before - quiet):
            return [_finding(suspect, runs, before, after)]
    return []


def _finding(
    suspect: Suspect,
    runs: Sequence[PreparedRun],
    before: float,
    after: float,
) -> Finding:
    h = suspect.hypothesis
    return Finding(
        h.fault,
        tuple(p.run.file for p in runs),
        h.channels,
        dict(h.parameters),
        MOST_PROBABLE,
        f"{size_text(h.parameters)}{np.sqrt(before):.3g} noise floors off the"
        f" twin that fits best, {np.sqrt(after):.3g} with it undone",
        of_all=len(runs) > 1,
        before=before,
        after=after,
    )


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


def _slopes(
    fit: SubjectFit, group: tuple[str, ...], uses: Sequence[Use]
) -> tuple[float, float]:
    """How far readings with a delay, or with a clock of their own, would leave
    less, beside what the subject and numbers within their tolerances take.

    Each in deviations of what a right twin leaves; positive where they are
    late, or run ahead; negative where early, or behind.
    """
    evaluator = fit.evaluator
    mine = np.isin(evaluator.twin.channels, group)
    times, steps = [], []
    for p in evaluator.prepared:
        moved = evaluator.simulate(p, fit.subject, uses)
        steps.append(-np.gradient(moved, axis=0) * (mine * p.run.contact))
        times.append((p.run.time_s - p.run.time_s[0])[:, None])

    ahead = [-t * s for t, s in zip(times, steps, strict=True)]
    ways = np.column_stack(
        [
            np.concatenate(
                [
                    p.weigh(c)
                    for p, c in zip(evaluator.prepared, own, strict=True)
                ]
            )
            for own in (steps, ahead)
        ]
    )
    if evaluator.tolerances is not None:
        ways = evaluator.tolerances.whiten(ways)
    jacobian = fit.solution.jacobian[: len(ways)]
    ways = ways - jacobian @ np.linalg.lstsq(jacobian, ways, rcond=None)[0]
    gains = ways.T @ fit.solution.residual[: len(ways)]
    size = np.linalg.norm(ways, axis=0) * np.sqrt(1.0 + max(0.0, fit.misfit))
    late, fast = np.divide(gains, size, where=size > 0.0, out=np.zeros(2))
    return float(late), float(fast)


def _best_of(
    refitter: Refitter, fault: TimeFault, group: tuple[str, ...], sign: float
) -> Suspect:
    """The size of a fault that leaves least, of a sign."""

    def look(size: float) -> tuple[float, Suspect]:
        suspect = Suspect(fault.of(group, size), OTHER)
        return refitter.misfit(suspect), suspect

    tried = {sign * s: look(sign * s) for s in fault.sizes}
    size = min(tried, key=lambda s: tried[s][0])
    _, (_, best) = fault.refined(size, tried[size], look, lambda t: t[0])
    return best
