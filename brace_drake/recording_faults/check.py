"""What can be said of a recording before any fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from brace_drake.devices.declaration import Device
from brace_drake.recording.recording import Campaign, Run
from brace_drake.recording_faults.channels import declared
from brace_drake.recording_faults.finding import Finding, merge
from brace_drake.recording_faults.library.channels.clipped_channel import (
    find_clipped,
)
from brace_drake.recording_faults.library.channels.outliers import find_outliers
from brace_drake.recording_faults.library.channels.stuck_channel import (
    find_stuck,
)
from brace_drake.recording_faults.library.runs.copied_run import find_copies
from brace_drake.recording_faults.library.runs.false_repeat import (
    find_false_repeats,
)
from brace_drake.recording_faults.library.runs.wrong_contact import (
    find_wrong_contact,
)
from brace_drake.recording_faults.library.time.repeated_samples import (
    find_repeated,
)
from brace_drake.recording_faults.relations.control_law import find_law_faults
from brace_drake.recording_faults.relations.mismatch import LawChecker
from brace_drake.recording_faults.relations.reference import (
    find_reference_faults,
    spread_clock,
)

# A run of fewer samples tells nothing.
_LEAST_ROWS = 50


def check_recording(
    campaign: Campaign, device: Device | None = None, seed: int = 0
) -> list[Finding]:
    """Faults that the files, and the declared control law, show by themselves.

    A sound campaign, whatever effects its machine has, gives a false alarm
    once in ten thousand for each kind of test.

    Args:
        campaign: As loaded.
        device: Its device; without one no law of a controller is asked.
        seed: Of the noise in the law's floor.
    """
    runs = [r for r in campaign.runs if len(r.time_s) >= _LEAST_ROWS]
    samples = _of_samples(campaign, runs)
    found = merge(samples, len(runs))
    broken = {f.runs[0] for f in samples if f.fault.is_of_run and f.channels}
    manifest = _of_manifest(campaign, device, runs, broken)
    found += merge(manifest, len(runs))
    if device is None or device.control_law is None:
        return found
    spoilt = {
        file
        for f in found
        if f.severity == "error" and not f.fault.name.endswith("_repeat")
        for file in f.runs
    }
    told = ("copied_run", "exchanged_runs")
    spoilt -= {
        file for f in found if f.fault.name in told for file in f.runs
    } - {file for f in found if f.fault.name not in told for file in f.runs}
    left = [r for r in runs if r.file not in spoilt]
    checker = LawChecker(device, runs, seed)
    return found + merge(find_law_faults(checker, left), len(runs))


def _of_samples(campaign: Campaign, runs: Sequence[Run]) -> list[Finding]:
    known = declared(campaign)
    number = sum(len(r.time_s) * len(r.channels) for r in runs)
    found: list[Finding] = []
    for run in runs:
        if not all(np.isfinite(v).all() for v in run.channels.values()):
            continue
        broken = find_stuck(run, known) + find_clipped(run, known)
        channels = {c for f in broken for c in f.channels}
        whole = {n: c for n, c in known.items() if n not in channels}
        found += broken
        found += find_outliers(run, whole, number)
        found += find_repeated(run, whole)
        found += find_reference_faults(run)
    return spread_clock(found, runs)


def _of_manifest(
    campaign: Campaign,
    device: Device | None,
    runs: Sequence[Run],
    broken: set[str],
) -> list[Finding]:
    known = declared(campaign)
    found = find_copies(runs, known) + find_false_repeats(runs, known)
    if device is not None:
        whole = [r for r in runs if r.file not in broken]
        found += find_wrong_contact(device, whole)
    return found


def without_false_repeats(
    campaign: Campaign, findings: Sequence[Finding]
) -> Campaign:
    """A campaign in which no false repeat, and no copy, sets a noise floor."""
    names = ("false_repeat", "copied_run", "exchanged_runs")
    false = {
        f for found in findings if found.fault.name in names for f in found.runs
    }
    runs = tuple(
        replace(r, repeat_of=None)
        if r.file in false or r.repeat_of in false
        else r
        for r in campaign.runs
    )
    return replace(campaign, runs=runs)
