"""Readings that no controller sees and that stand out in a few runs alone.

They are left out there: the twin that all else fits says what they should have
read.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

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


class FewRuns(NamedTuple):
    """Runs in which a reading stands out, beside the twin that all else fits.

    Attributes:
        readings: Of these runs; none where no few stand out.
        names: Of unread channels.
        bars: Beyond which a reading stands out.
        count: Of all runs.
    """

    readings: list[Reading]
    names: tuple[str, ...]
    bars: Bars
    count: int

    def faults(self) -> list[Finding]:
        """The fault that explains them."""
        return list(named(self.readings, self.names, self.bars, self.count))

    def contradictions(self) -> list[Finding]:
        """That no fault with a name explains them."""
        return _contradiction(self.readings, self.names, self.bars)


def find_few_runs(
    device: Device,
    runs: Sequence[PreparedRun],
    fit: SubjectFit,
    uses: Sequence[Use],
    jobs,
) -> FewRuns:
    """Runs in which a reading stands out from what it is in the others.

    Args:
        device, runs, uses, jobs: As of `find_sensor_faults`.
        fit: Of the subject to all readings of all runs.
    """
    names = unread_channels(device)
    if not names:
        return FewRuns([], (), Bars(_STANDS_OUT, _LIKE_OTHERS, 0.0), len(runs))
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
        return FewRuns([], names, bars, len(runs))
    found = read_without(device, runs, few, fit.subject, uses, jobs)
    return FewRuns(found, names, bars, len(runs))


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
