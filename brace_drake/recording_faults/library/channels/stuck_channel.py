"""A channel that stays at one value while it should not."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from brace_drake.identification.noise_floor import quantum_of
from brace_drake.recording.columns import Channel, split_unit
from brace_drake.recording.recording import Run
from brace_drake.recording_faults.card import FaultParameter, RecordingFault
from brace_drake.recording_faults.channels import (
    moves,
    noisy_channels,
    references,
)
from brace_drake.recording_faults.finding import Finding
from brace_drake.recording_faults.statistics import (
    FALSE_ALARM,
    noise_deviation,
    stretches,
    usual_step,
)

CARD = RecordingFault(
    name="stuck_channel",
    title="stuck at one value",
    law="x_rec = x_0 from t_0 on, for a duration T",
    signature="not one digit changes while others of its kind move and shake",
    remedy="check the sensor and its cable; record the run again",
    parameters=(
        FaultParameter("share", "1", "of the run in which it is stuck"),
        FaultParameter("start_s", "s", "t_0, from the first sample"),
    ),
    is_of_run=True,
)
# Likeliest that readings of one place are written alike: noise of half a step
# and more, around the middle of a step.
_ALIKE = 0.7
# Readings that repeat more rarely have noise of many steps everywhere.
_FINE = 0.05
# Rounding alone shakes by less than so many steps.
_SHAKES = 2.0
# Shorter holds are lost samples, which can be filled.
_LEAST = 40
# Steps that others move by while a stuck one should have moved too.
_MOVED = 8.0


def find_stuck(run: Run, known: Mapping[str, Channel]) -> list[Finding]:
    """Channels of a run that are stuck, all or part of the time."""
    names = noisy_channels(run, known)
    flat = [n for n in names if np.ptp(run.channels[n]) == 0.0]
    # A machine at rest with fine sensors that all rest may be one.
    if flat and not (moves(run, known) or len(flat) == len(names)):
        return []
    found = [_finding(run, n, 0, len(run.time_s)) for n in flat]
    total = len(run.time_s) * max(1, len(names))
    for name in names:
        if name in flat:
            continue
        for place in _holds(run.channels[name]):
            if _is_chanceless(run, known, name, place, total):
                found.append(_finding(run, name, *place))
                break
    return found


def _finding(run: Run, name: str, begin: int, end: int) -> Finding:
    time = run.time_s
    share = (end - begin) / len(time)
    start = float(time[begin] - time[0])
    value = run.channels[name][begin] + 0.0
    detail = f"{value:g} for {end - begin} samples from {start:.4g} s on"
    return Finding(
        CARD,
        (run.file,),
        (name,),
        {"share": share, "start_s": start},
        detail=detail,
        row=begin + 1,
    )


def _holds(values: np.ndarray) -> list[tuple[int, int]]:
    """Stretches of one value that no hold of lost samples makes, the longest
    first.
    """
    found = [(a, b + 1) for a, b in stretches(np.diff(values) == 0.0)]
    held = [s for s in found if s[1] - s[0] >= _LEAST]
    return sorted(held, key=lambda s: s[0] - s[1])


def _is_chanceless(run, known, name, place, total) -> bool:
    """Whether noise would have changed the value in such a stretch."""
    begin, end = place
    values = run.channels[name]
    outside = _outside(values, begin, end)
    alike = float(np.mean(np.diff(outside) == 0.0)) if len(outside) > 50 else 1
    if (end - begin) * np.log(_likeliest(alike)) > np.log(FALSE_ALARM / total):
        return False
    if _is_limit(known[name], values[begin]):
        return False
    # A reading that never repeats may move from step to step, or shake.
    shakes = noise_deviation(outside) > _SHAKES * quantum_of(values)
    is_fine = alike < _FINE and shakes
    if is_fine:
        return True
    stood = _goes_on(values, begin, end)
    return not stood and _others_move(run, known, name, begin, end)


def _likeliest(alike: float) -> float:
    """Chance that a reading repeats, where it does so most often."""
    return max(alike, 1e-3) if alike < _FINE else _ALIKE


def _is_limit(channel: Channel, value: float) -> bool:
    """Whether a value is told as saturation by the check of limits."""
    limit = {"command": 120.0, "reading": 49.9}.get(channel.saturates or "")
    return limit is not None and bool(abs(value) >= limit - 1e-3)


def _goes_on(values: np.ndarray, begin: int, end: int) -> bool:
    """Whether what follows goes on from where it stood, as after play or dry
    friction; a sensor that comes back leaps to where the machine is by then.
    """
    if end == len(values):
        # It ends as it stands: has it stood like that before?
        before = [s for s in _holds(values) if s[1] < end]
        like = [s for s in before if 2 * (s[1] - s[0]) >= end - begin]
        return any(_goes_on(values, *s) for s in like)
    steps = np.abs(np.diff(values))
    elsewhere = _outside(steps, begin, end)
    # A coarse reading goes on by one digit.
    return bool(
        steps[end - 1] <= max(usual_step(elsewhere), 1.01 * quantum_of(values))
    )


def _others_move(run, known, name, begin, end) -> bool:
    """Whether the reference, or a channel of the same kind, moves there by so
    much that this one would have, as they go together elsewhere.
    """
    unit = split_unit(name)[1]
    kin = [
        n
        for n in (*noisy_channels(run, known), *references(run, known))
        if split_unit(n)[1] == unit and n != name
    ]
    values = run.channels[name]
    step = quantum_of(values)
    mine = float(np.ptp(_outside(values, begin, end)))
    expected = 0.0
    for other in kin:
        way = run.channels[other]
        elsewhere = float(np.ptp(_outside(way, begin, end)))
        moved = float(np.ptp(way[begin:end]))
        share = mine / elsewhere if elsewhere > 0.0 else 1.0
        expected = max(expected, min(share, 1.0) * moved)
    return step > 0.0 and expected > _MOVED * step


def _outside(values: np.ndarray, begin: int, end: int) -> np.ndarray:
    return np.concatenate([values[:begin], values[end:]])
