"""Runs that the twin fits once a fault is undone, and not before.

The odd one out of the fit runs is found by fitting the twin to all the others.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.devices.declaration import Device
from brace_drake.effects.stack import Use
from brace_drake.identification.evaluation import PreparedRun
from brace_drake.identification.prepare import estimate_floors, prepare_runs
from brace_drake.recording.columns import split_unit
from brace_drake.recording.recording import Campaign
from brace_drake.recording_faults.against_twin.refitter import Refitter
from brace_drake.recording_faults.against_twin.subjects import NEAR, TIMES
from brace_drake.recording_faults.against_twin.undone import (
    OTHER,
    Suspect,
    late,
    of_channels,
    of_time,
)
from brace_drake.recording_faults.card import RecordingFault
from brace_drake.recording_faults.finding import MOST_PROBABLE, Finding
from brace_drake.recording_faults.library.channels.wrong_scale import (
    unit_of_scale,
)
from brace_drake.recording_faults.library.runs import (
    contradiction,
    other_subject,
)
from brace_drake.recording_faults.library.time import skewed_channel

# Squares for which a misfit counts: residuals of a twin are not independent.
_SQUARES = 20.0
Remake = Callable[[Campaign], Device]
# Another subject has all parameters of the twin to fit with.
_SUBJECT = 0.5 * OTHER
_CONTRADICTION = 0.8


def find_undone(
    every: Refitter, campaign: Campaign, remake: Remake, seed: int
) -> list[Finding]:
    """Faults of fit runs: of the odd one out, or of all alike.

    Args:
        every: Accuses all fit runs.
        campaign: Theirs.
        remake: Makes the device from some of them alone, since noise and
            sizes of its scenario may be estimated.
        seed: Of the floors.
    """
    odd = _odd_one_out(campaign, remake, seed, every.jobs)
    tried = _tried(every)
    if odd is None:
        return _explained(every, tried)
    # A machine may do in one run what it does in no other.
    return _explained(odd, [*tried, *_tried(odd)])


def _odd_one_out(
    campaign: Campaign, remake: Remake, seed: int, jobs
) -> Refitter | None:
    """The one run without which the twin fits all; None without."""
    runs = campaign.split("fit")
    found = []
    for i, run in enumerate(runs if len(runs) > 2 else ()):
        rest = [r for r in runs if r is not run]
        one = _without(campaign, rest, run, remake, seed, jobs)
        fit = None if one is None else one.fit(one.sound)
        if fit is not None and fit.misfit < NEAR:
            found.append((fit.misfit, i, one))
    return min(found)[-1] if found else None


def _without(campaign, rest, run, remake, seed, jobs) -> Refitter | None:
    """Some runs beside an accused one, as a device sees them that knows
    nothing of that; None where it cannot be made of them.
    """
    part = replace(campaign, runs=tuple(rest))
    try:
        device = remake(part)
    except BraceError:
        return None
    twin = device.twin
    usual = np.array([p.nominal for p in twin.subject])
    floors, _ = estimate_floors(twin, part, usual, seed)
    if run.contact not in floors:
        return None
    *sound, accused = prepare_runs(
        twin, [*rest, run], floors, device.rate, seed
    )
    return Refitter(device, sound, [accused], usual, (), jobs)


def explain_runs(
    device: Device,
    sound: Sequence[PreparedRun],
    accused: Sequence[PreparedRun],
    subject: np.ndarray,
    uses: Sequence[Use],
    jobs,
) -> list[Finding]:
    """What explains that some runs do not fit beside others.

    Args:
        device: Without a control law.
        sound: Runs that the twin fits.
        accused: Runs that it does not fit with them.
        subject, uses: The best that is known.
        jobs: As of `Evaluator`.
    """
    refitter = Refitter(device, sound, accused, subject, uses, jobs)
    return _explained(refitter, _tried(refitter)) or _contradiction(refitter)


class _Tried(NamedTuple):
    """A fault undone in the accused runs of a refitter: what is left, and how
    likely it is beforehand.

    Attributes:
        misfit: Mean square beyond noise, in noise variances.
        deviance: The same for a comparison: readings in a smaller unit would
            leave less of any error.
    """

    misfit: float
    deviance: float
    weight: float
    fault: RecordingFault
    channels: tuple[str, ...]
    parameters: Mapping[str, float]
    refitter: Refitter


def _tried(refitter: Refitter) -> list[_Tried]:
    """All faults that the accused runs could have, undone, the best delay to a
    sample; another subject's where there are runs beside them.
    """
    runs = [p.run for p in refitter.accused]
    suspects = list(of_time(runs, refitter.names))
    if refitter.sound:
        suspects += of_channels(runs, refitter.names, refitter.gain())
    tried = [(refitter.misfit(s), s) for s in suspects]
    tried.sort(key=lambda t: t[0])
    tried[:1] = _finer(refitter, *tried[0], runs)
    found = [
        _Tried(
            misfit,
            misfit + 2.0 * refitter.share * _log_scale(s, refitter.names),
            s.weight,
            s.hypothesis.fault,
            s.hypothesis.channels,
            s.hypothesis.parameters,
            refitter,
        )
        for misfit, s in tried
    ]
    both = refitter.sound and refitter.apart()
    if both:
        card = other_subject.CARD
        found.append(_Tried(both, both, _SUBJECT, card, (), {}, refitter))
    return found


def _size_of(tried: _Tried) -> str:
    """How large a fault is, with what parts it from the next words."""
    values = tried.parameters
    if "scale" in values:
        scale = values["scale"]
        unit = unit_of_scale(split_unit(tried.channels[0])[1], scale)
        return f"{'as in ' + unit if unit else f'{scale:.3g} times as large'}; "
    if "delay_s" in values:
        return f"{1e3 * values['delay_s']:.3g} ms late; "
    if "jumps" in values:
        return f"first {values['lost_s']:.2g} s at {values['start_s']:.4g} s; "
    return ""


def _log_scale(suspect: Suspect, names: Sequence[str]) -> float:
    """Logarithm of recorded over true readings of the compared channels."""
    h = suspect.hypothesis
    is_scaled = "scale" in h.parameters and h.channels[0] in names
    return float(np.log(h.parameters["scale"])) if is_scaled else 0.0


def _explained(refitter: Refitter, tried: Sequence[_Tried]) -> list[Finding]:
    """The likeliest of faults, where what is left is noise."""
    before = refitter.misfit()
    able = [t for t in tried if t.misfit < NEAR]
    tried = [t for t in able if before > TIMES * max(t.misfit, 0.05)]
    if not tried:
        return []
    least = min(t.deviance for t in tried)
    odds = [
        t.weight * float(np.exp(-0.5 * _SQUARES * (t.deviance - least)))
        for t in tried
    ]
    place = int(np.argmax(odds))
    best = tried[place]
    mine = best.fault.name, best.channels, best.refitter
    rest = sum(
        o
        for o, t in zip(odds, tried, strict=True)
        if (t.fault.name, t.channels, t.refitter) != mine
    )
    accused = best.refitter.accused
    return [
        Finding(
            best.fault,
            tuple(p.run.file for p in accused),
            () if best.fault.is_of_run else best.channels,
            dict(best.parameters),
            MOST_PROBABLE * odds[place] / (odds[place] + rest),
            f"{_size_of(best)}a misfit of {before:.3g} noise variances, and of"
            f" {max(best.misfit, 0.0):.2g} with it undone",
            of_all=len(accused) > 1 and not best.refitter.sound,
            before=1.0 + before,
            after=1.0 + best.misfit,
        )
    ]


def _finer(
    refitter: Refitter, misfit: float, suspect: Suspect, runs
) -> list[tuple[float, Suspect]]:
    """The best delay to a sample, where the best suspect is one."""
    h = suspect.hypothesis
    if h.fault is not skewed_channel.CARD:
        return [(misfit, suspect)]
    period = float(np.median(np.diff(runs[0].time_s)))
    place = round(h.parameters["delay_s"] / period)
    best, step = (misfit, suspect), max(1, abs(place) // 4)
    while step:
        near = [late(h.channels[0], place + s, period) for s in (-step, step)]
        found = [best, *((refitter.misfit(s), s) for s in near)]
        better = min(found, key=lambda t: t[0])
        if better is best:
            step //= 2
            continue
        best = better
        place = round(best[1].hypothesis.parameters["delay_s"] / period)
    return [best]


def _contradiction(refitter: Refitter) -> list[Finding]:
    before = refitter.misfit()
    return [
        Finding(
            contradiction.CARD,
            tuple(p.run.file for p in refitter.accused),
            (),
            {},
            _CONTRADICTION,
            "the twin fits all other runs down to their noise, and with it they"
            f" leave a misfit of {before:.3g} noise variances",
            severity="warning",
            before=1.0 + before,
        )
    ]
