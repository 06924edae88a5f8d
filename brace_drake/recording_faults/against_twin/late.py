"""Readings that no controller sees and that all runs have off in time.

Little of a marker's delay shows: the subject's damping takes most of it. But a
twin that is right leaves noise alone in every reading. Where
a delay, or a clock of its own, would take more than chance of that, by straight
lines, the subject is fitted anew with faults near what those lines say undone.
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
from brace_drake.recording_faults.relations.hypotheses import Hypothesis
from brace_drake.recording_faults.relations.time_faults import (
    TimeFault,
    refined_best,
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
    told, sizes = _along(fit, group, uses)
    place = int(np.argmax(np.abs(told)))
    if abs(told[place]) < largest_normal(len(faults)):
        return []
    suspect = _best_of(refitter, faults[place], group, sizes[place])
    undone = refitter.undone(suspect)
    again = refitter.fit(undone) if undone else None
    if again is None:
        return []
    *_, after = off(again, undone)
    if after - quiet > _TOLD * (before - quiet):
        return []
    return [_finding(suspect, runs, before, after)]


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


def _along(
    fit: SubjectFit, group: tuple[str, ...], uses: Sequence[Use]
) -> tuple[np.ndarray, np.ndarray]:
    """How far a delay of readings, and a clock of their own, would leave less,
    beside what the subject and numbers within their tolerances take.

    By straight lines: in deviations of what a right twin leaves (2,), and the
    delay, s, and the clock's rate that do (2,).
    """
    evaluator = fit.evaluator
    mine = np.isin(evaluator.twin.channels, group)
    late, ahead = [], []
    for p in evaluator.prepared:
        time = p.run.time_s - p.run.time_s[0]
        moved = evaluator.simulate(p, fit.subject, uses)
        speed = np.gradient(moved, time, axis=0) * (mine * p.run.contact)
        late.append(p.weigh(-speed))
        ahead.append(p.weigh(time[:, None] * speed))
    ways = np.column_stack([np.concatenate(late), np.concatenate(ahead)])
    if evaluator.tolerances is not None:
        ways = evaluator.tolerances.whiten(ways)
    jacobian = fit.solution.jacobian[: len(ways)]
    ways = ways - jacobian @ np.linalg.lstsq(jacobian, ways, rcond=None)[0]
    gains = ways.T @ fit.solution.residual[: len(ways)]
    length = np.maximum(np.linalg.norm(ways, axis=0), 1e-30)
    spread = np.sqrt(1.0 + max(0.0, fit.misfit))
    return gains / length / spread, gains / length**2


def _best_of(
    refitter: Refitter, fault: TimeFault, group: tuple[str, ...], size: float
) -> Suspect:
    """The size of a fault that leaves least, near one by straight lines."""

    def left(h: Hypothesis) -> float:
        return refitter.misfit(Suspect(h, OTHER))

    near = float(np.clip(abs(size), fault.finest, max(fault.sizes)))
    near = fault.finest * round(near / fault.finest) * np.sign(size)
    start = fault.of(group, near)
    ((_, best),) = refined_best((fault,), [(left(start), start)], left)
    return Suspect(best, OTHER)
