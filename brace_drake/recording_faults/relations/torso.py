"""The torso's marker against the force that moves it, for any subject.

Along the push a torso answers its force F as m y'' + c y' + k y. Whatever
drives, pads and controller do, k lies within what subjects have; a marker that
is read in another unit, or in another's column, shows one that none has.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from brace_drake.devices.declaration import Device, TorsoLaw
from brace_drake.recording.forces import smoothed
from brace_drake.recording.recording import Run
from brace_drake.recording_faults.finding import Finding
from brace_drake.recording_faults.library.channels import (
    exchanged_channels,
    reversed_sign,
    wrong_scale,
)
from brace_drake.recording_faults.library.runs import contradiction

# Share of the force that the law explains where it is believed, and room that
# effects of torso and force reading take beside the limits of subjects.
_EXPLAINED, _ROOM = 0.9, 1.4
# How a push follows the motion that is asked for, as a correlation.
_FOLLOWS = 0.8
# What a wrong unit changes, at least.
_UNIT = 5.0
# A marker that moves less is not told from its noise, in deviations.
_CLEAR = 10.0


class Answer(NamedTuple):
    """Stiffness that a marker shows, N/m, and the share it explains."""

    stiffness: float
    explained: float


def find_torso_faults(device: Device, runs: Sequence[Run]) -> list[Finding]:
    """Runs whose marker along the push is no torso's."""
    law = device.torso_law
    if law is None:
        return []
    shown = [
        (run, answer)
        for run in runs
        if run.contact and law.marker in run.channels and _pushes(device, run)
        for answer in [answer_of(run, law, law.marker, device.rate)]
        if answer is not None and not _is_torso(answer, law)
    ]
    exchanged = [_other_axis(run, law, device.rate) for run, _ in shown]
    told = {name for name in exchanged if name is not None}
    if len(told) == 1:
        (name,) = told
        return [
            Finding(
                exchanged_channels.CARD,
                (run.file,),
                (name, law.marker),
                {},
                0.95,
                f"the force on the torso moves {name} as it should move"
                f" {law.marker}",
            )
            for run, _ in shown
        ]
    still = [_still(r, law) for r, a in shown if np.isinf(a.stiffness)]
    known = [(r, a) for r, a in shown if a.explained > _EXPLAINED]
    if still or not known:
        return still
    middle = float(np.sqrt(law.lower * law.upper))
    scale = float(np.median([middle / a.stiffness for _, a in known]))
    return [_scaled(run, law, scale, answer) for run, answer in known]


def _pushes(device: Device, run: Run) -> bool:
    """Whether the motion that is asked for makes the force: a torso that moves
    by itself, as in breath, is not the one that answers.
    """
    expected = device.least_push(run)
    if expected is None:
        return False
    name, _, asked = expected
    push = smoothed(run.channels[name], device.rate)
    asked = smoothed(asked, device.rate)
    if not (np.std(push) and np.std(asked)):
        return False
    return abs(float(np.corrcoef(push, asked)[0, 1])) > _FOLLOWS


def answer_of(
    run: Run, law: TorsoLaw, marker: str, rate: float
) -> Answer | None:
    """What a marker answers to the force; None where the force would hardly
    move it, and endless stiffness where it does not move.
    """
    y, F = run.channels[marker], run.channels[law.force]
    noise = float(np.std(np.diff(y))) / np.sqrt(2.0)
    slow, push = smoothed(y, rate), smoothed(F, rate)
    least = _CLEAR * noise / np.sqrt(0.1 * rate)
    if np.std(push) < law.upper * least or not np.std(push):
        return None
    # A marker that stands still has no noise either; a mean of it that is
    # rounded at each step seems to move.
    if np.ptp(y) == 0.0 or np.std(slow) <= least:
        return Answer(np.inf, 0.0)
    speed = np.gradient(slow) * rate
    terms = np.column_stack(
        [slow, speed, np.gradient(speed) * rate, np.ones(len(slow))]
    )
    size = np.linalg.norm(terms, axis=0)
    values, *_ = np.linalg.lstsq(terms / size, push, rcond=None)
    rest = push - terms @ (values / size)
    return Answer(
        float(values[0] / size[0]), 1.0 - float(np.var(rest) / np.var(push))
    )


def _is_torso(answer: Answer, law: TorsoLaw) -> bool:
    """Whether a torso may have answered so: a subject's, or a soft one that is
    pushed faster than it swings and so moves against the force.
    """
    size = abs(answer.stiffness)
    if answer.stiffness < 0.0:
        return law.lower / _UNIT < size < law.lower / _ROOM
    return law.lower / _ROOM <= size <= law.upper * _ROOM


def _other_axis(run: Run, law: TorsoLaw, rate: float) -> str | None:
    """The marker's channel that answers as the one along the push should."""
    for name in law.others:
        if name in run.channels:
            found = answer_of(run, law, name, rate)
            if (
                found is not None
                and found.explained > _EXPLAINED
                and _is_torso(found, law)
            ):
                return name
    return None


def _still(run: Run, law: TorsoLaw) -> Finding:
    """A marker that shows noise alone: lost, or on a torso that is held."""
    change = float(np.ptp(run.channels[law.force]))
    return Finding(
        contradiction.CARD,
        (run.file,),
        (law.marker,),
        {},
        0.8,
        f"it shows noise alone while {law.force} changes by {change:.3g} N, and"
        f" subjects have at most {law.upper:.3g} N/m",
        severity="warning",
    )


def _scaled(run: Run, law: TorsoLaw, scale: float, answer: Answer) -> Finding:
    detail = (
        f"it answers {law.force} as {answer.stiffness:.3g} N/m would, subjects"
        f" have {law.lower:.3g} to {law.upper:.3g} N/m"
    )
    card, values = wrong_scale.CARD, {"scale": scale, "zero": 0.0}
    if scale < 0.0 and 1.0 / _ROOM < -scale * _ROOM < _ROOM**3:
        card, values = reversed_sign.CARD, {"zero": 0.0}
    return Finding(card, (run.file,), (law.marker,), values, 0.95, detail)
