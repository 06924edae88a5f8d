"""Faults that could have befallen runs of a device without a known controller.

No law ties what such a machine is asked to what is read of it: any channel may
be wrong, and the twin alone can tell.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from brace_drake.recording.columns import split_unit
from brace_drake.recording.recording import Run
from brace_drake.recording.samples import TELLING_ROWS
from brace_drake.recording_faults.channels import is_computed, is_desired
from brace_drake.recording_faults.library.channels import (
    exchanged_channels,
    moved_zero,
    reversed_sign,
    wrong_scale,
    zero_step,
)
from brace_drake.recording_faults.library.time import (
    lost_samples,
    reversed_run,
)
from brace_drake.recording_faults.relations.hypotheses import Hypothesis
from brace_drake.recording_faults.relations.time_faults import (
    CLOCKS,
    TimeFault,
    delays,
)

# Delays that are tried, samples.
_DELAYS = (1, 2, 3, 5, 8, 13, 21, 34)
_OF_WAYS = ("m", "rad")
# Beforehand a named unit is so much more likely than a number.
UNIT, OTHER = 1.0, 0.2


class Suspect(NamedTuple):
    """A fault that may be in some runs, and how likely it is beforehand."""

    hypothesis: Hypothesis
    weight: float


def of_time(runs: Sequence[Run], names: Sequence[str]) -> Iterator[Suspect]:
    """What can have befallen all of some runs: delays, order, lost blocks.

    Args:
        runs: Accused, all of them.
        names: Channels that the twin is compared in; all but these are given.
    """
    for name, fault in itertools.product(names, time_faults(runs[0])):
        for size in fault.signed():
            yield Suspect(fault.of((name,), size), OTHER)
    yield Suspect(Hypothesis(reversed_run.CARD, (), {}), OTHER)
    lost = _lost(runs)
    if lost is not None:
        yield Suspect(lost, UNIT)


def of_channels(
    runs: Sequence[Run],
    names: Sequence[str],
    gain: float,
    off: Mapping[str, Sequence[np.ndarray]],
) -> Iterator[Suspect]:
    """What can have befallen channels of a few among other runs: sign, unit,
    scale, zero, a zero that is set in mid-run, exchange.

    Args:
        runs, names: As of `of_time`.
        gain, off: As of `Readings`.
    """
    every = [n for n in runs[0].channels if n != "time_s"]
    for pair in itertools.combinations(every, 2):
        yield Suspect(Hypothesis(exchanged_channels.CARD, pair, {}), OTHER)
    for name in names:
        values = {"offset": float(np.mean([o.mean() for o in off[name]]))}
        yield Suspect(Hypothesis(moved_zero.CARD, (name,), values), OTHER)
        # At another time in each run.
        if len(runs) == 1:
            time = runs[0].time_s - runs[0].time_s[0]
            at, offset = zero_step.likeliest_step(off[name][0])
            values = {"offset": offset, "start_s": float(time[at])}
            yield Suspect(Hypothesis(zero_step.CARD, (name,), values), OTHER)
    for name in every:
        yield Suspect(
            Hypothesis(reversed_sign.CARD, (name,), {"zero": 0.0}), OTHER
        )
        units = wrong_scale.UNITS.get(split_unit(name)[1], {})
        for size in units.values():
            yield _scaled(name, size, UNIT)
        # A force that reads twice is like a way that reads half.
        if gain > 0.0:
            size = gain if name in names else 1.0 / gain
            near = any(abs(size / u - 1.0) < 0.02 for u in units.values())
            if not near:
                less = 1.0 if name in names else 0.5
                yield _scaled(name, size, OTHER * less)


def time_faults(run: Run) -> tuple[TimeFault, TimeFault]:
    """How channels of a run may be off in time."""
    period = float(np.median(np.diff(run.time_s)))
    return delays(period, _DELAYS), CLOCKS


def _scaled(name: str, scale: float, weight: float) -> Suspect:
    values = {"scale": scale, "zero": 0.0}
    return Suspect(Hypothesis(wrong_scale.CARD, (name,), values), weight)


def _lost(runs: Sequence[Run]) -> Hypothesis | None:
    """Blocks that are lost where a measured way jumps; None where none does.
    What is asked for may jump by itself.
    """
    for run in runs:
        for name in run.channels:
            is_asked = is_desired(name) or is_computed(name)
            if is_asked or split_unit(name)[1] not in _OF_WAYS:
                continue
            values = lost_samples.lost_of(run, name)
            if values is not None:
                return Hypothesis(lost_samples.CARD, (name,), values)
    return None


def is_usable(run: Run) -> bool:
    """Whether enough of a run is left with a fault undone."""
    return len(run.time_s) >= TELLING_ROWS
