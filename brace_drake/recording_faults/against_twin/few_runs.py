"""Readings that no controller sees and that stand out in a few runs alone.

They are left out there: the twin that all else fits says what they should have
read.
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
from brace_drake.recording_faults.against_twin.sensors import (
    Bars,
    named,
    read_without,
)
from brace_drake.recording_faults.finding import Finding
from brace_drake.recording_faults.library.runs import contradiction

# In a few runs a channel stands out from so many times what it is in the others
# on, and is restored at so many times that.
_STANDS_OUT, _LIKE_OTHERS = 4.0, 1.5
# That a reading of a few runs is wrong where no fault has its name.
_CONTRADICTION = 0.95


def find_few_runs(
    device: Device,
    runs: Sequence[PreparedRun],
    fit: SubjectFit,
    uses: Sequence[Use],
    jobs,
) -> list[Finding]:
    """Faults that readings have in a few of the runs.

    Args:
        device, runs, uses, jobs: As of `find_sensor_faults`.
        fit: Of the subject to all readings of all runs.
    """
    found, bars = _few(device, runs, fit, uses, jobs)
    return list(named(found, unread_channels(device), bars, len(runs)))


def find_contradictions(
    device: Device,
    runs: Sequence[PreparedRun],
    fit: SubjectFit,
    uses: Sequence[Use],
    jobs,
) -> list[Finding]:
    """Readings of a few runs that no fault with a name explains; arguments as
    of `find_few_runs`.
    """
    found, bars = _few(device, runs, fit, uses, jobs)
    return _contradiction(found, unread_channels(device), bars)


def _few(
    device: Device,
    runs: Sequence[PreparedRun],
    fit: SubjectFit,
    uses: Sequence[Use],
    jobs,
) -> tuple[list[Reading], Bars]:
    """Runs in which a reading stands out from what it is in the others, beside
    the twin that all else fits; none where these are not few.
    """
    names = unread_channels(device)
    readings = read_runs(device, fit.evaluator, runs, fit.subject, uses)
    squares = [r.unread(names) for r in readings]
    usual = {
        n: max(1.0, float(np.median([s[n] for s in squares if n in s])))
        for n in names
        if any(n in s for s in squares)
    }
    level = max(usual.values(), default=1.0)
    bars = Bars(_STANDS_OUT * level, _LIKE_OTHERS * level, 0.0)
    few = [
        r.prepared
        for r, found in zip(readings, squares, strict=True)
        if any(v > _STANDS_OUT * usual[n] for n, v in found.items())
    ]
    if not few or 2 * len(few) >= len(readings):
        return [], bars
    return read_without(device, runs, few, fit.subject, uses, jobs), bars


def _contradiction(
    readings: Sequence[Reading], names: Sequence[str], bars: Bars
) -> list[Finding]:
    """Readings of a few runs that no fault with a name explains: the machine
    follows the twin there in all else, and elsewhere in these too.
    """
    squares = [r.unread(names) for r in readings]
    wrong = {n for s in squares for n, v in s.items() if v > bars.gross}
    if not wrong:
        return []
    runs = tuple(
        r.prepared.run.file
        for r, found in zip(readings, squares, strict=True)
        if any(v > bars.gross for v in found.values())
    )
    channels = tuple(n for n in names if n in wrong)
    before = max(s[n] for s in squares for n in channels if n in s)
    return [
        Finding(
            contradiction.CARD,
            runs,
            channels,
            {},
            _CONTRADICTION,
            f"{np.sqrt(before):.3g} noise floors off the twin that all other"
            " channels fit, and that it fits in the other runs",
            before=before,
        )
    ]
