"""What can be said of a recording before any fit."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from brace_drake.devices.declaration import Device
from brace_drake.recording.columns import Channel
from brace_drake.recording.recording import Campaign, Run
from brace_drake.recording.samples import TELLING_ROWS
from brace_drake.recording_faults.channels import declared, is_desired
from brace_drake.recording_faults.finding import Finding, merge
from brace_drake.recording_faults.library.channels.clipped_channel import (
    find_clipped,
)
from brace_drake.recording_faults.library.channels.outliers import find_outliers
from brace_drake.recording_faults.library.channels.stuck_channel import (
    find_stuck,
)
from brace_drake.recording_faults.library.channels.zero_step import (
    find_zero_steps,
)
from brace_drake.recording_faults.library.runs.copied_run import find_copies
from brace_drake.recording_faults.library.runs.false_repeat import (
    find_false_repeats,
)
from brace_drake.recording_faults.library.runs.wrong_contact import (
    find_wrong_contact,
)
from brace_drake.recording_faults.library.time.held_channel import find_held
from brace_drake.recording_faults.library.time.lost_samples import find_lost
from brace_drake.recording_faults.library.time.repeated_samples import (
    find_repeated,
)
from brace_drake.recording_faults.relations.control_law import find_law_faults
from brace_drake.recording_faults.relations.mismatch import LawChecker
from brace_drake.recording_faults.relations.passive import find_given_work
from brace_drake.recording_faults.relations.pressing import find_press_faults
from brace_drake.recording_faults.relations.reference import (
    find_reference_faults,
    spread_clock,
)
from brace_drake.recording_faults.relations.torso import find_torso_faults

# Faults after which rows of two runs do not stand for the same times.
_OF_TIME = ("wrong_clock", "lost_samples", "repeated_samples")


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
    runs = [
        _as_declared(r, campaign)
        for r in campaign.runs
        if len(r.time_s) >= TELLING_ROWS
    ]
    checker = None
    if device is not None and device.control_law is not None:
        checker = LawChecker(device, runs, seed)
    samples = _of_samples(campaign, runs)
    if checker is not None:
        samples = [_as_followed(f, runs, checker) for f in samples]
    found = merge(samples, len(runs))
    # A run with lost samples repeats no other, and a clock spoils every law.
    timed = _files(f for f in samples if f.fault.name in _OF_TIME)
    found += merge(
        _of_manifest(campaign, [r for r in runs if r.file not in timed]),
        len(runs),
    )
    if device is None:
        return found
    spoilt = timed | _files(f for f in samples if f.is_certain)
    law: list[Finding] = []
    if checker is not None:
        whole = [r for r in runs if r.file not in spoilt]
        law = find_law_faults(checker, whole)
        found += merge(law, len(runs))
    # Of a torso that is not there a marker may read nothing at all.
    pressed = timed | _files(
        f for f in samples if f.is_certain and not _is_of_torso(f)
    )
    contact = _of_contact(
        device, [r for r in runs if r.file not in pressed | _files(law)]
    )
    absent = _files(f for f in contact if f.fault.name == "wrong_contact")
    kept = [f for f in found if not (_is_of_torso(f) and {*f.runs} <= absent)]
    return kept + merge(contact, sum(r.contact for r in runs))


def _as_declared(run: Run, campaign: Campaign) -> Run:
    """A run without columns that its device does not declare: they may hold
    anything, and nothing is judged by them.
    """
    known = {"time_s", *declared(campaign)}
    own = {n: v for n, v in run.channels.items() if n in known}
    return replace(run, channels=own)


def _as_followed(
    finding: Finding, runs: Sequence[Run], checker: LawChecker
) -> Finding:
    """A scale of the reference is a warning where the controller has followed
    the reference as it is.
    """
    names = finding.channels
    if not names or not all(map(is_desired, names)):
        return finding
    judged = [checker.judge(r) for r in runs if r.file in finding.runs]
    if all(m is not None and m.is_sound for m in judged):
        return replace(finding, severity="warning")
    return finding


def _is_of_torso(finding: Finding) -> bool:
    """Whether a finding is about markers alone."""
    names = finding.channels
    return bool(names) and all(n.startswith("torso_") for n in names)


def _files(findings: Iterable[Finding]) -> set[str]:
    """Files that findings are in."""
    return {file for f in findings for file in f.runs}


def _of_samples(campaign: Campaign, runs: Sequence[Run]) -> list[Finding]:
    known = declared(campaign)
    number = sum(len(r.time_s) * len(r.channels) for r in runs)
    found: list[Finding] = []
    for run in runs:
        # What is cut off is stuck too, what is stuck has no outliers.
        clipped = find_clipped(run, known)
        whole = _without(known, clipped)
        stuck = find_stuck(run, whole)
        moved = find_zero_steps(run, _without(whole, stuck))
        broken = clipped + stuck + moved
        whole = _without(whole, stuck + moved)
        found += broken
        found += find_outliers(run, whole, number)
        found += find_held(run, whole)
        found += find_repeated(run, whole)
        found += find_lost(run, whole)
        found += find_reference_faults(run)
    return spread_clock(found, runs)


def _without(
    known: dict[str, Channel], findings: Sequence[Finding]
) -> dict[str, Channel]:
    """Channels that no finding is about."""
    told = {c for f in findings for c in f.channels}
    return {n: c for n, c in known.items() if n not in told}


def _of_contact(device: Device, runs: Sequence[Run]) -> list[Finding]:
    """What forces say of contact and markers, in runs where they are sound."""
    found = find_wrong_contact(device, runs) + find_press_faults(device, runs)
    found += find_given_work(device, runs)
    wrong = _files(found)
    return found + find_torso_faults(
        device, [r for r in runs if r.file not in wrong]
    )


def _of_manifest(campaign: Campaign, runs: Sequence[Run]) -> list[Finding]:
    known = declared(campaign)
    return find_copies(runs, known) + find_false_repeats(runs, known)


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
