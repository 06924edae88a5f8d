"""Runs that the twin fits once a fault is undone, and not before."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from brace_drake.devices.declaration import Device
from brace_drake.effects.stack import Use
from brace_drake.identification.evaluation import PreparedRun
from brace_drake.recording.columns import shown_unit, split_unit
from brace_drake.recording.recording import Campaign
from brace_drake.recording_faults.against_twin.odd_runs import (
    Maker,
    find_odd_ones,
)
from brace_drake.recording_faults.against_twin.refitter import (
    LEAST,
    Refitter,
)
from brace_drake.recording_faults.against_twin.subjects import NEAR, TIMES
from brace_drake.recording_faults.against_twin.undone import (
    OTHER,
    Suspect,
    of_channels,
    of_time,
    time_faults,
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
from brace_drake.recording_faults.library.time import lost_samples
from brace_drake.recording_faults.relations.time_faults import (
    refined_best,
    size_text,
)

# Squares for which a misfit counts: residuals of a twin are not independent.
_SQUARES = 20.0
# Another subject has all parameters of the twin to fit with.
_SUBJECT = 0.5 * OTHER
_CONTRADICTION, _UNKNOWN = 0.8, 0.5
# How much more than the others' a run may leave that is one of them.
_LIKE_OTHERS = 1.5
# Part of a misfit that is next to nothing.
_NOTHING = 1e-3


def find_undone(
    every: Refitter,
    new: Sequence[PreparedRun],
    campaign: Campaign,
    maker: Maker,
    seed: int,
) -> list[Finding]:
    """Faults of fit runs: of the odd one out, or of all alike.

    Args:
        every: Accuses all fit runs.
        new: Validation runs.
        campaign: Theirs.
        maker: Of devices, since noise and sizes of a scenario may be
            estimated from the runs.
        seed: Of the floors.
    """
    odd = find_odd_ones(campaign, maker, seed, every.jobs)
    tried = _tried(every)
    if odd is None:
        return _explained(every, tried)
    # A machine may do in one run what it does in no other.
    found = _explained(odd, [*tried, *_tried(odd, new)])
    if found:
        return found
    # What the effects take there is the machine's.
    files = {p.run.file for p in odd.accused}
    if odd.left_in(files) > TIMES * max(LEAST, every.left_in(files)):
        return []
    return _contradiction(odd, _UNKNOWN)


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

    def tells(self, before: float) -> bool:
        """Whether what is left of a misfit is noise, or much like what the
        other runs leave, or next to nothing.
        """
        if before < TIMES * self.misfit:
            return False
        if self.refitter.sound and self.misfit < _NOTHING * before:
            return True
        level = self.refitter.level if self.refitter.sound else LEAST
        return self.misfit < NEAR + _LIKE_OTHERS * (level - LEAST)


def _tried(refitter: Refitter, new: Sequence[PreparedRun] = ()) -> list[_Tried]:
    """All faults that the accused runs could have, undone, the best of time
    refined; another subject's where other runs, `new` ones among them, move
    alike and are not accused: else it may be the motion that is another.
    """
    runs = [p.run for p in refitter.accused]
    suspects = list(of_time(runs, refitter.names))
    readings = refitter.readings() if refitter.sound else None
    if readings is not None:
        suspects += of_channels(runs, refitter.names, *readings)
    told = (s for s in suspects if refitter.shows(s))
    tried = [(refitter.misfit(s), s) for s in told]
    finer = refined_best(
        time_faults(runs[0]),
        [(misfit, s.hypothesis) for misfit, s in tried],
        lambda h: refitter.misfit(Suspect(h, OTHER)),
    )
    tried += [(misfit, Suspect(h, OTHER)) for misfit, h in finer]
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
    both = refitter.has_witness(new) and refitter.apart()
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
    if "offset" in values:
        unit = shown_unit(split_unit(tried.channels[0])[1])
        since = ""
        if "start_s" in values:
            since = f" from {values['start_s']:.4g} s on"
        return f"by {values['offset']:.3g} {unit}{since}; "
    if "jumps" in values:
        return f"first {values['lost_s']:.2g} s at {values['start_s']:.4g} s; "
    return size_text(values)


def _log_scale(suspect: Suspect, names: Sequence[str]) -> float:
    """Logarithm of recorded over true readings of the compared channels."""
    h = suspect.hypothesis
    is_scaled = "scale" in h.parameters and h.channels[0] in names
    return float(np.log(h.parameters["scale"])) if is_scaled else 0.0


def _explained(refitter: Refitter, tried: Sequence[_Tried]) -> list[Finding]:
    """The likeliest of faults, where what is left is noise."""
    before = refitter.misfit()
    tried = [t for t in tried if t.tells(before)]
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
            () if best.fault is lost_samples.CARD else best.channels,
            dict(best.parameters),
            MOST_PROBABLE * odds[place] / (odds[place] + rest),
            f"{_size_of(best)}a misfit of {before:.3g} noise variances, and of"
            f" {max(best.misfit, 0.0):.2g} with it undone",
            of_all=len(accused) > 1 and not best.refitter.sound,
            before=1.0 + before,
            after=1.0 + best.misfit,
        )
    ]


def _contradiction(
    refitter: Refitter, probability: float = _CONTRADICTION
) -> list[Finding]:
    before = refitter.misfit()
    return [
        Finding(
            contradiction.CARD,
            tuple(p.run.file for p in refitter.accused),
            (),
            {},
            probability,
            f"the others leave a misfit of {refitter.level:.3g} noise"
            f" variances, and with it {before:.3g}",
            severity="warning",
            before=1.0 + before,
        )
    ]
