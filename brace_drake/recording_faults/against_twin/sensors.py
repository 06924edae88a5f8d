"""Readings that no controller sees, against the twin that the others fit.

Markers, and forces across the push, enter no command. The subject is fitted
without them; where the twin then follows all else down to its floor, it says
what they should have read.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from brace_drake.devices.declaration import Device
from brace_drake.effects.stack import Use
from brace_drake.identification.evaluation import PreparedRun
from brace_drake.recording_faults.against_twin.misfit import (
    fit_subject_to,
    make_evaluator,
)
from brace_drake.recording_faults.against_twin.readings import (
    Reading,
    read_runs,
    unread_channels,
)
from brace_drake.recording_faults.against_twin.undone import time_faults
from brace_drake.recording_faults.finding import MOST_PROBABLE, Finding
from brace_drake.recording_faults.library.channels import (
    exchanged_channels,
    moved_zero,
    reversed_sign,
    wrong_scale,
)
from brace_drake.recording_faults.relations.hypotheses import Hypothesis
from brace_drake.recording_faults.relations.time_faults import refined_best
from brace_drake.recording_faults.statistics import is_noise_scaled

# Misfit of the channels left in that counts as followed.
NEAR = 0.5
# A channel is looked at from this mean square on, in floors, and restored at
# this one, or where so little of it is left.
_GROSS, _RESTORED, _LEFT = 10.0, 3.0, 0.02
# Gains nearer to 1 may be the machine's.
_GAIN = 0.2
# How the probability falls with the mean square that is left.
_SHARP = 4.0


class Bars(NamedTuple):
    """Mean squares of a channel, in floors, beyond which it is looked at, and
    below which it is restored, or where so little of it is left.
    """

    gross: float
    restored: float
    left: float


def find_sensor_faults(
    device: Device,
    runs: Sequence[PreparedRun],
    subject: np.ndarray,
    uses: Sequence[Use],
    jobs,
) -> list[Finding]:
    """Faults of readings that only the twin can tell.

    Args:
        device: With a control law.
        runs: To be judged, their weights as in the fit.
        subject: To start from.
        uses: Effects that are there, held.
        jobs: As of `Evaluator`.
    """
    names = unread_channels(device)
    if not names:
        return []
    readings = read_without(device, runs, runs, subject, uses, jobs)
    bars = Bars(_GROSS, _RESTORED, _LEFT)
    return list(named(readings, names, bars, len(readings)))


def read_without(
    device: Device,
    runs: Sequence[PreparedRun],
    some: Sequence[PreparedRun],
    subject: np.ndarray,
    uses: Sequence[Use],
    jobs,
) -> list[Reading]:
    """Some of the runs beside the twin that all fit, the unread channels of
    these left out; none where it does not.
    """
    names, accused = unread_channels(device), {p.run.file for p in some}
    told = np.array([c not in names for c in device.twin.channels])
    rest = [
        replace(p, weights=p.weights * told) if p.run.file in accused else p
        for p in runs
    ]
    evaluator = make_evaluator(device, rest, subject, uses, jobs)
    fit = fit_subject_to(evaluator, subject, uses)
    if fit is None or fit.misfit > NEAR:
        return []
    return read_runs(device, evaluator, some, fit.subject, uses)


def named(
    readings: Sequence[Reading],
    names: Sequence[str],
    bars: Bars,
    count: int,
) -> Iterator[Finding]:
    """What explains the runs whose readings are grossly off, together; of so
    many runs that could have it.
    """
    bad: list[tuple[Reading, dict[str, float]]] = []
    for reading in readings:
        found = reading.unread(names)
        if any(v > bars.gross for v in found.values()):
            bad.append((reading, found))
    if not bad:
        return
    accused = {n for _, f in bad for n, v in f.items() if v > bars.gross}
    tried = []
    for h in _hypotheses([r for r, _ in bad], sorted(accused)):
        left = _left(h, bad, accused)
        if left is not None:
            tried.append((left, h))
    if not tried:
        return
    tried += refined_best(
        time_faults(bad[0][0].prepared.run),
        tried,
        lambda h: _left(h, bad, accused),
    )
    tried.sort(key=lambda t: t[0])
    after, best = tried[0]
    before = float(np.mean([v for _, f in bad for v in f.values()]))
    if after > max(bars.restored, bars.left * before):
        return
    rivals = sum(
        (after / left) ** _SHARP
        for left, h in tried[1:]
        if set(h.channels) != set(best.channels)
    )
    yield Finding(
        best.fault,
        tuple(r.prepared.run.file for r, _ in bad),
        best.channels,
        dict(best.parameters),
        MOST_PROBABLE / (1.0 + rivals),
        f"{np.sqrt(before):.3g} noise floors off the twin that all other"
        f" channels fit, {np.sqrt(after):.3g} with it undone",
        of_all=len(bad) == count and count > 1,
        before=before,
        after=after,
    )


def _left(h: Hypothesis, bad, accused) -> float | None:
    """Mean square over runs of the accused channels with a fault undone."""
    found = []
    for reading, _ in bad:
        run = reading.prepared.run
        if not set(h.channels) <= set(run.channels):
            return None
        columns = h.undone(run).channels
        some = {*accused, *h.channels} & set(columns)
        squares = reading.squares({n: columns[n] for n in some})
        found += list(squares.values())
    return float(np.mean(found)) if found else None


def _hypotheses(
    readings: Sequence[Reading], names: Sequence[str]
) -> Iterator[Hypothesis]:
    """Faults of unread channels; gains and zeros as the twin asks for."""
    kinds = {n: n.rsplit("_", 2)[0].split("_")[0] for n in names}
    for pair in itertools.combinations(names, 2):
        if kinds[pair[0]] == kinds[pair[1]]:
            yield Hypothesis(exchanged_channels.CARD, pair, {})
    groups = [(n,) for n in names]
    for kind in sorted(set(kinds.values())):
        group = tuple(n for n in names if kinds[n] == kind)
        if len(group) > 1:
            groups.append(group)
    for group in groups:
        yield from _scaled(readings, group)
        for fault in time_faults(readings[0].prepared.run):
            yield from (fault.of(group, size) for size in fault.signed())


def _scaled(
    readings: Sequence[Reading], group: tuple[str, ...]
) -> Iterator[Hypothesis]:
    """Sign, scale and zero of a group, by least squares on the twin."""
    recorded, expected = [], []
    for reading in readings:
        for n in group:
            c = reading.names.index(n)
            rms = max(reading.prepared.floor.rms[c], 1e-12)
            recorded.append(reading.prepared.run.channels[n] / rms)
            expected.append(reading.expected[:, c] / rms)
    x, y = np.concatenate(recorded), np.concatenate(expected)
    if x @ x <= 0.0:
        return
    gain = float(x @ y / (x @ x))
    yield Hypothesis(reversed_sign.CARD, group, {"zero": 0.0})
    is_other = gain > 0.0 and abs(gain - 1.0) > _GAIN
    ratios = [r.noise_ratio(n) for r in readings for n in group]
    if is_other and is_noise_scaled(ratios, 1.0 / gain):
        values = {"scale": 1.0 / gain, "zero": 0.0}
        yield Hypothesis(wrong_scale.CARD, group, values)
    if len(group) == 1:
        c = readings[0].names.index(group[0])
        rms = max(readings[0].prepared.floor.rms[c], 1e-12)
        offset = float(np.mean(x - y)) * rms
        yield Hypothesis(moved_zero.CARD, group, {"offset": offset})
